"""An agent that is unsure halts or hands back, if that is asked of it."""

from __future__ import annotations

import pytest

from hitab_core import Caution, LearningAgent, TrainingError, WhenUnsure, plain_domain

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position"])


@pytest.fixture
def cart() -> LearningAgent:
    agent = LearningAgent(CART).train("Shuttle")
    for position, command in ((0.0, "Right"), (5.0, "Left"), (0.0, "Right"), (6.0, "Left")):
        agent.step([position], command)
    agent.learn()
    return agent


def test_without_caution_it_goes_on_wherever_it_is(cart: LearningAgent) -> None:
    assert cart.decide([3.0]) == "Right"
    assert cart.decide([900.0]) == "Left"
    assert cart.agent.monitor.unsure == ""


def test_far_from_what_it_was_shown_it_halts_until_it_is_sure(cart: LearningAgent) -> None:
    cart.agent.monitor.set(Caution(WhenUnsure.HALT, distance=3.0))
    assert cart.decide([3.0]) == "Right"
    assert cart.decide([900.0]) == "Right", "it does not decide"
    assert "from the nearest one" in cart.agent.monitor.unsure
    assert cart.decide([6.0]) == "Left"
    assert cart.agent.monitor.unsure == ""


def test_far_from_what_it_was_shown_it_hands_back_to_the_demonstrator(cart: LearningAgent) -> None:
    cart.agent.monitor.set(Caution(WhenUnsure.HAND_BACK, distance=3.0))
    assert cart.decide([3.0]) == "Right"
    cart.step([900.0])
    assert cart.agent.mode == "training"
    assert "from the nearest one" in cart.agent.monitor.unsure
    cart.step([3.0], "Left")
    assert len(cart.examples) == 10


def test_a_performed_behavior_is_given_up_when_it_is_unsure_without_a_training(
    cart: LearningAgent,
) -> None:
    cart.save()
    cart.perform("Shuttle")
    cart.agent.monitor.set(Caution(WhenUnsure.HAND_BACK, distance=3.0))
    cart.step([1.0])
    assert cart.agent.mode == "performing"
    cart.agent.sense([900.0], [], 9)
    cart.agent.tick()
    assert cart.agent.mode == "idle"
    assert cart.agent.monitor.unsure


def test_a_caution_that_means_nothing_is_refused() -> None:
    for when, distance, why in [
        ("stop", 1.0, 'unknown caution "stop"'),
        ("halt", -1.0, "distance must be a number of at least 0, not -1"),
        ("halt", float("nan"), "at least 0"),
        ("halt", float("inf"), "at least 0"),
        ("halt", 0.0, "say when AGENT is unsure"),
    ]:
        with pytest.raises(TrainingError, match=why):
            Caution.parse(when, distance)
