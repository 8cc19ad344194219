"""Members that halt without their commanders, in hosts and in a tree of commanders."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from hitab_msgs import msg

from hitab_ros import names, qos

SQUAD = "commander: Squad\norders: {Attack: Search, Retreat: Home}\n"
ARMY = "commander: Army\norders: {Attack: Attack, Retreat: Retreat}\n"
MANY = 300
HALT = {"when_out_of_reach": "halt", "out_of_reach_after": 1.0}


def crowd(team: Any, host: Any, count: int, **settings: Any) -> list[Any]:
    """Have many ants in a host; nobody asks for their topics."""
    settings |= HALT | {"library": str(team.folder / "library"), "is_watched": False}
    return [team.ant(f"ant_{i}", "chief", host=host, **settings) for i in range(count)]


def ends(*nodes: Any) -> list[str]:
    return [end.topic_name for node in nodes for end in (*node.publishers, *node.subscriptions)]


@contextmanager
def process_of_chief(team: Any, *subordinates: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a commander in a process of its own."""
    file = team.folder / "squad.yaml"
    file.write_text(SQUAD)
    line = [sys.executable, "-m", "hitab_commander.commander_main", "--ros-args"]
    line += ["-r", "__ns:=/chief", "-p", f"domain:={file}", "-p", "swarm:=team"]
    line += ["-p", f"subordinates:=[{', '.join(subordinates)}]"]
    line += ["-p", f"state_dir:={team.folder / 'state_of_chief'}"]
    number = team.context.get_domain_id()
    process = subprocess.Popen(line, env={**os.environ, "ROS_DOMAIN_ID": str(number)})
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def test_many_in_a_host_halt_while_the_process_of_their_commander_is_suspended(team):
    host = team.host("barracks")
    before = len(ends(host.desk))
    ants = crowd(team, host, MANY)
    assert len(ends(host.desk)) <= before + 2, "signs of life, and actions to the world"
    assert not ends(*ants)
    host.publish_roster()

    def faults() -> set[str]:
        return {"; ".join(ant.guard.faults.texts()).rpartition(" ")[0] for ant in ants}

    def acting() -> int:
        return sum(bool(ant.answer(msg.Percept())[0]) for ant in ants)

    with process_of_chief(team, *(ant.agent_name for ant in ants)) as chief:
        team.perform("chief", "Retreat")
        team.until(lambda: all(ant.agent.behavior == "Home" for ant in ants))
        host.play(MANY)
        assert acting() == MANY
        team.until(lambda: host.shared.reach._heard)
        chief.send_signal(signal.SIGSTOP)
        team.until(lambda: faults() == {"chief is out of reach: silent since"})
        assert acting() == 0
        chief.send_signal(signal.SIGCONT)
        team.until(lambda: faults() == {""})
        assert acting() == MANY
        assert {ant.agent.behavior for ant in ants} == {"Home"}


def test_a_commander_in_the_same_process_is_always_in_reach(team):
    team.gives_signs = False
    host = team.host("barracks")
    (ant,) = crowd(team, host, 1)
    team.commander("chief", SQUAD, ["ant_0"], host=host)
    host.publish_roster()
    team.perform("chief", "Retreat")
    team.until(lambda: ant.agent.behavior == "Home")
    host.play(1)
    # Another host claims to run the commander too, and falls silent.
    rosters = team.link.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    rosters.publish(msg.HostRoster(host="other", number=1, agents=["chief"], swarm="team"))
    signs = team.link.create_publisher(msg.Alive, f"/{names.ALIVE}", qos.SIGNS_OF_LIFE)
    watch = host.shared.reach
    team.until(lambda: signs.publish(msg.Alive(process="other")) or watch._heard)
    team.until(lambda: watch._time.now() - watch._heard["chief"][0] > 2.0)
    assert ant.answer(msg.Percept())[0]


def test_a_group_that_halts_comes_to_rest_when_its_top_is_out_of_reach(team):
    """As it does when the machine of all upper commanders is lost, but not that of its own."""
    team.gives_signs = False
    host = team.host("field")
    (ant,) = crowd(team, host, 1, superiors=["major"])
    bold = team.ant("bold", "chief", host=host, **HALT)
    chief = team.commander("chief", SQUAD, ["ant_0", "bold"], "major", host=host, **HALT)
    host.publish_roster()
    host.play(2)
    signs = team.link.create_publisher(msg.Alive, f"/{names.ALIVE}", qos.SIGNS_OF_LIFE)
    team.until(signs.get_subscription_count)
    team.perform("chief", "Retreat")
    team.until(lambda: {ant.agent.behavior, bold.agent.behavior} == {"Home"})

    def acts(*ants: Any) -> list[bool]:
        return [bool(ant.answer(msg.Percept())[0]) for ant in ants]

    team.until(lambda: signs.publish(msg.Alive(process="major")) or host.shared.reach._heard)
    assert acts(ant, bold) == [True, True]
    team.until(lambda: acts(ant) == [False])
    assert acts(bold) == [True], "who does not wait for the major goes on"
    assert "major is out of reach" in "".join(chief.guard.faults.texts())
    team.until(lambda: signs.publish(msg.Alive(process="major")) or acts(ant) == [True])
