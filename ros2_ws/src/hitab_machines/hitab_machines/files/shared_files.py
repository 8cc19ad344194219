"""Files of a machine that other machines may list and read."""

from __future__ import annotations

import hashlib
import itertools
import os
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from hitab_msgs.msg import MachineFile

from hitab_core import HitabError

ANSWER_BYTES_MAX = 8_000_000
"""Maximum size of the files in an answer, and so of one file."""

FILES_MAX = 20_000
"""Maximum number of files in a listing, as of items in a message."""

READ_MAX = 500
"""Maximum number of files in an answer, whose sender gives no signs of life meanwhile."""

Mark = tuple[int, int, int]
"""Size, time of the last change and inode of a file."""


def safe_path(path: str) -> PurePosixPath:
    """Return a path from the network: relative, plain, and never out of its folder.

    Raises:
        HitabError: if it is any other.
    """
    plain = PurePosixPath(path)
    odd = not path or plain.is_absolute() or ".." in plain.parts or str(plain) != path
    if odd or not path.isprintable() or "\\" in path:
        raise HitabError(
            f'"{path[:80]}" is not a path in a shared folder; paths are relative, without ".."'
        )
    return plain


class SharedFiles:
    """The files in some folders, with digests; a digest is calculated once for each change.

    Args:
        roots: folders by the first part of the paths, and files by their whole paths.
        without: paths of folders that are not shared.
    """

    def __init__(self, roots: Mapping[str, Path], without: Collection[str] = ()) -> None:
        self._without = without
        self._roots = {name: path.absolute() for name, path in roots.items()}
        self._digests: dict[str, tuple[Mark, str]] = {}

    def marks(self) -> dict[str, Mark]:
        """Return size and time of each file, by path; opens none."""
        found: dict[str, Mark] = {}
        for name, root in self._roots.items():
            for path, mark in _walk(root):
                if len(found) < FILES_MAX:
                    inner = os.path.relpath(path, root)
                    shared = name if inner == "." else f"{name}/{inner}"
                    if os.path.dirname(shared) not in self._without:
                        found[shared] = mark
        return found

    def token(self) -> str:
        """Return a text that changes with any of the files; opens none."""
        listing = sorted(self.marks().items())
        return hashlib.sha256(repr(listing).encode()).hexdigest()[:16] if listing else ""

    def digests(self) -> dict[str, str]:
        """Return the digest of each file, by path."""
        known, self._digests = self._digests, {}
        for path, mark in self.marks().items():
            before = known.get(path)
            if before is not None and before[0] == mark:
                self._digests[path] = before
                continue
            try:
                digest = digest_of(self._place(path).read_bytes())
            except OSError:  # it has gone in the meantime
                continue
            self._digests[path] = (mark, digest)
        return {path: digest for path, (_, digest) in self._digests.items()}

    def read(self, paths: Iterable[str]) -> list[MachineFile]:
        """Return the first files that fit into an answer, all as of one moment.

        A database and its log belong together, so nothing may change while they are read.

        Raises:
            HitabError: if a path is not of a shared file, changes meanwhile, or is too large.
        """
        files: list[MachineFile] = []
        size, marks = 0, {}
        for path in itertools.islice(paths, READ_MAX):
            place = self._place(path)
            try:
                marks[place] = _mark(place)
                size += marks[place][0]
                if size > ANSWER_BYTES_MAX:
                    break
                data = place.read_bytes()
            except OSError as error:
                raise HitabError(f"{path} cannot be read ({error.strerror}); try again") from None
            files.append(MachineFile(path=path, digest=digest_of(data), data=data))
        if size and not files:
            raise HitabError(
                f"{path} has {size:,} bytes; at most {ANSWER_BYTES_MAX:,} are copied: save the "
                "training, or copy the file by hand"
            )
        for place, mark in marks.items():
            if not place.exists() or _mark(place) != mark:
                raise HitabError(f"{place.name} has changed while it was read; try again")
        return files

    def _place(self, path: str) -> Path:
        first, *inner = (path,) if path in self._roots else safe_path(path).parts
        root = self._roots.get(first)
        place = root.joinpath(*inner) if root is not None else None
        if root is None or place is None or not place.resolve().is_relative_to(root.resolve()):
            raise HitabError(f'"{path[:80]}" is not among the shared files')
        return place


def digest_of(data: bytes) -> str:
    """Return the digest of a file's contents."""
    return hashlib.sha256(data).hexdigest()


def _mark(path: str | Path) -> Mark:
    found = os.stat(path, follow_symlinks=False)
    return found.st_size, found.st_mtime_ns, found.st_ino


def _walk(root: Path) -> Iterator[tuple[str, Mark]]:
    """Yield the regular files of a folder; links lead out of it."""
    if root.is_file():
        yield str(root), _mark(root)
    folders = [str(root)]
    while folders:
        try:
            with os.scandir(folders.pop()) as entries:
                for entry in entries:
                    if entry.is_dir(follow_symlinks=False):
                        folders.append(entry.path)
                    elif entry.is_file(follow_symlinks=False) and entry.name.isprintable():
                        found = entry.stat(follow_symlinks=False)
                        yield entry.path, (found.st_size, found.st_mtime_ns, found.st_ino)
        except OSError:  # it has gone in the meantime, or is no folder
            continue
