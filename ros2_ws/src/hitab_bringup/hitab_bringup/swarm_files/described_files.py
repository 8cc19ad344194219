"""Files that describe a swarm on several machines: the swarm file, and those that it names."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path

from hitab_bringup.libraries.library_choice import known_libraries, shipped_libraries
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_bringup.swarm_files.swarm_file import FORMAT, PYTHON_SUFFIX
from hitab_bringup.swarm_files.swarm_lines import SwarmLines
from hitab_client import DescriptionError
from hitab_core import installed_version
from hitab_core.library.yaml_models import open_record
from hitab_core.library.yaml_places import open_yaml

DESCRIPTION = "description"
"""Folder in a run folder with the files that describe the swarm."""


def described_files(swarm: SwarmDescription) -> dict[str, Path]:
    """Return the files with which another machine can start its part, by their relative paths.

    These are the swarm file, kinds of commanders and libraries to start from, without those that
    are shipped with HiTAB. The folders between them stay, so that the swarm file finds the others.

    Raises:
        DescriptionError: if the swarm needs Python files, which are never sent.
    """
    lines, base = _lines(swarm), _folder(swarm)
    if code := [*_code(lines)]:
        raise DescriptionError(
            f"{swarm.file}: {code[0]} is a Python file, which is not sent to other machines; copy "
            "it there beside this file, and start with the file's path"
        )
    return _by_relative_path(_files(swarm, lines, base))


def keep_description(swarm: SwarmDescription, folder: Path) -> Path:
    """Copy what describes a swarm into its run folder, so that later edits change nothing.

    Returns:
        The copy of the swarm file.
    """
    kept = (folder / DESCRIPTION).resolve()
    if swarm.file.resolve().is_relative_to(kept):
        return swarm.file  # another machine has sent it
    lines, base = _lines(swarm), _folder(swarm)
    code = {_normal(base / text): base / text for text in _code(lines)}
    shutil.rmtree(kept, ignore_errors=True)
    files = _by_relative_path(_files(swarm, lines, base) | code)
    for path, file in files.items():
        (kept / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, kept / path)
    return next(kept / path for path, file in files.items() if file == swarm.file)


def _files(swarm: SwarmDescription, lines: SwarmLines, base: Path) -> dict[str, Path]:
    """Return the files that describe a swarm, without Python files, by their normal paths."""
    found = {_normal(base / swarm.file.name): swarm.file, **_kinds(lines, base)}
    shipped = {path.resolve() for path in shipped_libraries().values()}
    for line in (lines, *lines.agents.values(), *lines.commanders.values()):
        beside = base / line.start_from
        library = beside if beside.is_dir() else known_libraries().get(line.start_from, beside)
        if line.start_from and (library == beside or library.resolve() not in shipped):
            found |= {
                _normal(beside / file.name): file
                for file in sorted(library.iterdir())
                if file.is_file() and not file.name.startswith(".")
            }
    return found


def _by_relative_path(found: Mapping[str, Path]) -> dict[str, Path]:
    root = os.path.commonpath([os.path.dirname(path) for path in found])
    return {Path(path).relative_to(root).as_posix(): file for path, file in found.items()}


def description_digest(swarm: SwarmDescription) -> str:
    """Return a digest that differs if machines would start parts of different swarms.

    It covers the swarm file, the files of kinds, Python files that it names, and HiTAB's version.
    """
    lines, base = _lines(swarm), _folder(swarm)
    files = {os.path.relpath(path, base): file for path, file in _kinds(lines, base).items()}
    files |= {text: base / text for text in _code(lines)}
    contents = {name: _digest(file) for name, file in sorted(files.items())}
    text = json.dumps([installed_version(), _digest(swarm.file), contents])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _lines(swarm: SwarmDescription) -> SwarmLines:
    return open_record(SwarmLines, open_yaml(swarm.file, error=DescriptionError), FORMAT)


def _folder(swarm: SwarmDescription) -> Path:
    return swarm.file.parent.absolute()


def _normal(path: Path) -> str:
    return os.path.normpath(path)


def _kinds(lines: SwarmLines, base: Path) -> dict[str, Path]:
    named = (kind for kind in lines.kinds.values() if isinstance(kind, str))
    return {_normal(base / kind): base / kind for kind in named}


def _code(lines: SwarmLines) -> Iterator[str]:
    """Yield the Python files that a swarm file names."""
    named = [line.domain for line in (lines, *lines.agents.values())]
    named += [lines.world.kind] if lines.world is not None else []
    yield from sorted({text for text in named if text.endswith(PYTHON_SUFFIX)})


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
