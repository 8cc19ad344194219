"""A host takes a distribution in once for all of its agents, and goes on meanwhile."""

import os
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from bodies import Body
from hitab_msgs import msg

from hitab_agent.host_resources import HostResources
from hitab_agent.node.agent_node import AgentNode
from hitab_agent.scheduler import JobQueue
from hitab_core.agent import Agent
from hitab_core.domain import BasicBehavior, Domain, Feature, Target
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.library import bundle, change, loaded_library
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.bundle import Bundle, make_bundle
from hitab_core.library.durable_files import locked
from hitab_core.operations import Distribute
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.training import Curriculum
from hitab_ros import names, qos

SIZE = 12
SECONDS = 60.0


DOMAIN = Domain.of(
    "pupils",
    "1",
    Body,
    behaviors=[
        BasicBehavior("Left"),
        BasicBehavior("Right"),
        BasicBehavior("Near", parameters=("A",)),
    ],
    features=[Feature("x", lambda body: body.x)],
    targets=[Target("ball", lambda body: None)],
)


def taught(folder: Path, name: str, *states: str, parameters: tuple[str, ...] = ()) -> Bundle:
    """Return a bundle of a behavior and of what it is made of, taught to some agent."""
    teacher = Agent("teacher", DOMAIN, BehaviorLibrary(folder, DOMAIN))
    arguments = ("ball",) * len(parameters)
    teacher.begin(Curriculum(name, (Term("x"),), (), parameters, arguments), discard=True)
    for x, state in enumerate(states):
        teacher.sense([float(x)], [])
        teacher.command(Term.parse(state))
    teacher.save()
    return make_bundle(teacher.loaded.texts, teacher.repertoire, name)


@dataclass
class Host:
    """A host with agents, and what a sender hears of them.

    Attributes:
        heard: acknowledgements and statuses, in the order in which they came.
    """

    process: Any
    start: Any
    folder: Path
    own_libraries: bool
    size: int = SIZE
    behavior: str = ""
    heard: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.desk = self.process.node
        self.shared = HostResources(self.desk, is_host=True, on_demand=True)
        self.nodes = [self._node(number) for number in range(self.size)]
        self.agents = [node.agent for node in self.nodes]
        self._sent = 0
        self._sender = self.desk.create_publisher(
            msg.Distribution, f"/{names.DISTRIBUTION}", qos.EVENTS
        )
        self.desk.create_subscription(
            msg.DistributionAck,
            f"/{names.DISTRIBUTION_ACK}",
            self.heard.append,
            qos.ROLL_CALL,
        )
        self.process.until(lambda: self._sender.get_subscription_count() == 1)
        acks = f"/{names.DISTRIBUTION_ACK}"
        self.process.until(lambda: self.desk.count_publishers(acks) == 1)

    def _node(self, number: int) -> AgentNode:
        library = "" if self.own_libraries else str(self.folder / "library")
        more = {"library": library, "behavior": self.behavior, "state_dir": str(self.folder)}
        return self.start(DOMAIN, f"pupil_{number}", shared=self.shared, **more).node

    def send(self, sent: Bundle, **fields: Any) -> None:
        """Send a bundle to all; return at once."""
        self._sent += 1
        self._sender.publish(
            msg.Distribution(
                sequence=self._sent,
                source="teacher",
                behavior=sent.name,
                digest=sent.digest,
                files=[msg.BehaviorFile(name=n, text=t) for n, t in sent.files],
                **fields,
            )
        )

    def answers(self) -> dict[str, msg.DistributionAck]:
        """Wait for the acknowledgements of what was sent last."""

        def acks() -> dict[str, msg.DistributionAck]:
            return {
                ack.agent: ack
                for ack in self.heard
                if isinstance(ack, msg.DistributionAck) and ack.sequence == self._sent
            }

        self.process.until(lambda: len(acks()) == self.size)
        return acks()


