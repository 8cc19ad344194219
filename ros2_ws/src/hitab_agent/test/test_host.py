"""A host goes on whatever is wrong with percepts and bodies, and forgets what is over."""

from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hitab_msgs import msg

from hitab_agent.host_resources import HostResources
from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.term import Term
from hitab_core.transition_function import HandWritten
from hitab_ros import Lease, names, qos
from hitab_ros.messages.pieces import publish_pieces

SIZE = 10


class Body:
    """A body that perceives one number, and does or says what that number means."""

    def __init__(self, name: str) -> None:
        self.value = 0.0
        self.pulses = 0
        self.answer: Any = None

    def sense(self, values: Any, heard: Any) -> None:
        self.value = values[0]

    def act(self) -> Any:
        return self.answer or ((float(self.pulses),), "")


def _pulse(body: Body) -> None:
    body.pulses += 1


def _domain(behavior: str) -> Domain:
    chooses = HandWritten(lambda x: "Go" if x > 0.0 else "Wait", (0,))
    return Domain.of(
        "bodies",
        "1",
        Body,
        behaviors=[BasicBehavior("Go", _pulse), BasicBehavior("Wait")],
        features=[Feature("X", lambda body: body.value)],
        automata=[
            Automaton(
                behavior,
                (Term("Go"), Term("Wait")),
                (Term("X"),),
                {START: chooses, "Go": chooses, "Wait": chooses},
            )
        ],
    )


class Swarm:
    """A host with agents, and the side of the world."""

    def __init__(
        self,
        process: Any,
        start: Any,
        folder: Path,
        domain: Domain | None = None,
        machine: str = "",
    ) -> None:
        self._process = process
        self.desk = desk = process.node
        shared = HostResources(
            desk, is_host=True, on_demand=True, lease=Lease(machine, bool(machine))
        )
        domain = domain or _domain("Choose")
        self.nodes = []
        for number in range(SIZE):
            more = {"behavior": "Choose", "library": str(folder / "library")}
            self.nodes.append(start(domain, f"agent_{number}", shared=shared, **more).node)
        (self.link,) = shared.links.values()
        self.rosters: list[msg.HostRoster] = []
        self.answers: list[msg.ActionBatch] = []
        desk.create_subscription(
            msg.HostRoster, f"/{names.HOSTS}", self.rosters.append, qos.LATCHED
        )
        desk.create_subscription(
            msg.ActionBatch, f"/world/{names.ACTION_BATCHES}", self.answers.append, qos.CYCLE
        )
        self.link.listen()
        shared.publish_roster()
        process.until(lambda: self.rosters)
        topic = f"/{self.rosters[0].host}/{names.PERCEPTS}"
        self.arrived: list[msg.PerceptBatch] = []
        desk.create_subscription(msg.PerceptBatch, topic, self.arrived.append, 10)
        self.fences: list[msg.Action] = []
        desk.create_subscription(msg.Action, "fence", self.fences.append, 10)
        self._fence = desk.create_publisher(msg.Action, "fence", 10)
        self._percepts = desk.create_publisher(msg.PerceptBatch, topic, 10)
        process.until(lambda: self._percepts.get_subscription_count() == 2)
        process.until(lambda: self._fence.get_subscription_count() == 1)
        self._sequence = 0

    def send(self, values: list[float], **fields: Any) -> None:
        self._sequence += 1
        batch = {
            "agents": range(SIZE),
            "value_counts": [1] * SIZE,
            "sequence": self._sequence,
            "cycle": self._sequence,
            **fields,
        }
        self._percepts.publish(
            msg.PerceptBatch(roster=self.rosters[0].number, values=values, **batch)
        )

    def send_and_wait(self, values: list[float], **fields: Any) -> None:
        """Send percepts, and something else that is handled after them; wait for both."""
        before = len(self.arrived), len(self.fences)
        self.send(values, **fields)
        self._process.until(lambda: len(self.arrived) > before[0])
        self._fence.publish(msg.Action())
        self._process.until(lambda: len(self.fences) > before[1])

    def act(self, values: list[float], **fields: Any) -> list[list[float]]:
        """Send percepts; return what all do."""
        self.send(values, **fields)
        self._process.until(lambda: self.answers and self.answers[-1].sequence == self._sequence)
        answer = self.answers[-1]
        ends = np.cumsum(answer.value_counts)
        return [part.tolist() for part in np.split(np.array(answer.values), ends[:-1])]


@pytest.fixture
def swarm(process: Any, start: Any, tmp_path: Path) -> Swarm:
    return Swarm(process, start, tmp_path)


def test_percepts_that_do_not_fit_together_are_left_out_and_end_nothing(swarm):
    ones = [1.0] * SIZE
    assert swarm.act(ones) == [[1.0]] * SIZE
    for fields in (
        {"agents": range(1, SIZE + 1)},
        {"agents": range(SIZE - 1)},
        {"value_counts": [2] * SIZE},
        {"value_counts": [1] * (SIZE + 1)},
        {"heard_counts": [1]},
        {"heard_counts": [1] * SIZE, "heard": ["one alone"]},
    ):
        swarm.send_and_wait(ones, **fields)
        assert swarm.act(ones, look=True) == [[]] * SIZE
    assert swarm.act(ones) == [[2.0]] * SIZE


