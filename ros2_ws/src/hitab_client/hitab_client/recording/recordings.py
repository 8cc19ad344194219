"""Recordings of runs: list, find, rename and delete them."""

from __future__ import annotations

import re
import time
from dataclasses import dataclass
from pathlib import Path

from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import state_home

RECORDING_SUFFIX = ".mcap"
RECORDING_NAME = re.compile(r"\w[\w .+()-]{0,99}", re.ASCII)
RECORDING_NAME_RULE = (
    "letters, digits, spaces, and . _ + - ( ); the first one is a letter or a digit"
)


@dataclass(frozen=True)
class Recorded:
    """A recording of a run.

    Attributes:
        when: time of the last recorded message, s since 1970.
        size: size of the file, bytes.
    """

    path: Path
    when: float
    size: int


def recordings_folder() -> Path:
    """Return the folder of recordings."""
    return state_home() / "recordings"


def new_recording(swarm: str) -> Path:
    """Return the path of the next recording."""
    stamp = time.strftime("%Y-%m-%d_%H-%M-%S")
    return recordings_folder() / f"{swarm or 'swarm'}_{stamp}{RECORDING_SUFFIX}"


def recordings() -> list[Recorded]:
    """Return the recordings, newest first."""
    found = []
    for path in recordings_folder().glob(f"*{RECORDING_SUFFIX}"):
        try:
            stat = path.stat()
        except OSError:
            continue  # just deleted
        found.append(Recorded(path, stat.st_mtime, stat.st_size))
    return sorted(found, key=lambda recorded: recorded.when, reverse=True)


def recording(name: str) -> Path:
    """Return the file of a recording.

    Raises:
        SwarmError: if there is no recording of this name.
    """
    path = recordings_folder() / name
    if path.parent != recordings_folder() or path.suffix != RECORDING_SUFFIX or not path.is_file():
        raise SwarmError(f'There is no recording "{name}" in {recordings_folder()}.')
    return path


def rename(name: str, new: str) -> Path:
    """Give a recording another name, and return its file.

    Args:
        name: name of the recording's file.
        new: new name, with or without the suffix.

    Raises:
        SwarmError: if there is no such recording, the new name is invalid or taken, or the
            folder cannot be written.
    """
    path, stem = recording(name), new.strip().removesuffix(RECORDING_SUFFIX)
    if RECORDING_NAME.fullmatch(stem) is None:
        raise SwarmError(f'"{new}" cannot be the name of a recording: use {RECORDING_NAME_RULE}.')
    goal = path.with_name(f"{stem}{RECORDING_SUFFIX}")
    if goal == path:
        return path
    try:
        goal.hardlink_to(path)  # fails if the name is taken
        path.unlink()
    except FileExistsError:
        raise SwarmError(f'There is a recording "{goal.name}" already: choose another.') from None
    except OSError as error:
        raise SwarmError(f"{path} cannot be renamed: {error.strerror}.") from None
    return goal


def delete(name: str) -> None:
    """Delete a recording.

    Raises:
        SwarmError: if there is no such recording, or it cannot be deleted.
    """
    path = recording(name)
    try:
        path.unlink()
    except OSError as error:
        raise SwarmError(f"{path} cannot be deleted: {error.strerror}.") from None
