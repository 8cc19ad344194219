"""The domain ``keepaway_fullspeed``: the words that look ahead plus words for fast takers."""

from __future__ import annotations

from hitab_core import Domain
from keepaway_research.fullspeed.behaviors import BEHAVIORS
from keepaway_research.fullspeed.body import FullSpeedBody
from keepaway_research.fullspeed.features import FEATURES, TARGETS
from keepaway_research.predictive.domain import DOMAIN as PREDICTIVE

DOMAIN = Domain.of(
    "keepaway_fullspeed",
    "1",
    FullSpeedBody,
    behaviors=(*PREDICTIVE.behaviors.values(), *BEHAVIORS),
    features=(*PREDICTIVE.features.values(), *FEATURES),
    targets=(*PREDICTIVE.targets.values(), *TARGETS),
    automata=tuple(PREDICTIVE.automata.values()),
)