def test_who_cannot_perceive_does_nothing_and_nothing_is_decided_for_him(swarm):
    few = [1] * SIZE
    few[3] = 0
    done = swarm.act([1.0] * (SIZE - 1), value_counts=few)
    assert done == [[1.0]] * 3 + [[]] + [[1.0]] * (SIZE - 4)
    assert swarm.nodes[3].agent.active_path == [START]
    assert swarm.act([1.0] * SIZE)[3] == [1.0]
    # He fails alone where the values are laid out alike, too.
    body = swarm.nodes[3].agent.body
    body.sense = lambda values, heard: 1 / 0
    assert swarm.act([-1.0] * SIZE) == [[2.0 if n != 3 else 0.0][: n != 3] for n in range(SIZE)]
    assert swarm.nodes[3].agent.active_path == ["Go"]
    assert swarm.nodes[2].agent.active_path == ["Wait"]


@pytest.mark.parametrize("wrong", [(("left",), ""), ((1.0,), None), (None, ""), (1.0, "")])
def test_a_body_that_returns_no_action_does_nothing_and_it_is_told(swarm, wrong):
    swarm.nodes[1].agent.body.answer = wrong
    swarm.nodes[2].agent.body.answer = ((1, True), "")
    told: list[msg.AgentStatus] = []
    swarm.desk.create_subscription(
        msg.AgentStatus, f"/agent_1/{names.STATUS}", told.append, qos.LATCHED
    )
    assert swarm.act([1.0] * SIZE)[:4] == [[1.0], [], [1.0, 1.0], [1.0]]
    swarm._process.until(lambda: told and told[-1].last_error)
    assert "act() of its body returned" in told[-1].last_error
    assert "it must return numbers and a text to say" in told[-1].last_error


def test_watching_a_host_reads_nothing_and_ends_nothing_where_a_feature_is_broken(
    process, start, tmp_path
):
    """Reading what no decision needs, for who watches, would end the host in a callback."""
    reads: list[str] = []

    def broken(body: Body) -> float:
        reads.append("for who watches")
        raise OSError("the sensor is unplugged")

    made = _domain("Choose")
    learned = TransitionTree().fit([[-1.0, 0.0], [1.0, 0.0]], ["Wait", "Go"])
    choose = replace(
        made.automata["Choose"],
        features=(Term("X"), Term("Broken")),
        transitions=dict.fromkeys((START, "Go", "Wait"), learned),
    )
    features = {**made.features, "Broken": Feature("Broken", broken)}
    domain = replace(made, features=features, automata={"Choose": choose})
    swarm = Swarm(process, start, tmp_path, domain)
    seen: list[msg.TransitionEvent] = []
    for number in range(SIZE):
        topic = f"/agent_{number}/{names.TRANSITIONS}"
        swarm.desk.create_subscription(msg.TransitionEvent, topic, seen.append, qos.EVENTS)
    for node in swarm.nodes:
        process.until(lambda node=node: node.count_publishers(names.TRANSITIONS))
        process.until(lambda node=node: node.count_subscribers(names.TRANSITIONS))
        node.transition_log.look()
    for round_ in range(1, 4):
        assert swarm.act([1.0] * SIZE)
        assert swarm.act([-1.0] * SIZE) == [[float(round_)]] * SIZE
        process.until(lambda n=round_: len(seen) == 2 * n * SIZE)
    event = seen[0]
    assert (event.from_state, event.to_state, event.commanded) == (START, "Go", False)
    assert [(f.name, f.value) for f in event.features] == [("X", 1.0)]
    assert event.probability == 1.0
    # Each agent itself looks in each percept whether it can be read by now.
    assert len(reads) == 6 * SIZE


def hear_faults(swarm: Swarm, number: int) -> list[list[str]]:
    told: list[list[str]] = []
    swarm.desk.create_subscription(
        msg.AgentStatus,
        f"/agent_{number}/{names.STATUS}",
        lambda status: told.append(list(status.faults)),
        qos.LATCHED,
    )
    swarm._process.until(lambda: told)
    return told


def test_who_fails_outside_its_body_fails_alone_and_says_so(swarm):
    # The percepts of all are handled in one callback.
    told, others = hear_faults(swarm, 3), hear_faults(swarm, 4)
    node = swarm.nodes[3]
    swarm.act([1.0] * SIZE)
    of_time, node.status.publish_soon = node.status.publish_soon, lambda: 1 / 0
    node._unsettled = True
    done = swarm.act([-1.0] * SIZE)
    assert done[:3] + done[4:] == [[1.0]] * (SIZE - 1)
    assert done[3] == []
    node.status.publish_soon = of_time
    node.status.publish()
    swarm._process.until(lambda: any("ZeroDivisionError" in f for told_ in told for f in told_))
    swarm.act([1.0] * SIZE)
    swarm._process.until(lambda: told[-1] == [])
    assert not any(others)


