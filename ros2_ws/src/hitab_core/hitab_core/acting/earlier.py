"""What an agent perceived and did, now or in a cycle of the last minute, and would do now."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from hitab_core.acting.acting_agent import ActingAgent
from hitab_core.assistant.preview import NOTHING, Preview
from hitab_core.automaton import OWN_FEATURES
from hitab_core.running.live_features import Reading, live_features
from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError


class Earlier(NamedTuple):
    """The present, or a moment of the last minute.

    Attributes:
        cycle: the world's cycle.
        readings: features of the automata that are performed, then those asked for. Of the past,
            only a training keeps them, and those of the automaton in training alone.
        active_path: labels of the states in which the agent met the percept, outermost first.
        preview: what it would do there by what it has learned since.
    """

    cycle: int
    readings: Sequence[Reading]
    active_path: Sequence[str]
    preview: Preview = NOTHING


def earlier(agent: ActingAgent, cycle: int, also: Sequence[Term] = ()) -> Earlier:
    """Return the present, or a moment of the last minute.

    Args:
        agent: the agent.
        cycle: the world's cycle; 0 for the present.
        also: more features, bound to targets, listed under the label "".

    Raises:
        TrainingError: if it is not kept.
        VocabularyError: if one of ``also`` does not exist.
    """
    session = agent.trained
    if cycle in (0, agent.cycle):
        preview = NOTHING if session is None else session.preview.now()
        readings = live_features(agent.running, agent.context, also)
        return Earlier(agent.cycle, readings, agent.active_path, preview)
    for term in also:
        agent.domain.check_feature(term)
    moment = agent.course.at(cycle)
    if session is None:
        if moment is None or cycle > agent.cycle:
            raise TrainingError(
                f"it is not known what {agent.name} did in cycle {cycle}; ask for one of the last "
                f"minute, since it began to perform this, up to cycle {agent.cycle}"
            )
        return Earlier(cycle, (), moment.active_path)
    percept = session.history.past.at(cycle)
    values = dict(zip(session.history.readable, percept.readings, strict=True))
    label, chosen = session.running.label, session.curriculum.features
    bound = [feature.bound(session.running.bindings) for feature in chosen]
    readings = [
        *((label, str(term), values[one]) for term, one in zip(bound, chosen, strict=True)),
        *(("", str(t), math.nan if t in OWN_FEATURES else values.get(t, math.nan)) for t in also),
    ]
    path = [percept.state] if moment is None else moment.active_path
    return Earlier(percept.cycle, readings, path, session.preview.at(percept))
