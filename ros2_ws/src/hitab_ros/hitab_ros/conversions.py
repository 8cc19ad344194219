"""Between messages and the engine's own types."""

from __future__ import annotations

from collections.abc import Sequence

from builtin_interfaces.msg import Time
from hitab_msgs import msg

from hitab_core.example import Example
from hitab_core.use import Use

NANOSECONDS = 1_000_000_000


def time_of(seconds: float) -> Time:
    """Return simulated seconds as a stamp."""
    whole = round(seconds * NANOSECONDS)
    return Time(sec=whole // NANOSECONDS, nanosec=whole % NANOSECONDS)


def example_message(example: Example) -> msg.Example:
    """Return an example as a message."""
    return msg.Example(
        number=example.number,
        state=example.state,
        next_state=example.next_state,
        values=list(example.features),
        kind=example.kind.value,
        command=example.command,
        cycle=example.cycle,
    )


def use_of(name: str, arguments: Sequence[str]) -> Use:
    """Return a behavior with its targets; a name such as ``GoTo(ball)`` has its own.

    Raises:
        VocabularyError: if the name has another form.
    """
    use = Use.parse(name)
    return Use(use.name, (*use.arguments, *arguments))