@pytest.fixture(params=[False, True], ids=["one library", "a library each"])
def host(request: Any, process: Any, start: Any, tmp_path: Path) -> Host:
    return Host(process, start, tmp_path / "swarm", request.param)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Count what is expensive."""
    counts: Counter[str] = Counter()

    def count(module: Any, name: str, what: str) -> None:
        real = getattr(module, name)

        def counting(*args: Any, **more: Any) -> Any:
            counts[what] += 1
            return real(*args, **more)

        monkeypatch.setattr(module, name, counting)

    count(bundle, "bundle_digest", "digests")
    count(loaded_library, "read_behavior", "readings")
    count(TransitionTree, "fit", "trees")
    count(loaded_library, "Repertoire", "repertoires")
    count(change, "commit", "writes")
    return counts


def test_what_is_distributed_is_read_and_learned_once_and_written_once_per_library(
    host, counted, tmp_path
):
    taught(tmp_path / "teacher", "Low", "Left", "Right")
    high = taught(tmp_path / "teacher", "High", "Low")
    assert [name for name, _ in high.files] == ["Low", "High"]
    counted.clear()
    host.send(high)
    answers = host.answers()
    assert {(ack.success, ack.digest, ack.message) for ack in answers.values()} == {
        (True, high.digest, "")
    }
    assert counted["readings"] == 2
    assert counted["trees"] <= 3 + 2  # one for each state of each behavior
    assert counted["repertoires"] == 1
    assert counted["digests"] == 2  # verified, and what the library has then
    assert counted["writes"] == (SIZE if host.own_libraries else 1)
    assert len({id(agent.repertoire) for agent in host.agents}) == 1
    for agent in host.agents:
        again = BehaviorLibrary(agent.library.folder, DOMAIN)
        assert again.texts() == dict(high.files)
        agent.perform(Term("High"))


def test_what_is_acknowledged_is_in_every_library_whoever_reads_it_and_in_every_status(
    host, tmp_path
):
    low = taught(tmp_path / "teacher", "Low", "Left", "Right")
    statuses = []
    for node in host.nodes:
        end = node.status.topic.end
        publish = end.publish
        end.publish = lambda s, publish=publish: (
            statuses.append((s.agent, s.library_digest)),
            publish(s),
        )
    acknowledge = host.shared.distributions._acknowledgements
    real = acknowledge.publish
    wrong = []

    def looked_at(ack):
        agent = host.agents[int(ack.agent.rpartition("_")[2])]
        # As a process would that is started now.
        if BehaviorLibrary(agent.library.folder, DOMAIN).texts() != dict(low.files):
            wrong.append(f"{ack.agent}: not in its library")
        if (agent.name, agent.loaded.digest) not in statuses:
            wrong.append(f"{ack.agent}: not in its status")
        real(ack)

    acknowledge.publish = looked_at
    host.send(low)
    host.answers()
    assert not wrong


def test_percepts_are_answered_while_a_distribution_is_taken_in(host, tmp_path):
    low = taught(tmp_path / "teacher", "Low", "Left", "Right")
    (link,) = host.shared.links.values()
    rosters: list[msg.HostRoster] = []
    answered: list[int] = []
    desk = host.desk
    desk.create_subscription(msg.HostRoster, f"/{names.HOSTS}", rosters.append, qos.LATCHED)
    link.listen()
    host.shared.publish_roster()
    host.process.until(lambda: rosters)
    percepts = desk.create_publisher(
        msg.PerceptBatch, f"/{rosters[0].host}/{names.PERCEPTS}", qos.CYCLE
    )

    def next_cycle(answer: msg.ActionBatch) -> None:
        answered.append(answer.sequence)
        see(answer.sequence + 1)

    def see(sequence: int) -> None:
        percepts.publish(
            msg.PerceptBatch(
                roster=rosters[0].number,
                sequence=sequence,
                cycle=sequence,
                agents=range(SIZE),
                value_counts=[1] * SIZE,
                values=[1.0] * SIZE,
            )
        )

    desk.create_subscription(
        msg.ActionBatch, f"/world/{names.ACTION_BATCHES}", next_cycle, qos.CYCLE
    )
    host.process.until(lambda: percepts.get_subscription_count() == 1)
    see(1)
    host.process.until(lambda: len(answered) > 3)
    swaps = []
    for agent in host.agents:

        def slow(*args, take_up=agent.take_up):
            swaps.append(len(answered))
            end = time.monotonic() + 0.02  # longer than a slice: one to a turn
            while time.monotonic() < end:
                pass
            return take_up(*args)

        agent.take_up = slow
    host.send(low)
    host.answers()
    assert all(later > earlier for earlier, later in zip(swaps, swaps[5:], strict=False))
    assert swaps[-1] - swaps[0] > SIZE // 4


def test_distributions_are_taken_in_in_the_order_in_which_they_came(host, tmp_path):
    first = taught(tmp_path / "teacher", "Low", "Left")
    second = taught(tmp_path / "teacher", "Low", "Right")
    host.send(first)
    host.send(second)
    host.answers()
    assert {agent.loaded.texts["Low"] for agent in host.agents} == {dict(second.files)["Low"]}
    for agent in host.agents:
        assert BehaviorLibrary(agent.library.folder, DOMAIN).texts() == dict(second.files)


def test_what_changed_on_its_way_is_refused_by_all_and_nothing_is_written(host, tmp_path):
    low = taught(tmp_path / "teacher", "Low", "Left")
    host.send(Bundle(tuple((n, t + "\n") for n, t in low.files), low.digest))
    for ack in host.answers().values():
        assert not ack.success
        assert "corrupted in transit" in ack.message
    assert not list((tmp_path / "swarm").rglob("*.hfa.yaml"))


def test_whoever_performs_what_would_not_fit_keeps_what_it_knew_and_says_so(host, tmp_path):
    host.send(taught(tmp_path / "teacher", "Go", "Near(A)", parameters=("A",)))
    host.answers()
    busy = host.agents[3]
    busy.perform(Term("Go", ("ball",)))
    before = busy.loaded
    other = taught(tmp_path / "teacher", "Go", "Left")
    host.send(other)
    answers = host.answers()
    refused = answers.pop(busy.name)
    assert not refused.success
    assert 'could no longer perform "Go(ball)"' in refused.message
    assert {ack.success for ack in answers.values()} == {True}
    assert busy.loaded is before
    assert busy.behavior == "Go(ball)"
    kept = BehaviorLibrary(busy.library.folder, DOMAIN).texts()
    if host.own_libraries:
        assert kept == before.texts
    else:
        assert kept == dict(other.files)
        assert "reload the library to use it" in refused.message
    # What is to be started at once counts, not what is performed now.
    host.send(other, start=True)
    assert host.answers()[busy.name].success
    assert {agent.behavior for agent in host.agents} == {"Go"}


def test_a_disk_that_does_not_take_it_leaves_memory_and_libraries_as_they_were(
    host, tmp_path, monkeypatch
):
    host.send(taught(tmp_path / "teacher", "Low", "Left"))
    host.answers()
    before = host.agents[0].loaded.texts
    low = taught(tmp_path / "teacher", "Low", "Right")

    def failing(descriptor):
        raise OSError(5, "Input/output error")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", failing)
        host.send(low)
        for ack in host.answers().values():
            assert not ack.success
            assert "Input/output error" in ack.message
    for agent in host.agents:
        assert agent.loaded.texts == before
        assert agent.reload() == ["Low"]
        assert agent.loaded.texts == before


def test_a_library_that_somebody_else_holds_is_waited_for_and_holds_up_no_cycle(host, tmp_path):
    low = taught(tmp_path / "teacher", "Low", "Left")
    held = host.agents[0].library.folder
    held.mkdir(parents=True, exist_ok=True)
    done: list[Any] = []
    host.process.meanwhile(done)
    with locked(held, alone=True):
        host.send(low)
        host.process.until(lambda: len(done) > 50)
        assert not any(isinstance(ack, msg.DistributionAck) for ack in host.heard)
    assert {ack.success for ack in host.answers().values()} == {True}


def test_a_save_while_a_distribution_is_under_way_loses_neither(host, tmp_path):
    low = taught(tmp_path / "teacher", "Low", "Left")
    saver = host.agents[-1]
    saver.begin(Curriculum("Own", (Term("x"),)))
    saver.sense([1.0], [])
    saver.command(Term("Right"))
    first = host.agents[0]
    take_up = first.take_up

    def save_first(*args):
        saver.save()
        return take_up(*args)

    first.take_up = save_first
    host.send(low)
    host.answers()
    assert {"Low", "Own"} == {*saver.loaded.files}
    assert BehaviorLibrary(saver.library.folder, DOMAIN).texts() == saver.loaded.texts


def test_a_job_that_fails_does_not_keep_others_from_being_done(process):
    jobs = JobQueue(process.node)
    done = []

    def job(number):
        yield None
        if number == 1:
            raise ValueError(number)
        done.append(number)

    for number in range(3):
        jobs.do(job(number))
    process.until(lambda: done == [0, 2])


def test_who_fails_at_a_distribution_does_not_keep_it_from_the_others(process, start, tmp_path):
    host = Host(process, start, tmp_path, True, size=3)
    first = host.nodes[0]
    first.answered = lambda *_: 1 / 0
    host.send(taught(tmp_path / "teacher", "Low", "Left"))
    process.until(lambda: {"pupil_1", "pupil_2"} <= {ack.agent for ack in host.heard})
    assert "distribution failed: ZeroDivisionError" in first.guard.faults.texts()[0]
    assert not any(node.guard.faults for node in host.nodes[1:])


def test_distributions_are_told_apart_while_simulated_time_stands_still(start):
    one = start(DOMAIN, use_sim_time=True)
    one.agent.begin(Curriculum("Low", (Term("x"),)))
    one.perceive()
    one.agent.command(Term("Left"))
    one.agent.save()
    sent = [one.do(Distribute("Low")) for _ in range(2)]
    assert 0 < sent[0].sequence < sent[1].sequence


def test_who_cannot_perform_its_start_behavior_is_there_idle_and_says_why(
    process, start, tmp_path
):
    host = Host(process, start, tmp_path, True, size=1, behavior="Gone")
    (agent,) = host.agents
    assert agent.mode is Mode.IDLE
    told: list[msg.AgentStatus] = []
    host.desk.create_subscription(
        msg.AgentStatus, f"/pupil_0/{names.STATUS}", told.append, qos.LATCHED
    )
    process.until(lambda: told)
    assert 'pupil_0 is idle: it cannot perform its start behavior "Gone"' in told[-1].last_error
    assert "have it perform something else, or give it the behavior" in told[-1].last_error
    host.send(taught(tmp_path / "teacher", "Gone", "Left"), start=True)
    assert host.answers()["pupil_0"].success
    assert agent.behavior == "Gone"
