"""What an agent that performs something perceives at the moment, level by level, for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from hitab_core.automaton import FLAGS
from hitab_core.running_automaton import Running, RunningAutomaton, Stage
from hitab_core.troupe import LevelOfMember, TroupeMember
from hitab_core.use import Use

Reading = tuple[str, str, float]
"""Label of an automaton, one of its features bound to targets, and its value now, or NaN."""


def live_features(
    running: Running | LevelOfMember | None, stage: Stage, also: Sequence[Use] = ()
) -> list[Reading]:
    """Return the features of each active automaton, outermost first, leaving flags up.

    Args:
        running: what the agent performs.
        stage: on which it does.
        also: further features, bound to targets, told under the label "".

    Raises:
        VocabularyError: if one of these does not exist.
    """
    for use in also:
        stage.repertoire.check_feature(use)
    readings: list[Reading] = []
    running = running.outermost if isinstance(running, TroupeMember) else running
    while isinstance(running, RunningAutomaton | LevelOfMember):
        bound = [feature.bound(running.bindings) for feature in running.automaton.features]
        values = _values(running)
        readings += [
            (running.label, str(use), value) for use, value in zip(bound, values, strict=True)
        ]
        running = running.child
    readings += [("", str(use), _value(stage, use)) for use in also]
    return readings


def _values(running: RunningAutomaton | LevelOfMember) -> Iterable[float]:
    try:
        return running.peek_features()
    except Exception:  # looking at an agent must not end it, whatever its domain does
        return [math.nan] * len(running.automaton.features)


def _value(stage: Stage, use: Use) -> float:
    if use.name in FLAGS:
        return math.nan  # a flag is raised by a behavior to the automaton that uses it
    try:
        return stage.senses.read(stage.senses.slot(use))
    except Exception:  # such as of a body that has not perceived anything yet
        return math.nan
