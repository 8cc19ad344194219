"""What was learned and does not play is remarked on, and what plays is not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest

from hitab_core import Agent, BehaviorLibrary, Fix, RemarkKind, Term, plain_domain
from hitab_core.training import Curriculum

CART = plain_domain(
    "cart",
    {"Left": [-1.0], "Right": [1.0], "Stop": [0.0], "Hop": [2.0]},
    {"Position": lambda p: p[0]},
)
CART.behaviors["Hop"] = replace(CART.behaviors["Hop"], one_shot=True)
FEW, MANY = 40, 60


class Cart:
    """A cart that gets its position as a percept, in episodes."""

    def __init__(self, folder: Path) -> None:
        self.agent = Agent("cart", CART, BehaviorLibrary(folder / "library", CART), folder)
        self.cycle = 0

    def taught(self, *commands: tuple[float, str], features: tuple[str, ...] = ("Position",)):
        self.agent.begin(Curriculum("Taught", tuple(map(Term, features))), discard=True)
        for position, label in commands:
            self.at(position)
            self.agent.command(Term(label))
        return self

    def at(self, position: float) -> None:
        self.cycle += 1
        self.agent.sense([position], [], self.cycle, self.cycle * 0.1)
        self.agent.tick()

    def tested(self, *positions: float, episodes: int = MANY) -> None:
        self.agent.test(restart=True)
        for _ in range(episodes):
            for position in positions:
                self.at(position)
            self.agent.restart(0, 1)

    @property
    def remarks(self):
        return self.agent.remarks(look=True)

    def codes(self) -> list[RemarkKind]:
        return [remark.code for remark in self.remarks]


@pytest.fixture
def cart(tmp_path: Path) -> Cart:
    return Cart(tmp_path)


@pytest.mark.parametrize("features", [(), ("Position",)])
def test_commands_that_lead_back_to_each_other_in_one_situation_make_a_loop(
    cart: Cart, features: tuple[str, ...]
) -> None:
    cart.taught((3.0, "Stop"), (3.0, "Right"), (3.0, "Stop"), features=features)
    (remark,) = cart.remarks
    assert remark.code is RemarkKind.LOOP
    assert dict(remark.arguments)["states"] == "Stop and Right"
    assert str(remark).startswith(("with Position = 3", "with no feature chosen"))
    assert remark.remedy == Fix.RELABEL(agent="cart", number=3, behavior="Stop", before="Right")
    assert "have example 3 of cart go to Stop instead of Right, if that is wrong" in str(
        remark.remedy
    )
    assert cart.agent.session is not None
    cart.agent.session.relabel([3], Term("Stop"))
    assert cart.remarks == []
    cart.tested(3.0, 3.0, 3.0, episodes=1)
    cart.at(3.0)
    assert cart.agent.active_path == ["Stop"]


def test_what_was_commanded_again_and_again_needs_other_features(cart: Cart) -> None:
    cart.taught(*((3.0, label) for label in ("Stop", "Right") * 3))
    assert [remark.remedy.code for remark in cart.remarks] == [Fix.CHOOSE_FEATURES]


@pytest.mark.parametrize(
    ("commands", "features"),
    [
        ([(0.0, "Right"), (5.0, "Left"), (0.0, "Right")], ["Position"]),
        ([(0.0, "Right"), (0.0, "Left"), (0.0, "Done")], ["Position"]),
        ([(0.0, "Hop"), (0.0, "Right"), (0.0, "Hop")], ["Position"]),
        ([(0.0, "Right"), (0.0, "Left"), (0.0, "Right"), (0.0, "Stop")], ["Position"]),
        ([(0.0, "Right"), (0.0, "Left"), (0.0, "Right")], ["SecondsInState"]),
        ([(0.0, "Failed"), (0.0, "Failed")], ["Done"]),
    ],
    ids=["there and back", "to a flag", "once per entry", "a way out", "by the time", "a flag"],
)
def test_what_can_come_to_rest_or_waits_is_no_loop(
    cart: Cart, commands: Iterable[tuple[float, str]], features: tuple[str, ...]
) -> None:
    assert cart.taught(*commands, features=tuple(features)).codes() == []


def test_a_state_and_a_flag_that_no_test_reaches_are_remarked_on_after_some_episodes(
    cart: Cart,
) -> None:
    cart.taught((0.0, "Right"), (5.0, "Stop"), (8.0, "Done"))
    cart.tested(0.0, 1.0, episodes=FEW)
    assert cart.codes() == []
    cart.tested(0.0, 1.0)
    assert cart.codes() == [RemarkKind.NOT_ENTERED, RemarkKind.NOT_RAISED]
    assert cart.remarks[0].remedy == Fix.CORRECT(agent="cart", behavior="Stop")
    assert cart.remarks[1].remedy == Fix.CORRECT(agent="cart", behavior="Done")
    cart.tested(0.0, 5.0, 8.0, episodes=1)
    assert cart.codes() == []


def test_a_state_that_no_test_leaves_is_remarked_on_until_the_examples_change(
    cart: Cart,
) -> None:
    cart.taught((0.0, "Right"), (5.0, "Left"), (0.0, "Right"))
    cart.tested(0.0, 5.0, 4.0)
    assert cart.codes() == [RemarkKind.NOT_LEFT]
    assert dict(cart.remarks[0].arguments)["state"] == "Left"
    assert cart.remarks[0].remedy == Fix.CORRECT(agent="cart", behavior="Right")
    assert cart.agent.session is not None
    cart.agent.session.undo()
    assert cart.codes() == []


def test_episodes_in_which_a_person_took_over_do_not_count(cart: Cart) -> None:
    cart.taught((0.0, "Right"), (5.0, "Stop"))
    for _ in range(MANY):
        cart.tested(0.0, episodes=0)
        cart.at(0.0)
        cart.agent.take_over()
        cart.agent.restart(0, 1)
    assert cart.codes() == []
