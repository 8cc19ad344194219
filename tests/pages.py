"""Reads the commands of a page with the output that it shows, and runs them as a reader does."""

from __future__ import annotations

import os
import pty
import re
import select
import shlex
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import warm_hitab
from mentions import ROOT
from waiting import within

from hitab_client.terminal.cli_remedies import CALLED_AS

LEFT_OUT = "[...]"
"""Stands for output that a page leaves out."""

VARYING = (
    (r"\d+\.\d+ s\b", "a time"),
    (r"ROS domain \d+", "the domain"),
)
"""What may differ from what a page shows, and nothing else: patterns and names for them."""

PATIENCE = 60.0
"""Seconds for what only looks, such as `hitab tree`, to show what the page shows."""

LONGEST = 240.0
"""Seconds after which a command hangs."""

LOOKING = re.compile(r"(scripts/)?hitab (status|tree|examples|vocabulary|library show)\b")
_COMMAND = re.compile(r"(hitab|scripts/|\. scripts/)")
ENDLESS = re.compile(r"(scripts/)?hitab (studio\b|.*--watch\b)")
"""What ends with Ctrl-C only."""


@dataclass
class Step:
    """A command of a page.

    Attributes:
        place: page and line.
        command: as it is typed.
        shown: the output that the page shows; empty if none.
    """

    place: str
    command: str
    shown: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        return f"{self.place}: {self.command}"


def steps_of(page: str) -> list[Step]:
    """Return the commands of a page, in order.

    They are in indented blocks: lines after ``$``, or, in a block without output, all lines that
    begin with `hitab`, ``scripts/`` or ``. scripts/``.
    """
    steps: list[Step] = []
    for number, block in _blocks((ROOT / page).read_text(encoding="utf-8")):
        prompted = any(line.startswith("$ ") for line in block)
        continued = False
        for i, line in enumerate(block, number):
            typed = line[2:] if line.startswith("$ ") else line
            begins = prompted and typed != line
            begins = begins or (not prompted and bool(_COMMAND.match(line)))
            if continued:
                steps[-1].command = steps[-1].command.removesuffix("\\") + line.strip()
            elif begins:
                steps.append(Step(f"{page}:{i}", typed))
            elif prompted and steps and line:
                steps[-1].shown.append(line)
            continued = (continued or begins) and line.endswith("\\")
    return steps


def _blocks(text: str) -> Iterator[tuple[int, list[str]]]:
    """Go through the indented blocks with the numbers of their first lines, fenced code aside."""
    block: list[str] = []
    fenced = False
    for number, line in enumerate([*text.splitlines(), "end"], 1):
        if line.startswith("```"):
            fenced = not fenced
        if line.startswith("    ") and not fenced:
            block.append(line[4:].rstrip())
        elif line.strip() or not block:
            if any(block):
                yield number - len(block), block
            block = []
        else:
            block.append("")


def pattern(shown: list[str]) -> re.Pattern[str]:
    """Return what output has to match: as shown, but for line breaks and what varies."""
    words = " ".join(" ".join(shown).split())
    pieces = []
    for part in re.split(f"({'|'.join(text for text, _ in VARYING)})", words):
        varying = next((text for text, _ in VARYING if re.fullmatch(text, part)), None)
        pieces.append(varying or re.escape(part).replace(re.escape(LEFT_OUT), ".*"))
    return re.compile("".join(pieces))


def matches(output: str, shown: list[str]) -> bool:
    """Whether output is what a page shows."""
    return pattern(shown).fullmatch(" ".join(output.split())) is not None


class Reader:
    """Types the commands of a page, in a folder that looks like the checkout.

    Attributes:
        folder: where the reader is.
    """

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self.folder = folder
        for path in ROOT.iterdir():
            if not path.name.startswith("."):
                (folder / path.name).symlink_to(path)
        bin_folder = str(Path(sys.executable).parent)
        self._environment = {
            # NiceGUI behaves otherwise where it believes to be tested.
            **{k: v for k, v in environment.items() if not k.startswith("PYTEST_")},
            "PATH": os.pathsep.join([bin_folder, environment.get("PATH", os.defpath)]),
        }

    def type(self, step: Step) -> str:
        """Run a command; return what is wrong, or ""."""
        if ENDLESS.match(step.command):
            return self._watch(step)
        output = ""

        def as_shown() -> bool:
            nonlocal output
            status, out, err = self._run(step.command)
            failed = status != 0
            output = out + err if failed else out
            error_shown = any(line.startswith("error: ") for line in step.shown)
            return failed == error_shown and (not step.shown or matches(output, step.shown))

        patience = PATIENCE if LOOKING.match(step.command) else 0.0
        if within(patience, as_shown):
            return ""
        return f"{step}\nprinted:\n{output}\nthe page shows:\n" + "\n".join(step.shown)

    def _run(self, command: str) -> tuple[int, str, str]:
        words = shlex.split(command, comments=True)
        if words[0] in ("hitab", "scripts/hitab"):  # that the script sets up is tested elsewhere
            environment = {**self._environment, CALLED_AS: words[0]}
            return warm_hitab.run(("hitab", *words[1:]), self.folder, environment, LONGEST)
        done = self._start(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            out, err = done.communicate(timeout=LONGEST)
        except subprocess.TimeoutExpired:
            os.killpg(done.pid, signal.SIGKILL)
            raise
        return done.returncode, out, err

    def _watch(self, step: Step) -> str:
        """Start what ends with Ctrl-C only on a terminal, wait for its first line and end it."""
        with socket.create_server(("127.0.0.1", 0)) as free:
            apart = f"studio --no-browser --port {free.getsockname()[1]}"
        command = re.sub(r"\bstudio\b", apart, step.command, count=1)
        screen, inner = pty.openpty()
        process = self._start(command, stdout=inner, stderr=inner)
        os.close(inner)
        seen = ""
        interrupted = False
        deadline = time.monotonic() + LONGEST
        while time.monotonic() < deadline and (more := _read(screen)) is not None:
            seen += more
            if re.search(r"\S\r?\n", seen) and not interrupted:
                os.killpg(process.pid, signal.SIGINT)
                interrupted = True
        os.close(screen)
        process.kill()
        right = interrupted and process.wait() in (0, 130) and "Traceback" not in seen
        return "" if right else f"{step}\nended with {process.returncode}, after:\n{seen}"

    def _start(self, command: str, stdout: int, stderr: int) -> subprocess.Popen[str]:
        return subprocess.Popen(
            ["bash", "-c", command],
            cwd=self.folder,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=stdout,
            stderr=stderr,
            text=True,
            start_new_session=True,
        )


def _read(screen: int) -> str | None:
    """Return what has come on a terminal within a moment; None if the writer has ended."""
    if not select.select([screen], [], [], 0.1)[0]:
        return ""
    try:
        return os.read(screen, 10_000).decode(errors="replace") or None
    except OSError:
        return None
