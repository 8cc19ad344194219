"""The domain ``keepaway_predictive``: keepaway's vocabulary plus words that look ahead."""

from __future__ import annotations

from hitab_core import Domain
from keepaway_research.predictive.behaviors import BEHAVIORS
from keepaway_research.predictive.body import PredictiveBody
from keepaway_research.predictive.features import FEATURES, TARGETS
from keepaway_world.domain import DOMAIN as KEEPAWAY

DOMAIN = Domain.of(
    "keepaway_predictive",
    "1",
    PredictiveBody,
    behaviors=(*KEEPAWAY.behaviors.values(), *BEHAVIORS),
    features=(*KEEPAWAY.features.values(), *FEATURES),
    targets=(*KEEPAWAY.targets.values(), *TARGETS),
    automata=tuple(KEEPAWAY.automata.values()),
)
