"""What a late command responded to: an event about a reaction time ago, or else that time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from hitab_core import (
    Agent,
    BehaviorLibrary,
    Example,
    Feature,
    FeatureKind,
    Scale,
    Use,
    plain_domain,
)
from hitab_core.training import Curriculum
from hitab_core.training.moments import Moment, nearest
from hitab_core.training.responses import responded

STEP = 0.1
AGO = 0.3  # give or take a step
NUMBER = Scale()
WHETHER = Scale(FeatureKind.BOOLEAN)
ANGLE = Scale(FeatureKind.TOROIDAL, 2.0 * math.pi)


def moments(
    *columns: Sequence[float], states: Sequence[str] = (), step: float = STEP
) -> list[Moment]:
    """Return moments with these readings; the first one is there twice, as from a beginning."""
    rows = list(zip(*columns, strict=True))
    labels = states or ["Go"] * len(rows)
    kept = [Moment(i, i * step, labels[i], row) for i, row in enumerate(rows)]
    return [kept[0], *kept]


def cycle(columns: Sequence[Sequence[float]], scales: Sequence[Scale], due: int) -> int:
    """Return the cycle of what was responded to, with events up to a cycle from ``due``."""
    kept = moments(*columns)
    return responded(kept, kept[due + 1], AGO, dict(enumerate(scales))).cycle


def test_a_command_responds_to_the_first_change_of_a_flag_near_its_time() -> None:
    change = [0, 0, 0, 0, 0, 1, 1, 1, 1]
    assert [cycle([change], [WHETHER], due) for due in (3, 4, 5, 6, 7)] == [3, 5, 5, 5, 7]
    later = [0, 0, 0, 0, 0, 0, 1, 1, 1]
    assert cycle([later, change], [WHETHER, WHETHER], 5) == 5


def test_what_was_so_for_one_moment_only_is_that_moment() -> None:
    """A yell is heard in one cycle."""
    pulse = [0, 0, 0, 0, 1, 0, 0, 0, 0]
    assert [cycle([pulse], [WHETHER], due) for due in (3, 4, 5, 6)] == [4, 4, 4, 4]


def test_a_value_that_was_got_or_lost_is_an_event() -> None:
    lost = [3.0, 2.9, 2.8, 2.7, math.nan, math.nan, math.nan, math.nan]
    assert [cycle([lost], [NUMBER], due) for due in (3, 5)] == [4, 4]


@pytest.mark.parametrize(
    ("values", "scale"),
    [
        ([9.0, 8.5, 8.0, 7.5, 7.0, 1.0, 0.6, 0.2, 0.0], NUMBER),
        ([3.0, 3.0, 3.0, 3.0, 3.0, 3.5, 3.5, 3.5, 3.5], NUMBER),
        ([0.2, 0.1, 0.0, -0.1, -0.2, -3.0, -3.1, 3.1, 3.0], ANGLE),
    ],
)
def test_a_jump_is_an_event(values: list[float], scale: Scale) -> None:
    assert [cycle([values], [scale], due) for due in (4, 5, 6)] == [5, 5, 5]


def test_a_movement_is_no_event() -> None:
    for values, scale in [
        ([9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0], NUMBER),
        ([0.0, 1.0, 4.0, 9.0, 16.0, 25.0, 36.0, 49.0, 64.0], NUMBER),
        ([5.0, 5.0, 5.0, 5.0, 5.0, 4.5, 4.0, 3.5, 3.0], NUMBER),  # it began to move
        ([2.9, 3.0, 3.1, -3.08, -2.98, -2.88, -2.78, -2.68, -2.58], ANGLE),  # it went around
        ([7.0, 7.0, 7.0, 7.0, 7.0 + 1e-15, 7.0, 7.0, 7.0, 7.0], NUMBER),
    ]:
        assert [cycle([values], [scale], due) for due in (2, 4, 6)] == [2, 4, 6]


def test_a_correction_responds_to_the_decision_that_it_contradicts() -> None:
    states = ["Go", "Go", "Go", "Go", "Stop", "Stop", "Stop", "Stop"]
    kept = moments([8, 7, 6, 5, 4, 3, 2, 1], states=states)

    def of(due: int, corrects: str) -> int:
        return responded(kept, kept[due + 1], AGO, {0: NUMBER}, corrects).cycle

    assert [of(due, "Turn") for due in (1, 2, 3, 4, 5, 6, 7)] == [1, 3, 3, 3, 3, 3, 7]
    assert of(4, "Stop") == 4, "that the automaton is to do what it does contradicts nothing"
    assert of(4, "") == 4, "a person in control has decided this"


def test_who_corrects_has_waited_for_the_robot_to_respond() -> None:
    kept = moments([0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0])

    def of(due: int, corrects: str) -> int:
        return responded(kept, kept[due + 1], AGO, {0: WHETHER}, corrects).cycle

    assert [of(due, "Turn") for due in (6, 7, 8, 9)] == [5, 5, 5, 9]
    assert [of(due, "") for due in (6, 7, 8, 9)] == [5, 7, 8, 9], "who is in control need not wait"


def test_nothing_responds_to_what_was_responded_to_before() -> None:
    kept = moments([0, 1, 1, 1, 1, 1, 1, 1])[2:]  # the change had its command
    assert responded(kept, kept[1], AGO, {0: WHETHER}).cycle == 2
    assert responded(kept, kept[0], AGO, {0: WHETHER}).cycle == 1


def test_the_nearest_moment_counts_and_of_two_as_near_the_later_one() -> None:
    kept = moments([0] * 8)[1:]
    times = [0.0, 0.11, 0.19, 0.25, 0.26, 9.0, -1.0]
    assert [nearest(kept, time).cycle for time in times] == [0, 1, 2, 3, 3, 7, 0]


class Driven:
    """A cart that hears a bell in one cycle, and is put elsewhere in another."""

    def __init__(self, folder: Path, features: Sequence[str]) -> None:
        plain = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position", "Bell"])
        read: Callable[..., float] = plain.features["Bell"].read
        bell = Feature("Bell", read, FeatureKind.BOOLEAN)
        cart = replace(plain, features={**plain.features, "Bell": bell})
        self.agent = Agent("cart", cart, BehaviorLibrary(folder / "library", cart))
        self.agent.begin(Curriculum("Shuttle", tuple(map(Use, features))))
        self.cycle = 0

    def run(self, cycles: int, bell: bool = False) -> None:
        for _ in range(cycles):
            self.cycle += 1
            self.agent.sense([self.cycle, bell], [], self.cycle, self.cycle * STEP)
            self.agent.tick()

    def command(self, label: str, ago: float) -> Example:
        return self.agent.command(Use(label), ago=ago)[0]


def test_the_example_is_of_the_event_and_says_how_long_ago_that_was(tmp_path: Path) -> None:
    cart = Driven(tmp_path, ["Bell", "Position"])
    cart.run(5)
    cart.command("Right", 0.0)
    cart.run(4)
    cart.run(1, bell=True)  # cycle 10
    cart.run(2)
    taught = cart.command("Left", 0.3)
    assert (taught.features, taught.state) == ((1.0, 10.0), "Right")
    assert taught.ago == pytest.approx(0.2)
    session = cart.agent.session
    assert session is not None
    session.retime([taught.number], 0.3)
    assert session.examples[-2].features == (0.0, 9.0), "who says so afterwards is obeyed exactly"


def test_what_no_decision_depends_on_is_no_event(tmp_path: Path) -> None:
    cart = Driven(tmp_path, ["Position"])
    cart.run(5)
    cart.run(1, bell=True)
    cart.run(2)
    assert cart.command("Left", 0.3).features == (5.0,)


def test_a_wrong_beginning_is_corrected_where_it_was_decided(tmp_path: Path) -> None:
    cart = Driven(tmp_path, ["Bell"])
    cart.run(1)
    cart.command("Right", 0.0)
    cart.agent.test()
    cart.agent.restart(1, 1)
    cart.run(4)
    assert cart.agent.active_path == ["Right"]
    cart.agent.take_over()
    taught = cart.command("Left", 0.3)
    assert (taught.state, taught.next_state) == ("Start", "Left")
    assert cart.agent.active_path == ["Left"]


def test_the_decision_that_was_corrected_is_not_one_that_followed_it(tmp_path: Path) -> None:
    """A robot whose automaton ends and begins anew has long gone on when a person takes over."""
    cart = Driven(tmp_path, ["Position"])
    cart.run(1)
    cart.command("Right", 0.0)
    cart.run(3)
    cart.command("Left", 0.0)
    cart.run(3)
    cart.command("Right", 0.0)
    cart.agent.test(restart=True)
    cart.cycle = 1
    cart.agent.restart(1, 1)
    cart.run(3)
    assert cart.agent.active_path == ["Left"]
    at = cart.cycle
    cart.run(3)
    assert cart.agent.active_path == ["Right"]
    cart.agent.take_over()
    taught = cart.command("Right", 0.5)
    session = cart.agent.session
    assert session is not None
    (corrected,) = session.perception.corrections(session.examples, [Use("Position")])
    assert (corrected.state, corrected.wrong, corrected.right) == ("Right", "Left", "Right")
    assert corrected.features == (float(at),) == taught.features
