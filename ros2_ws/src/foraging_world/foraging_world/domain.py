"""The foraging domain: the vocabulary in which foragers are trained."""

from __future__ import annotations

from foraging_world.behaviors import BEHAVIORS
from foraging_world.body import ForagerBody
from foraging_world.features import FEATURES, TARGETS
from hitab_core import Domain

DOMAIN = Domain.of(
    "foraging",
    "1",
    ForagerBody,
    behaviors=BEHAVIORS,
    features=FEATURES,
    targets=TARGETS,
)
