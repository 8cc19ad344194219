"""An agent that lacks a value acts, and its status names the feature until it has one."""

from __future__ import annotations

import math
from pathlib import Path

from bodies import UnseeingBody

from hitab_agent.node.guarded_tick import TICK, VALUES, GuardedTick
from hitab_core import Agent, BehaviorLibrary, Domain, Feature, Term
from hitab_core.domain import BasicBehavior
from hitab_core.training import Curriculum
from hitab_ros.nodes.guard import Guard


class Body(UnseeingBody):
    action = (1.0,)


def trained(folder: Path, *, required: bool = False) -> tuple[Agent, Guard, GuardedTick]:
    domain = Domain.of(
        "bodies",
        "1",
        Body,
        behaviors=[BasicBehavior("Go"), BasicBehavior("Wait")],
        features=[Feature("X", lambda body: body.values[0], required=required)],
    )
    agent = Agent("one", domain, BehaviorLibrary(folder / "library", domain), folder)
    agent.begin(Curriculum("T", (Term("X"),)))
    for x, behavior in ((1.0, "Go"), (9.0, "Wait"), (1.0, "Go")):
        agent.sense([x], [])
        agent.command(Term(behavior))
    agent.test()
    guard = Guard(lambda text: None)
    return agent, guard, GuardedTick(agent, guard)


def test_a_feature_without_a_value_is_a_fault_until_it_has_one(tmp_path: Path) -> None:
    agent, guard, tick = trained(tmp_path)
    for _ in range(2):
        agent.sense([math.nan], [])
        assert tick.act()[0], "it acts all the same"
        assert guard.faults.texts() == [
            'one decides without needed values: feature "X" has no value; check its sensor'
        ]
    agent.sense([2.0], [])
    assert tick.act()[0]
    assert not guard.faults


def test_a_missing_value_is_no_fault_of_what_is_performed_next(tmp_path: Path) -> None:
    agent, guard, tick = trained(tmp_path)
    agent.sense([math.nan], [])
    tick.act()
    tick.clear_if_past()
    assert list(guard.faults.by_key) == [VALUES]
    agent.perform(Term("Wait"))
    tick.clear_if_past()
    assert not guard.faults
    tick.act()
    assert not guard.faults


def test_without_a_required_value_an_agent_does_nothing(tmp_path: Path) -> None:
    agent, guard, tick = trained(tmp_path, required=True)
    agent.sense([math.nan], [])
    assert not tick.act()[0]
    assert list(guard.faults.by_key) == [TICK]
    assert 'feature "X" has no value' in guard.faults.text(TICK)
