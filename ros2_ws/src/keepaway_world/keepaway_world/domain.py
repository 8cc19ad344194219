"""The keepaway domain: the vocabulary in which keepers are trained."""

from __future__ import annotations

from hitab_core import Domain
from keepaway_world.behaviors import BEHAVIORS
from keepaway_world.body import KeeperBody
from keepaway_world.features import FEATURES, TARGETS
from keepaway_world.hand_written import SERVO_BALL

DOMAIN = Domain.of(
    "keepaway",
    "1",
    KeeperBody,
    behaviors=BEHAVIORS,
    features=FEATURES,
    targets=TARGETS,
    automata=(SERVO_BALL,),
)
