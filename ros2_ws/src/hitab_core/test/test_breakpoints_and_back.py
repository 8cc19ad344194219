"""An agent holds its world at breakpoints, goes back in time with it, and tells what is next."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from pathlib import Path

import pytest

from hitab_core import (
    Agent,
    Automaton,
    BehaviorLibrary,
    FeatureValueError,
    Given,
    HandWritten,
    Term,
    VocabularyError,
    plain_domain,
)
from hitab_core.acting.draws import Draws
from hitab_core.automaton import SECONDS_IN_STATE
from hitab_core.operations import SetBreakpoints
from hitab_core.training import Curriculum

STEP = 0.1


def shift(seconds: float) -> str:
    """Wait a while, then go."""
    return "Go" if seconds > 0.35 else "Wait"


PATROL = Automaton(
    "Patrol",
    (Term("Wait"), Term("Go"), Term("Done")),
    (Term(SECONDS_IN_STATE), Term("Position")),
    {
        "Start": HandWritten(lambda: "Wait"),
        "Wait": HandWritten(shift, (0,)),
        "Go": HandWritten(lambda x: "Done" if x % 13 > 9 else "Go", (1,)),
    },
)
TOUR = Automaton(
    "Tour",
    (Term("Patrol"), Term("Stay")),
    (Term("Done"), Term("SecondsSince", ("Done",))),
    {
        "Start": HandWritten(lambda: "Patrol"),
        "Patrol": HandWritten(lambda done: "Stay" if done else "Patrol", (0,)),
        "Stay": HandWritten(lambda since: "Patrol" if since > 0.45 else "Stay", (1,)),
    },
)


def domain():
    plain = plain_domain("cart", {"Wait": [0.0], "Go": [1.0], "Stay": [0.5]}, ["Position"])
    return replace(plain, automata={"Patrol": PATROL, "Tour": TOUR})


CART = domain()


class World:
    """A world that moves with the cart's action, and asks it again after it was held."""

    def __init__(self, folder: Path) -> None:
        self.agent = Agent("cart", CART, BehaviorLibrary(folder / "lib", CART), folder / "log")
        self.cycle, self.position = 1, 0.0
        self.then: list[float] = [0.0, 0.0]
        self.held: list[tuple[int, str]] = []

    def ask(self) -> bool:
        """Ask for an action on the present percept; play the cycle unless the agent holds."""
        self.agent.sense([self.position], [], self.cycle, self.cycle * STEP)
        self.agent.tick()
        if self.agent.held:
            self.held.append((self.cycle, self.agent.held))
            return False
        action, _ = self.agent.body.act()
        self.position += sum(action)
        self.then.append(self.position)
        self.cycle += 1
        return True

    def play(self, until: int) -> list[tuple[str, ...]]:
        """Play on, past breakpoints; return the active path of each cycle."""
        paths: list[tuple[str, ...]] = []
        while self.cycle < until:
            if self.ask():
                paths.append(tuple(self.agent.active_path))
        return paths

    def back(self, cycle: int) -> None:
        """Go back as a world does: percepts follow from that cycle on."""
        self.position = self.then[cycle]
        del self.then[cycle + 1 :]
        self.cycle = cycle
        self.agent.go_back(cycle)


@pytest.fixture
def world(tmp_path: Path) -> World:
    made = World(tmp_path)
    made.agent.perform(Term("Tour"))
    return made


def test_an_agent_holds_before_it_acts_and_then_does_what_it_had_done_unheld(
    world: World, tmp_path: Path
) -> None:
    free = World(tmp_path / "free")
    free.agent.perform(Term("Tour"))
    world.agent.do(SetBreakpoints(["Wait -> Go", "Stay"]))
    assert world.play(80) == free.play(80)
    assert {held for _, held in world.held} == {"cart: Wait -> Go", "cart: Patrol -> Stay"}
    assert len({cycle for cycle, _ in world.held}) == len(world.held), "once in a cycle"
    world.agent.do(SetBreakpoints([]))
    held = len(world.held)
    world.play(120)
    assert len(world.held) == held


def test_held_it_is_still_in_the_state_that_it_would_leave(world: World) -> None:
    world.agent.do(SetBreakpoints(["Wait -> Go"]))
    while world.ask():
        pass
    assert world.agent.active_path == ["Patrol", "Wait"]
    assert world.ask(), "asked again, it goes on"
    assert (world.agent.active_path, world.agent.held) == (["Patrol", "Go"], "")


def test_a_breakpoint_is_met_on_every_level_also_where_a_behavior_begins(world: World) -> None:
    world.agent.do(SetBreakpoints(["Patrol", "Start -> Wait"]))
    assert not world.ask()
    assert world.held == [(1, "cart: Start -> Patrol")], "the outermost first"
    world.agent.do(SetBreakpoints(["Start -> Wait"]))
    assert not world.ask()


