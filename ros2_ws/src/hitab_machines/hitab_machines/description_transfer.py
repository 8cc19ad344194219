"""Transfer of a swarm's description from a machine that is up to one that has no file."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

from hitab_msgs.msg import MachineFile, MachineStatus
from hitab_msgs.srv import ReadFiles

from hitab_bringup import DESCRIPTION
from hitab_client import RosLink, SwarmError, domain_ids
from hitab_client.connecting.identity import is_identity
from hitab_core import HitabError, some
from hitab_core.library.yaml_places import open_yaml
from hitab_machines.files.shared_files import digest_of, safe_path
from hitab_ros import names, qos
from hitab_ros.timing import START_S

FILES_MAX = 2000
"""Maximum number of files of a description."""

BYTES_MAX = 100_000_000
"""Maximum size of all files of a description."""

SUFFIXES = {".yaml", ".yml", ".json", ".md", ".txt"}
"""Suffixes of the files that are taken: data, never code."""


def fetch_description(
    swarm: str, folder: Path, announce: Callable[[str], None] = lambda text: None
) -> Path:
    """Copy the description of a swarm from one of its machines, and return the swarm file.

    Args:
        swarm: the swarm's name.
        folder: run folder of the swarm on this machine.
        announce: called with the reason of a wait.

    Raises:
        SwarmError: if no machine of the swarm is up, or it sends what cannot be a description.
    """
    with RosLink(domain_ids.for_swarm(is_free=False), announce) as link:
        machine, prefix = _find_machine(link, swarm)
        files = _read_all(link, machine, f"{prefix}/{machine}/{names.READ_FILES}")
    return _write(files, folder / DESCRIPTION, machine)


def _find_machine(link: RosLink, swarm: str) -> tuple[str, str]:
    """Return the name of a machine of a swarm, and the swarm's namespace."""
    found: dict[tuple[str, str], str] = {}
    heard: set[str] = set()
    topics: set[str] = set()

    def look() -> bool:
        for topic in {*link.topics_of_type(names.MACHINE_TYPE)} - topics:
            topics.add(topic)
            prefix = topic.removesuffix(f"/{names.MACHINES}")

            def take(status: MachineStatus, prefix: str = prefix) -> None:
                name = re.fullmatch(r"\w{1,100}", status.machine, re.ASCII)
                if name is not None and is_identity(status.swarm):
                    heard.add(status.swarm.rpartition("-")[0])
                    if status.swarm.rpartition("-")[0] == swarm:
                        found[status.swarm, prefix] = status.machine

            link.subscribe(MachineStatus, topic, take, qos.SIGNS_OF_LIFE)
        return bool(found)

    if not link.spin_until(look, START_S, waiting_for=lambda: f"a machine of swarm {swarm}"):
        others = f" (machines of {some(sorted(heard))} are)" if heard else ""
        raise SwarmError(
            f"there is no file {swarm}, and no machine of a swarm {swarm} is up in ROS domain "
            f"{link.node.context.get_domain_id()}{others}: start first the machine that has the "
            "file, or name the file; `hitab doctor --network 10` shows which computers are heard"
        )
    (_, prefix), machine = min(found.items())
    return machine, prefix


def _read_all(link: RosLink, machine: str, service: str) -> dict[str, bytes]:
    """Return the contents of all files of a description, by path."""

    def ask(paths: list[str]) -> list[MachineFile]:
        request = ReadFiles.Request(kind=ReadFiles.Request.DESCRIPTION, paths=paths)
        answer = link.call(
            ReadFiles,
            service,
            request,
            missing=lambda: SwarmError(f"{machine} does not offer {service}; start it again"),
            where=machine,
        )
        return list(answer.files)

    listed = {file.path: file.digest for file in ask([])}
    if len(listed) > FILES_MAX:
        raise SwarmError(f"{machine} describes its swarm with {len(listed)} files; {_BY_HAND}")
    for path in listed:
        _check(path, machine)
    contents: dict[str, bytes] = {}
    while missing := [path for path in listed if path not in contents]:
        came = {file.path: bytes(file.data) for file in ask(missing) if file.path in missing}
        for path, data in came.items():
            if digest_of(data) != listed[path]:
                raise SwarmError(f"{path} on {machine} is being changed; start again")
        contents |= came
        if not came or sum(map(len, contents.values())) > BYTES_MAX:
            raise SwarmError(f"{machine} does not send {some(missing)}; {_BY_HAND}")
    return contents


_BY_HAND = "copy the swarm file and the files that it names by hand, and name the file"


def _check(path: str, machine: str) -> None:
    """Refuse a path that leads out of its folder, or a file that is not data."""
    try:
        plain = safe_path(path)
    except HitabError as error:
        raise SwarmError(f"{machine} sends files, but {error.problem}; {_BY_HAND}") from None
    if plain.suffix not in SUFFIXES:
        kinds = ", ".join(sorted(SUFFIXES))
        raise SwarmError(f"{machine} sends {path[:80]}, but only {kinds} are taken; {_BY_HAND}")


def _write(contents: dict[str, bytes], folder: Path, machine: str) -> Path:
    """Write the files in place of those of an earlier start, and return the swarm file."""
    shutil.rmtree(folder, ignore_errors=True)
    for path, data in contents.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)
    for path in contents:
        if _has_machines(folder / path):
            return folder / path
    raise SwarmError(f"{machine} has sent no swarm file with `machines:`; {_BY_HAND}")


def _has_machines(file: Path) -> bool:
    try:
        document = open_yaml(file, error=SwarmError)
    except HitabError:
        return False
    return isinstance(document.value, dict) and "machines" in document.value
