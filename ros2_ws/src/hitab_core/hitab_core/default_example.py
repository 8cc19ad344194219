"""Default examples: a command also means to continue the commanded behavior until the next one.

Source: the paper, section 3, footnote 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hitab_core.example import Example, ExampleKind


def default_example(taught: Example, entered: tuple[float, ...]) -> Example:
    """Return the default example beside that of a command: it stays in the commanded state.

    Args:
        taught: the example of the command.
        entered: the values of the features on entering the commanded state.
    """
    return replace(
        taught,
        state=taught.next_state,
        features=entered,
        number=taught.number + 1,
        kind=ExampleKind.DEFAULT,
        numbers=(),
    )


def superseding(examples: Sequence[Example]) -> list[Example]:
    """Return examples with each default one marked that a command contradicts.

    A command outranks what was only assumed: a default example says to stay in a state, an
    ordinary one with the same values to leave it. Without the mark, the two would make a coin toss
    of each decision there.
    """
    left = {example.place for example in examples if example.leaves}
    return [marked(example, example.place in left) for example in examples]


def marked(example: Example, contradicted: bool) -> Example:
    """Return an example; a default one as superseded if a command contradicts it."""
    if not example.is_default:
        return example
    kind = ExampleKind.SUPERSEDED if contradicted else ExampleKind.DEFAULT
    return example if example.kind is kind else replace(example, kind=kind)
