"""Other names for what the nodes of a host use, since each of them takes its own arguments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

OWN_NAMES = ("__ns", "__node", "__name")


def remaps_of(arguments: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield the remappings on a command line, without those of a node's own name or namespace."""
    inside, expected = False, False
    for argument in arguments:
        if argument in ("--ros-args", "--"):
            inside, expected = argument == "--ros-args", False
        elif expected:
            name, is_rule, other = argument.partition(":=")
            if is_rule and name not in OWN_NAMES:
                yield name, other
            expected = False
        else:
            expected = inside and argument in ("-r", "--remap")


def cli_args(remaps: Iterable[tuple[str, str]]) -> list[str]:
    """Return arguments for a node; of two rules for a name, the first counts."""
    rules = [part for name, other in remaps for part in ("-r", f"{name}:={other}")]
    return ["--ros-args", *rules] if rules else []