def test_who_fails_to_decide_after_a_hold_does_not_hold_for_ever(world: World) -> None:
    world.agent.do(SetBreakpoints(["Go -> Done"]))
    while world.ask():
        pass
    world.position = math.nan
    with pytest.raises(FeatureValueError):
        world.ask()
    assert not world.agent.held


def test_unknown_names_are_refused_naming_those_there(world: World) -> None:
    with pytest.raises(VocabularyError, match=r'unknown state "Pas" .*known: .*Patrol, Start'):
        world.agent.do(SetBreakpoints(["Patrol", "Stay -> Pas"]))
    assert world.agent.breakpoints.set == ()
    with pytest.raises(VocabularyError, match='unknown state ""'):
        world.agent.do(SetBreakpoints(["Stay ->"]))


@pytest.mark.parametrize("cycle", range(3, 60, 7))
def test_after_going_back_it_does_the_same_again(world: World, cycle: int) -> None:
    first = world.play(70)
    draws = world.agent.draws
    world.back(cycle)
    assert world.agent.active_path == list(first[cycle - 2]), "before it acts in this cycle"
    assert world.play(70) == first[cycle - 1 :]
    assert world.agent.draws == draws


def test_going_back_restores_random_numbers(tmp_path: Path) -> None:
    draws, same = Draws(7), random.Random(7)
    expected = [same.random() for _ in range(20)]
    look = draws.ahead()
    assert [look() for _ in range(3)] == expected[:3]
    assert [draws() for _ in range(5)] == expected[:5]
    draws.back(2)
    assert [draws() for _ in range(18)] == expected[2:]
    draws.seed(7)
    draws.back(3)
    assert draws() == expected[0], "not before the present seed"


def taught(world: World) -> None:
    world.agent.begin(Curriculum("Shuttle", (Term("Position"),)))
    world.play(3)
    for label, cycles in (("Go", 8), ("Wait", 4), ("Go", 2)):
        world.agent.command(Term(label), Given())
        world.play(world.cycle + cycles)


def test_going_back_in_a_training_keeps_its_examples_and_ends_its_percepts_there(
    world: World,
) -> None:
    taught(world)
    session = world.agent.session
    assert session is not None
    examples = session.examples
    world.back(8)
    assert session.examples == examples
    assert [p.cycle for p in session.history.past.kept] == list(range(1, 8))
    assert world.agent.active_path == ["Go"]
    assert world.agent.command(Term("Wait"), Given(seen=6, exact=True))[0].state == "Go"
    assert world.agent.active_path == ["Wait"], "nothing was commanded since: it is earlier now"
    world.play(12)
    assert [p.cycle for p in session.history.past.kept] == list(range(1, 12))


def test_what_was_performed_then_is_performed_again(world: World) -> None:
    first = world.play(20)
    world.agent.perform(Term("Patrol"))
    world.play(30)
    world.back(10)
    assert str(world.agent.top) == "Tour"
    assert world.play(20) == first[9:]


def test_what_a_changed_library_has_replaced_is_not_performed_again(world: World) -> None:
    world.play(20)
    world.agent.perform(Term("Patrol"))
    world.agent.reload()
    world.play(30)
    world.back(10)
    assert (str(world.agent.top), world.agent.active_path) == ("Patrol", ["Start"])


def test_a_preview_is_what_the_learned_automaton_then_does(world: World) -> None:
    taught(world)
    session = world.agent.session
    assert session is not None
    assert session.preview.now().state == "", "nobody has looked"
    session.preview.learn()
    foreseen = session.preview.now()
    assert 0.0 < foreseen.probability <= 1.0
    assert session.preview.at(session.history.past.kept[-1]).probability > 0.0
    draws = world.agent.draws
    world.agent.test()
    for _ in range(20):
        session.preview.learn()
        world.agent.sense([world.position], [], world.cycle, world.cycle * STEP)
        foreseen = session.preview.now()
        world.ask()
        if foreseen.probability == 1.0:
            assert world.agent.active_path == [foreseen.state]
    assert world.agent.draws >= draws


def test_a_far_situation_is_unsure_and_holds_the_world(world: World) -> None:
    taught(world)
    session = world.agent.session
    assert session is not None
    session.preview.learn()
    world.agent.do(SetBreakpoints(["unsure"]))
    world.ask()
    assert not world.agent.held
    world.position = 1000.0
    world.ask()
    assert world.agent.held.startswith("cart: unsure: it is ")
    world.ask()
    assert not world.agent.held, "once, while it stays unsure"
