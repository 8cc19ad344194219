"""A hand-written automaton that was taken out: a gap that only what is trained can fill."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from hitab_core.agent import Agent
from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.errors import VocabularyError
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.bundle import make_bundle
from hitab_core.remedies import Do
from hitab_core.training.training_session import Curriculum
from hitab_core.transition_function import HandWritten
from hitab_core.use import Use


class Body:
    """Sees one number and says which behavior was pulsed last."""

    def __init__(self, name: str) -> None:
        self.x = 0.0
        self.did = ""

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        (self.x,) = values

    def act(self) -> tuple[Sequence[float], str]:
        did, self.did = self.did, ""
        return [], did


def basic(name: str) -> BasicBehavior:
    return BasicBehavior(name, lambda body: setattr(body, "did", name))


def goes_to(state: str) -> HandWritten:
    return HandWritten(lambda: state)


PLAYS = HandWritten(lambda x: "Kick" if x > 5.0 else "Servo", (0,))

WHOLE = Domain.of(
    "team",
    "1",
    Body,
    behaviors=[basic("Run"), basic("Crawl"), basic("Kick")],
    features=[Feature("x", lambda body: body.x, unit="m")],
    automata=[
        Automaton("Servo", (Use("Run"),), (), {START: goes_to("Run")}),
        Automaton(
            "Play",
            (Use("Servo"), Use("Kick")),
            (Use("x"),),
            dict.fromkeys((START, "Servo"), PLAYS),
        ),
        Automaton("Match", (Use("Play"),), (), {START: goes_to("Play")}),
    ],
)
REST = WHOLE.without(["Servo"])


def agent_of(domain: Domain, folder: Path, name: str = "ann") -> Agent:
    return Agent(name, domain, BehaviorLibrary(folder / name / "library", domain), folder / name)


def does(agent: Agent, x: float = 0.0) -> str:
    agent.sense([x], [])
    agent.tick()
    return agent.body.act()[1]


def teach(agent: Agent) -> None:
    agent.begin(Curriculum("Servo", (Use("x"),)))
    agent.sense([0.0], [])
    agent.command(Use("Crawl"))
    agent.save()


def test_nothing_is_done_in_its_place_and_all_else_goes_on(tmp_path: Path) -> None:
    agent = agent_of(REST, tmp_path)
    agent.perform(Use("Match"))
    assert [does(agent), does(agent)] == ["", ""]
    assert agent.active_path == ["Play", "Servo", "Start"]
    assert does(agent, 6.0) == "Kick"


def test_what_is_missing_where_and_the_way_out_is_said_until_it_is_trained(tmp_path: Path) -> None:
    assert agent_of(WHOLE, tmp_path).repertoire.vacancies == ()
    agent = agent_of(REST, tmp_path, "bob")
    (missing,) = agent.repertoire.vacancies
    assert missing == (
        '"Servo" was taken out, and nothing is done in its place; it is needed for Match, Play'
    )
    assert agent.remedies == (Do.TRAIN(behavior="Servo"), Do.IMPORT())
    teach(agent)
    assert agent.repertoire.vacancies == agent.remedies == ()


def test_what_is_trained_fills_the_gap_while_the_hand_written_ones_are_performed(
    tmp_path: Path,
) -> None:
    teacher, player = agent_of(REST, tmp_path, "ann"), agent_of(REST, tmp_path, "bob")
    player.perform(Use("Match"))
    assert does(player) == ""
    teach(teacher)
    player.library.install(
        dict(make_bundle(teacher.library.texts(), teacher.repertoire, "Servo").files)
    )
    player.reload()
    assert does(player) == "Crawl"
    assert player.active_path == ["Play", "Servo", "Crawl"]
    assert does(player, 6.0) == "Kick"


@pytest.mark.parametrize(
    ("name", "is_what"), [("Run", "a basic behavior"), ("Serve", "unknown"), ("Done", "unknown")]
)
def test_only_hand_written_automata_can_be_taken_out(name: str, is_what: str) -> None:
    with pytest.raises(VocabularyError) as refused:
        WHOLE.without([name])
    assert str(refused.value).startswith(
        f'domain "team" cannot be without "{name}", which is {is_what}; only hand-written '
        "automata can be taken out (known: Match, Play, Servo"
    )
