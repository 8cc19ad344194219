"""HiTAB's DDS profiles."""

import os
import signal
import subprocess
import sys

import pytest

from hitab_client import RosLink, dds_profile, domain_ids
from hitab_client.connecting.dds_profile import (
    LOOPBACK,
    NETWORK,
    RANGE,
    VARIABLES,
    choose_profile,
    is_of_this_machine,
)


def test_no_profile_of_hitab_uses_shared_memory():
    script = """
import os
from hitab_client import RosLink
before = set(os.listdir("/dev/shm"))
with RosLink() as link:
    link.spin(0.1)
    mine = [n for n in set(os.listdir("/dev/shm")) - before if "fastrtps" in n]
    maps = open("/proc/self/maps").read()
    print([name for name in mine if name in maps])
"""
    for reach in ("LOCALHOST", "SUBNET"):
        environment = {k: v for k, v in os.environ.items() if k not in VARIABLES}
        done = subprocess.run(
            [sys.executable, "-c", script],
            env={**environment, "ROS_AUTOMATIC_DISCOVERY_RANGE": reach},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.stdout == "[]\n", done.stderr


def test_a_program_that_was_suspended_until_it_was_forgotten_says_so(tmp_path, monkeypatch):
    """Otherwise it would wait forever for nodes that it does not rediscover."""
    script = """
from hitab_client import RosLink
with RosLink(name="sleeper") as link:
    print("ready", flush=True)
    link.spin_until(lambda: False, 60.0)
"""
    monkeypatch.setattr(dds_profile, "SHORTEST_LEASE_S", 2.0)
    profile = dds_profile.profile_for(tmp_path, 2).rename(tmp_path / "own.xml")
    with domain_ids.reserved() as number, RosLink(number) as link:
        sleeper = subprocess.Popen(
            [sys.executable, "-c", script],
            env=os.environ
            | dict.fromkeys(VARIABLES, str(profile))
            | {"ROS_DOMAIN_ID": str(number)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        with sleeper:
            assert sleeper.stdout.readline() == "ready\n"
            is_known = lambda: "sleeper" in link.node.get_node_names()  # noqa: E731
            assert link.spin_until(is_known, 30.0)
            sleeper.send_signal(signal.SIGSTOP)
            assert link.spin_until(lambda: not is_known(), 60.0)
            sleeper.send_signal(signal.SIGCONT)
            assert "this program was suspended for" in sleeper.communicate()[1]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("ROS_STATIC_PEERS", "10.0.0.2;10.0.0.3"),
        ("HITAB_INTERFACE", "eth0"),
        ("ROS_DISCOVERY_SERVER", ";10.0.0.2:11811"),
    ],
)
@pytest.mark.parametrize("before", [{}, {RANGE: "LOCALHOST"}, {RANGE: "SYSTEM_DEFAULT"}])
def test_who_names_other_machines_or_an_interface_reaches_the_network(name, value, before):
    environment = {**before, **dict.fromkeys(VARIABLES, str(LOOPBACK)), name: value}
    assert not is_of_this_machine(environment)
    choose_profile(environment)
    assert environment[RANGE] == "SUBNET"
    assert {environment[variable] for variable in VARIABLES} == {str(NETWORK)}


def test_a_discovery_server_on_this_machine_needs_no_network():
    assert is_of_this_machine({"ROS_DISCOVERY_SERVER": "127.0.0.1:11811"})
