"""What keepers perceive together is bit for bit what each perceives alone."""

from __future__ import annotations

import numpy as np
import pytest

from hitab_core.domain import BatchPercepts
from hitab_core.running.senses import resolved
from hitab_core.use import Use
from keepaway_research.features_of_all import DOMAIN, teammates_closer_to_ball_of_all
from keepaway_world.body import KeeperBody
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.world import KeepawayWorld


@pytest.mark.parametrize(("keepers", "takers"), [(3, 2), (5, 4), (2, 0)])
def test_features_of_all_are_those_of_each(keepers: int, takers: int) -> None:
    world = KeepawayWorld(KeepawayParameters(keepers=keepers, takers=takers), seed=3)
    perceived = []
    for episode in range(25):
        world.reset(episode)
        for _ in range(4):
            dash = {name: ([1.0, 80.0], f"pass {keepers}") for name in world.agents[:1]}
            if world.step(dash) is not None:
                break
            perceived += [world.percept(name) for name in world.agents]
    bodies = [KeeperBody(f"keeper_{i}") for i in range(len(perceived))]
    for body, (values, heard) in zip(bodies, perceived, strict=True):
        body.sense(values, heard)
    percepts = BatchPercepts(
        np.array([values for values, _ in perceived]),
        {row: heard for row, (_, heard) in enumerate(perceived) if heard},
    )
    looked_at = set()
    for feature in DOMAIN.features.values():
        for target in DOMAIN.targets.values() if feature.parameters else [None]:
            if target is not None and target.resolve_all is None:
                continue  # read one by one
            use = Use(feature.name, (target.name,) if target else ())
            alone = [resolved(feature.read, body, DOMAIN, use)() for body in bodies]
            assert feature.read_all is not None
            of_targets = [target.resolve_all(percepts)] if target else []
            together = feature.read_all(percepts, *of_targets)
            np.testing.assert_array_equal(together, alone, err_msg=str(use))
            looked_at.add(len(set(together)) > 1)
    assert True in looked_at


def test_a_teammate_that_is_exactly_as_close_is_not_closer() -> None:
    body = KeeperBody("keeper_1")
    values = [1.0, 2.0, 0.0, 20.0, 20.0, *[0.0] * 5, 4.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    rows = []
    for offset in np.linspace(-1e-15, 1e-15, 41):
        row = list(values)
        row[14], row[15] = 8.0 * np.cos(0.3) + offset * 4, 1.3
        rows.append(row)
    alone = []
    for row in rows:
        body.sense(row, [])
        alone.append(DOMAIN.features["ATeammateIsCloserToBall"].read(body))
    together = teammates_closer_to_ball_of_all(BatchPercepts(np.array(rows)))
    assert together.tolist() == alone
    assert len(set(alone)) == 2
