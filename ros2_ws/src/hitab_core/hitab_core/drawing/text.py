"""An automaton in plain text: its states, its transitions and its trees."""

from __future__ import annotations

from collections.abc import Iterable

from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.drawing.graph import NO_RULES, Arrow, arrows
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.texts.wording import quantity


def automaton_as_text(automaton: Automaton, *, trees: bool = True) -> str:
    """Return an automaton for people to read.

    Args:
        automaton: to show.
        trees: also draw the tree of each state, with the number of examples at each leaf.

    Examples:
        >>> from hitab_core import LearningAgent, plain_domain
        >>> cart = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position"])
        >>> agent = LearningAgent(cart).train("Shuttle")
        >>> _ = agent.step([0.0], command="Right"), agent.step([5.0], command="Left")
        >>> print(automaton_as_text(agent.learn(), trees=False))
        Shuttle
          features: Position
          examples: 4
        <BLANKLINE>
          Start
            -> Right always
        <BLANKLINE>
          Right
            stays: Position < 5
            -> Left: Position >= 5
        <BLANKLINE>
          Left
            stays always
    """
    lines = [_title(automaton)]
    if automaton.description:
        lines += [f"  {line}" for line in automaton.description.splitlines()]
    features = ", ".join(automaton.feature_labels) or "none"
    lines += [f"  features: {features}", f"  examples: {len(automaton.examples)}"]
    found = arrows(automaton)
    for state in (START, *automaton.labels):
        lines += ["", f"  {state}"]
        lines += [f"    {line}" for line in _transitions(state, found, automaton)]
        if shown := sum(bool(e.numbers) and e.next_state == state for e in automaton.examples):
            lines.append(f"    numbers: as in the nearest of {quantity(shown, 'moment')}")
    if trees:
        lines += _trees(automaton)
    return "\n".join(lines)


def _title(automaton: Automaton) -> str:
    if not automaton.parameters:
        return automaton.name
    return f"{automaton.name}({', '.join(automaton.parameters)})"


def _transitions(state: str, found: Iterable[Arrow], automaton: Automaton) -> Iterable[str]:
    if state in FLAGS:
        return ["raises the flag, then -> Start"]
    if state not in automaton.transitions:
        return ["stays"]
    lines = []
    for arrow in found:
        if arrow.source == state:
            head = "stays" if arrow.is_loop else f"-> {arrow.target}"
            lines += [
                f"{head}: {way}" if way.conditions else f"{head} {way}" for way in arrow.ways
            ] or [f"{head}: {NO_RULES}"]
    return lines or [NO_RULES]


def _trees(automaton: Automaton) -> list[str]:
    lines = []
    for state in (START, *automaton.labels):
        function = automaton.transitions.get(state)
        if isinstance(function, TransitionTree) and function.features_used:
            lines += ["", f"  tree of {state}"]
            lines += [
                f"    {line}" for line in function.as_text(automaton.feature_labels).splitlines()
            ]
    return lines
