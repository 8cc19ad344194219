"""Default examples ⟨S_t+1, f_t, S_t+1⟩: a commanded state is kept until the next command.

Source: the paper, section 3, "Training with HiTAB" and footnote 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hitab_core.example import Example, ExampleKind


def default_example(commanded: Example, features: tuple[float, ...]) -> Example:
    """Return the default example of a command: stay in the commanded state.

    Args:
        commanded: the example ⟨S_t, f_t, S_t+1⟩ of the command.
        features: f_t with flags and timers as they are on entry into S_t+1 (`as_entered`).
    """
    return replace(
        commanded,
        state=commanded.next_state,
        features=features,
        number=commanded.number + 1,
        kind=ExampleKind.DEFAULT,
        numbers=(),
    )


def superseding(examples: Sequence[Example]) -> list[Example]:
    """Return the examples; default ones that a command contradicts become superseded.

    A default example is only assumed: stay in a state. If a command left that state at the same
    feature values, the command counts. With both examples, each decision there would be random.
    """
    left = {example.place for example in examples if example.leaves}
    return [marked(example, example.place in left) for example in examples]


def marked(example: Example, contradicted: bool) -> Example:
    """Return the example; a default one becomes superseded, or default again if uncontradicted."""
    if not example.is_default:
        return example
    kind = ExampleKind.SUPERSEDED if contradicted else ExampleKind.DEFAULT
    return example if example.kind is kind else replace(example, kind=kind)