def test_a_fault_is_shown_until_the_agent_succeeds_not_until_others_do(swarm):
    failing = swarm.nodes[3]
    of_time, failing.status.publish_soon = failing.status.publish_soon, lambda: 1 / 0
    failing._unsettled = True
    swarm.act([1.0] * SIZE)
    failing.status.publish_soon = of_time
    assert list(failing.guard.faults.by_key) == ["acting"]
    others = [n for n in range(SIZE) if n != 3]
    for _ in range(2):
        swarm.act([1.0] * len(others), agents=others, value_counts=[1] * len(others))
        assert list(failing.guard.faults.by_key) == ["acting"]
    swarm.act([1.0] * SIZE)
    assert not failing.guard.faults


def test_what_is_wrong_with_a_host_is_said_by_all_its_agents(swarm):
    told = hear_faults(swarm, 5)
    swarm.act([1.0] * SIZE)
    swarm.desk.guard.failed("topic percepts", RuntimeError("of the host"))
    swarm._process.until(lambda: told[-1] and "of the host" in told[-1][0])
    swarm.desk.guard.faults.clear("topic percepts")
    swarm._process.until(lambda: told[-1] == [])


def test_a_host_whose_name_somebody_else_has_used_announces_itself_anew(swarm):
    # The world believes the roster with the highest number, and asks nobody else.
    real = swarm.rosters[-1]
    number = real.number + 10**9
    swarm._percepts.publish(msg.PerceptBatch(roster=number))
    swarm._process.until(lambda: swarm.rosters[-1].number > number)
    assert list(swarm.rosters[-1].agents) == list(real.agents)
    swarm.rosters[:] = swarm.rosters[-1:]
    assert swarm.act([1.0] * SIZE) == [[1.0]] * SIZE
    swarm._percepts.publish(msg.PerceptBatch(roster=2**64 - 1))  # which no world would send
    assert swarm.act([1.0] * SIZE) == [[2.0]] * SIZE
    assert len(swarm.rosters) == 1


def test_percepts_for_another_process_do_not_make_later_ones_of_the_host_old(swarm):
    swarm.act([1.0] * SIZE)
    arrived = len(swarm.arrived)
    swarm._percepts.publish(msg.PerceptBatch(roster=1, sequence=swarm._sequence + 500))
    swarm._process.until(lambda: len(swarm.arrived) > arrived)
    assert swarm.act([1.0] * SIZE) == [[2.0]] * SIZE


def test_a_host_answers_each_piece_once_and_restarts_those_who_missed_the_restart(
    process, start, tmp_path
):
    swarm = Swarm(process, start, tmp_path, machine="lab_1")
    (roster,) = swarm.rosters
    assert roster.machine == "lab_1"
    pieces = swarm.desk.create_publisher(
        msg.PerceptBatch, f"/{roster.host}/{names.PERCEPT_PIECES}", qos.PIECES
    )
    answers: list[msg.ActionBatch] = []
    topic = f"/world/{names.ACTION_PIECES}"
    swarm.desk.create_subscription(msg.ActionBatch, topic, answers.append, qos.PIECES)
    process.until(lambda: pieces.get_subscription_count() == 1)

    def send(sequence: int, agents: list[int], episode: int = 1) -> None:
        size = len(agents)
        piece = msg.PerceptBatch(roster=roster.number, sequence=sequence, episode=episode)
        piece.agents, piece.value_counts, piece.values = agents, [1] * size, [1.0] * size
        publish_pieces(pieces, [piece])

    def perform(sequence: int, agents: list[int], episode: int = 1) -> list[float]:
        def copies() -> list[msg.ActionBatch]:
            return [a for a in answers if a.sequence == sequence and list(a.agents) == agents]

        send(sequence, agents, episode)
        process.until(lambda: len(copies()) == 2)
        first, second = copies()
        assert first == second
        return list(first.values)

    early = count(1)
    process.until(lambda: send(next(early), []) or answers)
    assert perform(90_011, [0, 1]) == [1.0, 1.0]
    assert perform(90_011, [2]) == [1.0]
    assert perform(90_012, [0, 1]) == [2.0, 2.0]
    send(90_011, [3])  # overtaken: what it asks for is over
    assert perform(90_012, [2, 3]) == [2.0, 1.0]
    restarts: list[int] = []
    for number, node in enumerate(swarm.nodes):
        node.agent.restart = lambda seed, episode, number=number: restarts.append(number)
    perform(90_013, [0], episode=2)
    perform(90_014, [0, 1], episode=2)
    perform(90_015, [1, 2], episode=2)
    assert restarts == [0, 1, 2]
    assert perform(4, [0]), "a world with lower numbers is another world"
