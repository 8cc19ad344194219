"""Finds the commands that texts of this project mention: errors, help, comments and pages."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PLACEHOLDER = "X"
"""Stands for what a text fills in."""

PAGES = ("*.md", "docs/**/*.md", "research/*.md")
COMMENTED = ("ros2_ws/src/**/*.yaml", "ros2_ws/src/**/*.msg", "ros2_ws/src/**/*.srv")
SOURCES = ("ros2_ws/src/**/*.py", "research/*.py", "examples/**/*.py")
SCRIPTS = ("setup", "test", "hitab", "env.sh", "lock", "python", "docs")

_STARTS = r"(?:scripts/)?hitab|scripts/(?:setup|test|lock|python|docs)|python -m"
_QUOTED = re.compile(rf"(?<!`)`(?:\$ )?((?:{_STARTS}) [^`]+)`(?!`)")
_LINE = re.compile(rf"^\s*(?:[#>]\s*)*(?:\$ )?((?:{_STARTS}) [a-z-].*)$")


@dataclass(frozen=True)
class Mention:
    """A command line that a text mentions.

    Attributes:
        place: the file, and the line where its text begins.
        words: of the command line; the first is the program.
        in_passing: whether it is named within a sentence, where arguments may be left out.
    """

    place: str
    words: tuple[str, ...]
    in_passing: bool

    def __str__(self) -> str:
        return f"{self.place}: {' '.join(self.words)}"


def mentions() -> Iterator[Mention]:
    """Go through all that is mentioned."""
    for place, text in texts():
        joined = re.sub(r"\\\n\s*", "", text)
        for match in _QUOTED.finditer(joined):
            if "\n\n" not in match[1]:
                yield from _mention(place, " ".join(match[1].split()), in_passing=True)
        for line in joined.splitlines():
            if (match := _LINE.match(line)) and "`" not in line:
                yield from _mention(place, match[1], in_passing=False)


def _mention(place: str, text: str, *, in_passing: bool) -> Iterator[Mention]:
    text = re.split(r"\s[#·]\s|\s{3,}|\s[|>&<]|;", text)[0].strip().rstrip(".,:")
    try:
        words = shlex.split(text.replace("…", "..."))
    except ValueError:  # cut off in the middle of a quotation
        return
    yield Mention(place, tuple(words), in_passing)


def texts() -> Iterator[tuple[str, str]]:
    """Go through all texts that a user may read, with their places."""
    for path in _files(PAGES):
        yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")
    for path in _files(COMMENTED):
        comments = re.findall(r"#.*", path.read_text(encoding="utf-8"))
        yield path.relative_to(ROOT).as_posix(), "\n".join(comments)
    for path in _files(SOURCES):
        yield from strings(path)
    for name in SCRIPTS:
        yield f"scripts/{name}", (ROOT / "scripts" / name).read_text(encoding="utf-8")


def _files(patterns: tuple[str, ...]) -> Iterator[Path]:
    for pattern in patterns:
        for path in sorted(ROOT.glob(pattern)):
            if not {"test", "build", "install"} & set(path.relative_to(ROOT).parts):
                yield path


def strings(path: Path) -> Iterator[tuple[str, str]]:
    """Go through the strings of a Python file, filled in where they are made up of parts."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    inner = {
        id(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.JoinedStr)
        for part in node.values
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            text = "".join(
                str(part.value) if isinstance(part, ast.Constant) else PLACEHOLDER
                for part in node.values
            )
        elif (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in inner
        ):
            text = node.value
        else:
            continue
        yield f"{path.relative_to(ROOT).as_posix()}:{node.lineno}", text
