"""What `hitab up` says of swarms beside it, and of commanders that do not hear everybody yet."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from hitab_msgs.msg import CommanderStatus, Subordinate

from hitab_bringup import bringing_up
from hitab_client import RosLink, RunFolder, domain_ids
from hitab_ros import names, qos

RECORD = SimpleNamespace(namespace="", identity="red-0a1b2c3d", agents=("captain", "a", "b"))


def test_a_swarm_that_is_not_in_ros_domain_0_says_who_is(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    there = [(None, SimpleNamespace(swarm=name, domain_id=n)) for name, n in (("a", 0), ("b", 1))]
    monkeypatch.setattr(bringing_up, "running_swarms", lambda: there)
    swarm = SimpleNamespace(name="red")
    said = "ROS domain 0 has the swarm a; red starts in ROS domain 6"
    assert list(bringing_up._beside_others(swarm, [], 6)) == [said]
    assert list(bringing_up._beside_others(swarm, [], 0)) == []
    assert list(bringing_up._beside_others(swarm, [0], 6)) == [], "said when it was refused"
    monkeypatch.setenv("ROS_DOMAIN_ID", "6")
    assert list(bringing_up._beside_others(swarm, [], 6)) == []


def test_a_swarm_says_how_it_is_told_from_others_of_its_name(monkeypatch):
    def found(swarm, number):
        return RunFolder(Path(f"/{number}")), SimpleNamespace(
            swarm=swarm, identity=f"{swarm}-{number}"
        )

    there = [found("red", 1), found("red", 2), found("blue", 3)]
    monkeypatch.setattr(bringing_up, "running_swarms", lambda: there)
    folder, record = there[1]
    assert list(bringing_up._namesakes(record, folder)) == [
        "another red is up already: red-1, in /1; this one is red-2, and --swarm red-2 chooses it"
    ]


@pytest.fixture
def group():
    """Yield a link, and a function that says whom the captain does not hear."""
    with domain_ids.reserved() as number, RosLink(number) as robots, RosLink(number) as link:
        topic = names.of_agent("captain", names.GROUP)
        publisher = robots.node.create_publisher(CommanderStatus, topic, qos.LATCHED)

        def publish(*silent: bool) -> None:
            publisher.publish(
                CommanderStatus(
                    commander="captain",
                    swarm=RECORD.identity,
                    subordinates=[
                        Subordinate(name=name, silent=quiet)
                        for name, quiet in zip("ab", silent, strict=True)
                    ],
                )
            )

        yield link, publish


def test_up_waits_until_commanders_hear_everybody_or_says_that_they_do_not_yet(group, monkeypatch):
    link, publish = group
    swarm = SimpleNamespace(world=None, commanders=[SimpleNamespace(name="captain")])
    monkeypatch.setattr(bringing_up, "START_SECONDS_EACH", 0.0)
    monkeypatch.setattr(bringing_up, "COMMANDERS_SECONDS", 0.1)
    publish(False, True)
    (said,) = bringing_up._await_commanders(swarm, RECORD, link, None)
    assert said.startswith("captain does not hear all subordinates yet")
    monkeypatch.setattr(bringing_up, "COMMANDERS_SECONDS", 60.0)
    seen = []

    def progress(done: int, total: int, missing: str) -> None:
        seen.append((done, total, missing))
        publish(False, len(seen) < 3)

    assert list(bringing_up._await_commanders(swarm, RECORD, link, progress)) == []
    assert seen[0] == (0, 1, "captain")
    assert seen[-1] == (1, 1, "")


def test_up_says_that_commands_to_a_large_swarm_take_their_time(monkeypatch):
    assert list(bringing_up._slow_to_command(RECORD)) == []
    large = SimpleNamespace(agents=tuple(f"a{i}" for i in range(1251)))
    monkeypatch.setattr(bringing_up, "busy", lambda: "")
    (told,) = bringing_up._slow_to_command(large)
    assert told == (
        "with 1251 agents, each command takes some seconds to find those that it needs"
    )
    monkeypatch.setattr(bringing_up, "busy", lambda: "this machine is busy (load 6.0 on 2 cores)")
    (told,) = bringing_up._slow_to_command(large)
    assert "minutes at first: this machine is busy (load 6.0 on 2 cores)" in told


def test_a_commander_that_lacks_values_only_at_first_has_no_fault_at_the_start():
    faults = {"captain": ["captain decides without what it needs"], "a": ["is lost"]}
    agents = SimpleNamespace(
        statuses={n: SimpleNamespace(faults=f, perceived=True) for n, f in faults.items()}
    )
    tried = []

    def spin_until(done, seconds: float) -> bool:
        while not done():
            tried.append(seconds)
            faults["captain"].clear()  # its subordinates have reported
        return True

    bringing_up._let_agents_perceive(SimpleNamespace(spin_until=spin_until), agents, ["captain"])
    assert tried == [bringing_up.VALUES_SECONDS]
    assert faults == {"captain": [], "a": ["is lost"]}
