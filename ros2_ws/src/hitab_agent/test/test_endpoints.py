"""A hosted agent has the topics and services that somebody asks for, for as long as they do."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from bodies import Body
from hitab_msgs import msg, srv

from hitab_agent import endpoints_on_demand
from hitab_agent.host_resources import HostResources
from hitab_core import BasicBehavior, Domain, Feature
from hitab_ros import names, qos

DOMAIN = Domain.of(
    "asked",
    "1",
    Body,
    behaviors=[BasicBehavior("Go"), BasicBehavior("Wait")],
    features=[Feature("X", lambda body: body.x)],
)
PERCEPT = msg.Percept.get_fields_and_field_types()
AGENTS = ("one", "two", "three")


class Host:
    """A host of three agents, which nobody has asked for anything."""

    def __init__(self, process: Any, start: Any, *, on_demand: bool = True) -> None:
        self.process, self.desk = process, process.node
        self.shared = HostResources(self.desk, is_host=True, on_demand=on_demand)
        made = (start(DOMAIN, name, shared=self.shared, watched=False) for name in AGENTS)
        self.nodes = {one.name: one.node for one in made}

    def ends(self, name: str) -> set[str]:
        """Return the topics and services of an agent."""
        node = self.nodes[name]
        ends = [*node.publishers, *node.subscriptions]
        topics = {end.topic_name.rpartition("/")[2] for end in ends} - {"parameter_events"}
        services = {service.srv_name.removeprefix(f"/{name}/") for service in node.services}
        return topics | {name for name in services if not name.startswith("agent/")}  # of rclpy

    def subscribe(self, kind: Any, topic: str, profile: Any) -> tuple[list[Any], Any]:
        came: list[Any] = []
        end = self.desk.create_subscription(kind, topic, came.append, profile, temporary=True)
        return came, end


@pytest.fixture
def host(process: Any, start: Any, monkeypatch: pytest.MonkeyPatch) -> Host:
    monkeypatch.setattr(endpoints_on_demand, "UNUSED_LOOKS", 1)
    return Host(process, start)


def test_who_is_asked_for_nothing_has_nothing(host: Host) -> None:
    for _ in range(2):
        host.shared.on_demand.look()
    assert all(host.ends(name) == set() for name in AGENTS)


def test_a_command_is_obeyed_by_whom_it_is_sent_to_and_the_topic_goes_with_its_sender(
    host: Host,
) -> None:
    for _ in range(3):  # whoever asks again is answered again
        sender = host.desk.create_publisher(
            msg.Command, "/two/command", qos.EVENTS, temporary=True
        )
        host.process.until(lambda: host.ends("two") == {"command"})
        host.process.until(lambda sender=sender: sender.get_subscription_count() == 1)
        sender.publish(msg.Command(behavior="Go"))
        status = host.nodes["two"].status
        host.process.until(lambda status=status: "not training" in status.message.last_error)
        assert host.ends("two") == {"command"}
        assert host.ends("one") == set()
        sender.publish(msg.Command(behavior="Go"))  # the subscription goes with this in its queue
        host.desk.destroy_publisher(sender)
        host.process.until(lambda: host.ends("two") == set())
        status.report_error(None)


def test_a_late_subscriber_gets_the_status_as_it_is_and_each_later_one(host: Host) -> None:
    host.nodes["one"].agent.perform(None)
    host.nodes["one"].status.publish()
    came, end = host.subscribe(msg.AgentStatus, "/one/status", qos.LATCHED)
    host.process.until(lambda: came)
    assert (came[-1].agent, came[-1].mode) == ("one", "idle")
    host.nodes["one"].status.report_error(ValueError("something else"))
    host.process.until(lambda: "something else" in came[-1].last_error)
    host.desk.destroy_subscription(end)
    host.process.until(lambda: host.ends("one") == set())


def test_a_subscriber_that_asks_for_nothing_earlier_gets_the_status_again(host: Host) -> None:
    volatile, latched = [], []
    for came, profile in ((volatile, qos.EVENTS), (latched, qos.LATCHED)):
        name = "one" if came is volatile else "two"
        host.desk.create_subscription(
            msg.AgentStatus, f"/{name}/status", came.append, profile, temporary=True
        )
    host.process.until(lambda: len(volatile) > endpoints_on_demand.REPEATING_LOOKS)
    assert len({status.sequence for status in volatile}) == 1
    assert len(latched) == 1


def test_a_host_loads_the_libraries_of_its_agents_and_names_those_that_refuse(
    host: Host, tmp_path: Path
) -> None:
    client = host.desk.create_client(srv.LoadLibrary, "/load_library")

    def load(**fields: str) -> Any:
        host.process.until(client.service_is_ready)
        answer = client.call_async(srv.LoadLibrary.Request(**fields))
        host.process.until(answer.done)
        return answer.result()

    done = load()
    assert done.success
    assert done.message == "one, two, three: 0 trained behaviors"
    assert all(not host.ends(name) for name in AGENTS)
    refused = load(path=str(tmp_path / "nothing"))
    assert not refused.success
    assert "one, two, three: " in refused.message
    assert "is not a folder here" in refused.message


def test_only_the_service_that_is_called_is_there(host: Host) -> None:
    client = host.desk.create_client(srv.Perform, "/three/perform")
    host.process.until(client.service_is_ready)
    answer = client.call_async(srv.Perform.Request(behavior="Go"))
    host.process.until(answer.done)
    assert answer.result().success
    assert host.nodes["three"].agent.behavior == "Go"
    assert host.ends("three") == {"perform"}
    host.desk.destroy_client(client)
    host.process.until(lambda: host.ends("three") == set())


def test_a_topic_that_somebody_else_publishes_is_not_asked_for(host: Host) -> None:
    host.desk.create_publisher(msg.AgentStatus, "/one/status", qos.LATCHED)
    host.subscribe(msg.Command, "/one/command", qos.EVENTS)
    host.process.until(lambda: host.desk.count_publishers("/one/status"))
    host.shared.on_demand.look()
    assert host.ends("one") == set()


def test_what_a_hosted_agent_perceives_is_published_from_the_next_percept_on(host: Host) -> None:
    came, _ = host.subscribe(msg.Percept, "/one/perceived", qos.PERCEIVED)
    host.process.until(lambda: "perceived" in host.ends("one"))
    log = host.nodes["one"].percept_log
    host.process.until(lambda: log._receivers.count)
    shared = SimpleNamespace(**{field: getattr(msg.Percept(), field) for field in PERCEPT})
    for cycle in (4, 5):
        shared.cycle, shared.values = cycle, [float(cycle)]
        log.tell(shared)
        shared.values = [0.0]  # one object for all agents of a host
    host.process.until(lambda: len(came) == 2)
    assert [(p.cycle, list(p.values)) for p in came] == [(4, [4.0]), (5, [5.0])]


def test_all_endpoints_are_there_at_once_where_a_host_is_told_so(process: Any, start: Any) -> None:
    host = Host(process, start, on_demand=False)
    topics = {names.STATUS, names.COMMAND, names.TRANSITIONS, names.TRAINING}
    assert topics | {"perform", "get_vocabulary"} <= host.ends("one")


# -- statuses of all --------------------------------------------------------------------------


def test_who_reads_the_statuses_gets_all_and_then_what_changes_and_who_does_not_costs_nothing(
    host: Host,
) -> None:
    sent: list[Any] = []
    end = host.shared.batches._publisher
    publish = end.publish
    end.publish = lambda message: (sent.append(message), publish(message))
    host.nodes["one"].status.publish()
    done: list[Any] = []
    host.process.meanwhile(done)
    host.process.until(lambda: len(done) > 10)
    assert sent == []

    known: dict[str, msg.AgentStatus] = {}

    def take(batch: msg.HostStatuses) -> None:
        known.update((status.agent, status) for status in batch.agents)

    host.desk.create_subscription(msg.HostStatuses, f"/{names.STATUSES}", take, qos.STATUSES)
    host.process.until(lambda: known.keys() == {*AGENTS})
    del sent[:]
    host.nodes["two"].status.report_error(ValueError("only the second"))
    host.process.until(lambda: "only the second" in known["two"].last_error)
    assert [[status.agent for status in batch.agents] for batch in sent] == [["two"]]
    late: list[str] = []
    host.desk.create_subscription(
        msg.HostStatuses,
        f"/{names.STATUSES}",
        lambda batch: late.extend(status.agent for status in batch.agents),
        qos.STATUSES,
    )
    host.process.until(lambda: {*late} == {*AGENTS})


# -- commands to many -------------------------------------------------------------------------


def test_commands_to_many_reach_each_and_a_bad_one_harms_nobody(host: Host) -> None:
    sender = host.desk.create_publisher(msg.Commands, f"/{names.COMMANDS}", qos.EVENTS)
    host.process.until(sender.get_subscription_count)
    sender.publish(msg.Commands(agents=["one", "two"], commands=[msg.Command()]))
    host.process.until(lambda: host.desk.guard.faults)
    assert "2 agents and 1 commands" in host.desk.guard.faults.texts()[0]
    commands = {
        "one": msg.Command(behavior="Go"),
        "stranger": msg.Command(behavior="Go"),
        "two": msg.Command(by="\x1b[31m"),
        "three": msg.Command(behavior="Wait"),
    }
    sender.publish(msg.Commands(agents=[*commands], commands=[*commands.values()]))
    errors = {name: host.nodes[name].status.message for name in AGENTS}
    host.process.until(lambda: all(status.last_error for status in errors.values()))
    said = [errors[name].last_error for name in AGENTS]
    assert "control characters" in said[1]
    assert "not training" in said[0]
    assert "not training" in said[2]
