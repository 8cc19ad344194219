"""The shown action at each moment, and the action of each basic behavior in its place."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from hitab_core.action_behavior import ActionBehavior
from hitab_core.domain import FLAGS_AND_TIMERS, Domain
from hitab_core.labeling.labels import Progress, Run, no_progress
from hitab_core.labeling.likelihood import apart
from hitab_core.numeric.arrays import Floats
from hitab_core.running.feature_cache import FeatureCache, resolved, value_or_nan
from hitab_core.term import Term
from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.vocabulary import has


@dataclass(frozen=True, slots=True)
class ShownAction:
    """One cycle of an agent that a person or program drove.

    Attributes:
        when: time on the clock of the source, s.
        time: simulated, or the robot's, s.
        cycle: the world's cycle.
        episode: number of the episode; each is a run of its own.
        values, heard: the percept.
        did: the action, in the layout of the domain, empty if there is none; None if unknown.
    """

    when: float
    time: float
    cycle: int
    episode: int
    values: Sequence[float]
    heard: Sequence[str]
    did: Sequence[float] | None


def behaviors_meant(domain: Domain, chosen: Iterable[str]) -> tuple[Term, ...]:
    """Return the behaviors to choose from; if none are given, all without targets.

    Raises:
        VocabularyError: if a name is no basic behavior, or there are fewer than two.
    """
    known = {
        name: behavior.parameters
        for name, behavior in domain.behaviors.items()
        if not (behavior.numbers or isinstance(behavior, ActionBehavior))
    }
    terms = tuple(dict.fromkeys(map(Term.parse, chosen)))
    for term in terms:
        domain.check_use(term, known, what="basic behavior without numbers")
    terms = terms or tuple(Term(name) for name, parameters in known.items() if not parameters)
    if len(terms) < 2:
        raise VocabularyError(f"choose at least two basic behaviors to tell apart {has(known)}")
    return terms


def features_meant(domain: Domain, chosen: Iterable[str]) -> tuple[Term, ...]:
    """Return the features on which the choice of a behavior may have depended.

    Raises:
        VocabularyError: naming an unknown feature, or one that depends on the behavior.
    """
    terms = tuple(dict.fromkeys(map(Term.parse, chosen)))
    for term in terms:
        if term.name in FLAGS_AND_TIMERS:
            raise VocabularyError(
                f'"{term}" depends on which behavior was active, which is what is looked for; '
                f"choose other features {has(domain.features)}"
            )
        domain.check_feature(term)
    if not terms:
        raise VocabularyError(f"choose at least one feature {has(domain.features)}")
    return terms


def runs_of(
    moments: Sequence[ShownAction],
    domain: Domain,
    agent: str,
    behaviors: Sequence[Term],
    features: Sequence[Term],
    progress: Progress = no_progress,
) -> tuple[list[Run], Floats]:
    """Return the episodes of some moments as runs to label, and the actions, shape (n, d).

    Each behavior has a body of its own and is pulsed at each moment. Actions that are shorter than
    others count as if they ended in zeros.

    Args:
        moments: the moments in their order.
        domain: domain of the agent.
        agent: name of the agent.
        behaviors: possible ones.
        features: features on which the choice of a behavior may have depended.
        progress: called with the number of moments done.
    """
    body = domain.body(agent)
    feature_cache = FeatureCache(body, domain)
    pulses = [_pulsed(domain, agent, term) for term in behaviors]
    seen, did, would = [], [], []
    for done, moment in enumerate(moments, 1):
        body.sense(moment.values, moment.heard)
        feature_cache.forget()
        seen.append([value_or_nan(feature_cache.look, term) for term in features])
        did.append(moment.did)
        would.append([pulse(moment) for pulse in pulses])
        progress(done, len(moments), "asking each behavior")
    every = [*(d for d in did if d is not None), *(w for outputs in would for w in outputs)]
    width = max(1, max(map(len, every), default=0))
    acted = np.array([_padded(d, width) for d in did])
    found = apart(acted, [[_padded(w, width) for w in outputs] for outputs in would])
    table = np.array(seen)
    runs, begin = [], 0
    for _, group in groupby(moments, key=lambda moment: moment.episode):
        end = begin + len(list(group))
        runs.append(Run(table[begin:end], found[begin:end]))
        begin = end
    return runs, acted


def _pulsed(domain: Domain, agent: str, term: Term) -> Callable[[ShownAction], Sequence[float]]:
    """Return a function from a moment to a behavior's action, which is empty if it has none."""
    body, behavior = domain.body(agent), domain.behaviors[term.name]
    pulse = resolved(behavior.pulse, body, domain, term)
    begin = resolved(behavior.start, body, domain, term)
    begun = False

    def does(moment: ShownAction) -> Sequence[float]:
        nonlocal begun
        try:
            body.sense(moment.values, moment.heard)
            if not begun:
                begin()
                begun = True
            pulse()
            return tuple(body.act()[0])
        except Exception:  # domain code; an agent does nothing then, too
            return ()

    return does


def _padded(action: Sequence[float] | None, width: int) -> list[float]:
    if action is None:
        return [math.nan] * width
    return [*map(float, action), *[0.0] * (width - len(action))]
