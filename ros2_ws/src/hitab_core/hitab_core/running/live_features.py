"""The current feature values of a performing agent, level by level, for people.

Reading them changes nothing: values are not cached (`FeatureCache.look`), so each decision still
reads its own. A feature that cannot be read is NaN.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from hitab_core.automaton import OWN_FEATURES
from hitab_core.running.feature_cache import value_or_nan
from hitab_core.running.run_context import RunContext, Running
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.term import Term

Reading = tuple[str, str, float]
"""Label of an automaton, one of its features bound to targets, and its current value or NaN."""


def live_features(
    running: Running | None, context: RunContext, also: Sequence[Term] = ()
) -> list[Reading]:
    """Return the features of each active automaton, outermost first; leave flags up.

    Args:
        running: the agent's performance.
        context: context of the agent.
        also: more features, bound to targets, listed under the label "".

    Raises:
        VocabularyError: if one of ``also`` does not exist.
    """
    for term in also:
        context.repertoire.domain.check_feature(term)
    readings: list[Reading] = []
    while isinstance(running, RunningAutomaton):
        readings += [
            (running.label, str(feature.bound(running.bindings)), running.look(feature))
            for feature in running.automaton.features
        ]
        running = running.child
    # Flags and timers belong to one automaton.
    readings += [
        (
            "",
            str(term),
            math.nan if term in OWN_FEATURES else value_or_nan(context.feature_cache.look, term),
        )
        for term in also
    ]
    return readings
