"""A value that cannot be in an example is refused by name, and nothing is recorded."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from bodies import UnseeingBody

from hitab_core.agent import Agent
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, NoValueError
from hitab_core.training import Curriculum


@pytest.fixture
def agent(tmp_path: Path) -> Agent:
    domain = Domain.of(
        "sensors",
        "1",
        UnseeingBody,
        behaviors=[
            BasicBehavior("Go"),
            BasicBehavior("Aim", start=lambda body: body.values[0]),
        ],
        features=[
            Feature("Range", lambda body: body.values[0], unit="m"),
            Feature(
                "Kind",
                lambda body: body.values[0],
                FeatureKind.CATEGORICAL,
                categories=("near", "far"),
            ),
        ],
    )
    return Agent("ann", domain, BehaviorLibrary(tmp_path / "library", domain), tmp_path)


def refusal(agent: Agent, feature: str = "Range") -> str:
    if agent.session is None:
        agent.begin(Curriculum("New", (Term(feature),)))
    with pytest.raises(FeatureValueError) as refused:
        agent.command(Term("Go"))
    assert agent.session is not None
    assert len(agent.session.log) == 0
    return str(refused.value)


@pytest.mark.parametrize("value", [math.inf, -math.inf])
def test_an_example_holds_only_finite_values(agent: Agent, value: float) -> None:
    agent.sense([value], [])
    assert refusal(agent) == (
        f'feature "Range" is {value} but must be finite in an example; have it return a large '
        "number instead, such as the range of its sensor"
    )
    agent.sense([30.0], [])
    assert len(agent.command(Term("Go"))) == 2


@pytest.mark.parametrize("value", [None, math.nan, "near", [1.0, 2.0], 10**400])
def test_a_value_that_is_no_number_is_none(agent: Agent, value: Any) -> None:
    agent.sense([value], [])
    assert "Range" in refusal(agent), "a command without any value teaches nothing"
    with pytest.raises(NoValueError, match=r'^feature "Range" has no value') as raised:
        agent.context.feature_cache.read(agent.context.feature_cache.slot(Term("Range")))
    assert len(str(raised.value)) < 120


def test_a_command_before_the_first_percept_is_refused(agent: Agent) -> None:
    assert refusal(agent) == (
        "nothing perceived yet; let the world run, or wait for the robot's sensors"
    )
    agent.sense([1.0], [])
    agent.command(Term("Go"))


def test_a_behavior_that_needs_a_percept_is_not_begun_before_the_first_one(agent: Agent) -> None:
    expected = "^nothing perceived yet; .*IndexError"
    with pytest.raises(FeatureValueError, match=expected):
        agent.perform(Term("Aim"))
    assert agent.mode is Mode.IDLE
    agent.begin(Curriculum("Blind", (Term("Done"),)))
    with pytest.raises(FeatureValueError, match=expected):
        agent.command(Term("Aim"))
    agent.sense([], [])
    with pytest.raises(IndexError):  # the domain's own mistake, with its place
        agent.perform(Term("Aim"))
    assert agent.mode is Mode.IDLE
