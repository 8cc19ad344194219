"""A file with behaviors and everything they are made of, to mail or to keep: one YAML file.

It is a bundle (see `hitab_core.library.bundle`) with a format version, and holds the behavior
files word for word.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from hitab_core.hierarchy import in_order
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.bundle import bundle_digest
from hitab_core.library.yaml_places import read_text, read_yaml
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.vocabulary import has

if TYPE_CHECKING:
    from hitab_core.library.bundle_model import BundleFile

BUNDLE_FORMAT = 1
"""The format version that is written, and the newest that is read."""

OWN_KEYS = re.compile(r"^(digest|files):", re.MULTILINE)
"""At least one of these is in every file with behaviors, also in one that was cut off."""

_HEAD = """\
# Trained behaviors, each after those that it uses. Read them into a library:
#   hitab library import FILE -l FOLDER
"""


def texts_with_parts(files: Mapping[str, BehaviorFile], names: Iterable[str]) -> dict[str, str]:
    """Return the texts of some behaviors and of all their parts, parts first.

    Args:
        files: files of the library, all of which can be used.
        names: names of the behaviors.

    Raises:
        LibraryError: if there is no behavior of one of these names.
    """
    names = sorted(names)
    for name in names:
        if name not in files:
            raise LibraryError(f'there is no behavior "{name}" to export {has(files, name)}')

    def uses(name: str) -> Iterable[str]:
        return files[name].automaton.behaviors_used & files.keys()

    return {name: files[name].text for name in in_order(names, uses)}


def bundle_file_text(texts: Mapping[str, str], domain: str) -> str:
    """Return the text of a file with some behaviors, given the texts of their files.

    Args:
        texts: texts by name, each after its parts.
        domain: name of the domain in which they were trained.
    """
    content = {
        "format": BUNDLE_FORMAT,
        "domain": domain,
        "digest": bundle_digest(tuple(texts.items())),
        "files": {name: _Block(text) for name, text in texts.items()},
    }
    dumped = yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=10_000)
    return f"{_HEAD}{dumped}"


def read_bundle_file(path: Path) -> BundleFile:
    """Read a file; whether its behaviors are sound is up to `LibraryReader.read_all`.

    Raises:
        LibraryError: naming everything wrong with it.
    """
    text = read_text(path)
    if OWN_KEYS.search(text) is None:  # faults of its contents would not help then
        raise LibraryError(
            f"{path}: is not a file of behaviors; give one that was exported from a library"
        )
    from hitab_core.library.bundle_model import BundleFile
    from hitab_core.library.yaml_models import open_record

    return open_record(BundleFile, read_yaml(text, str(path)), BUNDLE_FORMAT)


class _Block(str):
    """A text written as a block, line by line."""

    __slots__ = ()


class _Dumper(yaml.SafeDumper):
    """Writes `_Block`; PyYAML quotes a text that a block cannot hold."""


def _represented(dumper: _Dumper, text: _Block) -> Any:
    return dumper.represent_scalar("tag:yaml.org,2002:str", str(text), style="|")


_Dumper.add_representer(_Block, _represented)
