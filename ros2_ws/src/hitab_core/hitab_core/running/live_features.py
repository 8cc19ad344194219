"""What an agent that performs something perceives at the moment, level by level, for people.

They may ask at any time and change nothing: what is read for them is not kept (`Senses.look`), so
that each decision reads for itself, and a feature that cannot be read is NaN.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from hitab_core.automaton import FLAGS
from hitab_core.running.agent_batch import BatchMember, LevelOfMember
from hitab_core.running.running_automaton import RunContext, Running, RunningAutomaton
from hitab_core.running.senses import value_or_nan
from hitab_core.use import Use

Reading = tuple[str, str, float]
"""Label of an automaton, one of its features bound to targets, and its value now, or NaN."""


def live_features(
    running: Running | LevelOfMember | None, context: RunContext, also: Sequence[Use] = ()
) -> list[Reading]:
    """Return the features of each active automaton, outermost first, leaving flags up.

    Args:
        running: what the agent performs.
        context: on which it does.
        also: further features, bound to targets, told under the label "".

    Raises:
        VocabularyError: if one of these does not exist.
    """
    for use in also:
        context.repertoire.check_feature(use)
    look = context.senses.look
    readings: list[Reading] = []
    running = running.outermost if isinstance(running, BatchMember) else running
    while isinstance(running, RunningAutomaton | LevelOfMember):
        child = running.child
        raised = child.raised if child is not None else ()
        for feature in running.automaton.features:
            use = feature.bound(running.bindings)
            value = float(use.name in raised) if use.name in FLAGS else value_or_nan(look, use)
            readings.append((running.label, str(use), value))
        running = child
    # A flag is raised by a behavior to the automaton that uses it, and to nobody else.
    readings += [
        ("", str(use), math.nan if use.name in FLAGS else value_or_nan(look, use)) for use in also
    ]
    return readings
