"""The engine's timers, features of every automaton: running and in training."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from bodies import Body

from hitab_core.agent import Agent
from hitab_core.automaton import FLAGS, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, Target
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.repertoire import Repertoire
from hitab_core.running import RunContext, performance
from hitab_core.running.feature_cache import FeatureCache
from hitab_core.running.live_features import live_features
from hitab_core.term import Term
from hitab_core.texts.errors import VocabularyError
from hitab_core.training import Curriculum
from hitab_core.transition_function import HandWritten

IN_STATE = Term("SecondsInState")
SINCE_DONE, SINCE_FAILED = (Term("SecondsSince", (flag,)) for flag in FLAGS)
STEP = 0.25  # s; sums of it are exact


def robot(**more: Any) -> Domain:
    given: dict[str, Any] = {
        "behaviors": [BasicBehavior(name) for name in ("Wait", "Go")],
        "features": [Feature("X", lambda body: body.values[0])],
        **more,
    }
    return Domain.of("timed", "1", Body, **given)


class Player:
    """An agent that performs the outermost of some automata, in steps of its clock."""

    def __init__(self, *automata: Automaton, domain: Domain | None = None) -> None:
        domain = domain or robot()
        self.body = Body()
        repertoire = Repertoire(domain, {made.name: made for made in automata})
        self.context = RunContext(
            repertoire, self.body, FeatureCache(self.body, domain), random.Random(1).random
        )
        self.running: Any = performance(self.context, Term(automata[-1].name))
        self.running.start()

    def tick(self, seconds: float = STEP, x: float = 0.0) -> list[str]:
        self.context.clock.now += seconds
        self.body.values = [x]
        self.context.feature_cache.forget()
        self.running.tick()
        return list(self.running.active_path)

    def now(self) -> list[float]:
        return [value for _, _, value in live_features(self.running, self.context)]


def hand(name: str, features: Any, **functions: Any) -> Automaton:
    """Return an automaton whose functions are written as functions of all features."""
    columns = tuple(range(len(features)))
    states = tuple(
        map(Term, ("Wait", "Go", *FLAGS, *(("Child",) if "Child" in functions else ())))
    )
    return Automaton(
        name,
        states,
        tuple(features),
        {state: HandWritten(choose, columns) for state, choose in functions.items()},
    )


def noting(seen: list[Any], then: str) -> Any:
    return lambda *values: seen.append(values) or then


# What they count --------------------------------------------------------------------------------


def test_seconds_in_state_count_from_the_entry_of_the_active_state() -> None:
    seen: list[Any] = []
    automaton = hand(
        "T",
        [IN_STATE],
        Start=noting(seen, "Wait"),
        Wait=lambda s: seen.append((s,)) or ("Go" if s >= 0.5 else "Wait"),
        Go=noting(seen, "Wait"),
    )
    player = Player(automaton)
    for _ in range(6):
        player.tick()
    assert [s for (s,) in seen] == [0.0, 0.25, 0.5, 0.25, 0.25, 0.5]


def test_start_and_flag_states_are_left_at_once_whenever_that_is() -> None:
    seen: list[Any] = []
    automaton = hand("T", [IN_STATE], Start=noting(seen, "Done"))
    player = Player(automaton)
    for _ in range(3):
        player.tick()
    assert seen == [(0.0,)] * 3
    assert player.now() == [0.0]


def finishing(after: float) -> Automaton:
    """Return an automaton that waits so long, is done and begins again."""
    return hand(
        "Child",
        [IN_STATE],
        Start=lambda s: "Wait",
        Wait=lambda s: "Done" if s >= after else "Wait",
    )


def test_seconds_since_a_flag_count_from_where_it_was_last_seen_up() -> None:
    seen: list[Any] = []
    parent = hand(
        "T",
        [SINCE_DONE, SINCE_FAILED, Term("Done")],
        Start=noting(seen, "Child"),
        Child=noting(seen, "Child"),
    )
    player = Player(finishing(0.5), parent)
    for _ in range(6):
        player.tick()
    # Done is raised in the third tick and seen in the fourth.
    assert [done for done, _, _ in seen] == [0.25, 0.5, 0.75, 0.0, 0.25, 0.5]
    assert [failed for _, failed, _ in seen] == [0.25 * i for i in range(1, 7)]
    assert [up for _, _, up in seen] == [0, 0, 0, 1, 0, 0]
    assert player.now()[:3] == [0.0, 1.5, 1.0], "up, and not seen yet by a decision"


def test_a_timer_alone_sees_flags_as_a_query_does() -> None:
    parent = hand(
        "T",
        [SINCE_DONE],
        Start=lambda s: "Child",
        Child=lambda s: "Go" if s == 0 else "Child",
    )
    player = Player(finishing(0.25), parent)
    assert [player.tick()[0] for _ in range(4)] == ["Child", "Child", "Go", "Go"]


def test_a_restart_sets_timers_to_zero_whatever_the_clock_does() -> None:
    player = Player(hand("T", [IN_STATE, SINCE_DONE], Start=lambda *s: "Wait"))
    player.tick()
    player.tick(7.0)
    assert player.now() == [7.0, 7.25]
    player.running.stop()
    player.context.clock.now = 1.0  # a new episode
    player.running.start()
    player.tick()
    assert player.now() == [0.0, 0.25]
    player.context.clock.now = 0.0
    assert player.now() == [0.0, 0.0], "never negative"


# Learned from a demonstration -------------------------------------------------------------------


def trained(folder: Path) -> Agent:
    domain = robot()
    agent = Agent("ann", domain, BehaviorLibrary(folder / "library", domain), folder)
    agent.begin(Curriculum("WaitAWhile", (IN_STATE,)))
    agent.sense([0.0], [], 1, 10.0)
    agent.command(Term("Wait"))
    agent.tick()
    agent.sense([0.0], [], 2, 12.0)
    agent.command(Term("Go"))
    return agent


def test_an_automaton_that_waits_two_seconds_is_learned_from_two_commands(tmp_path: Path) -> None:
    agent = trained(tmp_path)
    assert agent.session is not None
    assert [e.features for e in agent.session.examples if not e.is_default] == [(0.0,), (2.0,)]
    agent.test(restart=True)
    states = []
    for cycle in range(12):
        agent.sense([0.0], [], 3 + cycle, 20.0 + cycle * STEP)
        agent.tick()
        states.append(agent.active_path[0])
    # It enters Wait in the first cycle, and 2 s are 8 steps.
    assert states == ["Wait"] * 8 + ["Go"] * 4


def test_a_default_example_is_of_the_state_as_it_is_entered(tmp_path: Path) -> None:
    """When the next decision comes, no time has passed in the new state and its flags are down."""
    agent = trained(tmp_path)
    assert agent.session is not None
    (wait, go) = [e for e in agent.session.examples if e.is_default]
    assert (wait.features, go.features) == ((0.0,), (0.0,))
    agent.session.retime([4], 0.5)
    assert [e.features for e in agent.session.examples if e.command == 2] == [(2.0,), (0.0,)]


def test_a_command_sees_a_flag_for_the_timers() -> None:
    parent = hand("T", [SINCE_DONE], Start=lambda s: "Child", Child=lambda s: "Child")
    player = Player(finishing(0.25), parent)
    for _ in range(2):
        player.tick()
    running = player.running
    player.context.clock.now += 1.0
    assert running.vector.peek(running.child) == [0.0], "it is up"
    running.take_down_flags()
    player.context.clock.now += 1.0
    player.context.feature_cache.forget()
    assert running.vector.peek(running.child) == [1.0]


# Words ------------------------------------------------------------------------------------------


def test_flags_are_no_names_of_targets_and_parameters() -> None:
    with pytest.raises(VocabularyError, match='"Done" is a name of the engine'):
        robot(targets=[Target("Done", lambda body: 0)])
    with pytest.raises(VocabularyError, match='parameter cannot be called "Failed"'):
        Automaton("T", (), (), {}, ("Failed",))


@pytest.mark.parametrize("text", ["SecondsSince(Wait)", "SecondsSince", "SecondsInState(Done)"])
def test_a_timer_of_anything_else_is_refused_with_what_there_is(text: str) -> None:
    with pytest.raises(VocabularyError, match="must read Seconds"):
        robot().check_feature(Term.parse(text))
