"""A program leaves the ROS graph while others come and go."""

import os
import subprocess
import sys
from collections.abc import Iterator

import pytest
from std_msgs.msg import String

from hitab_client import domain_ids
from hitab_client.connecting.ros_link import RosLink

LEAVING = """
import sys
from hitab_client import RosLink
for _ in range(int(sys.argv[1])):
    with RosLink() as link:
        link.spin_until(lambda: False, 0.15)
"""
COMING_AND_GOING = """
from std_msgs.msg import String
from hitab_client import RosLink
with RosLink() as link:
    while True:
        made = [link.node.create_publisher(String, f"t{i}", 1) for i in range(5)]
        link.spin(0.002)
        for publisher in made:
            link.node.destroy_publisher(publisher)
"""


@pytest.fixture
def domain(home: object, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield number


def sockets() -> list[str]:
    links = (f"/proc/self/fd/{name}" for name in os.listdir("/proc/self/fd"))
    found = (os.readlink(link) for link in links if os.path.lexists(link))
    return sorted(name for name in found if name.startswith("socket:"))


def test_others_hear_at_once_that_a_program_has_left(domain):
    with RosLink(domain) as other:
        before = sockets()
        link = RosLink(domain)
        link.node.create_publisher(String, "talk", 1)
        assert other.spin_until(lambda: other.node.count_publishers("talk"), 60.0)
        link.close()
        # Before the lease of a participant that said nothing would end.
        assert other.spin_until(lambda: not other.node.count_publishers("talk"), 10.0)
        assert sockets() == before
        beside = RosLink(domain)
        beside.node.create_publisher(String, "talk", 1)
        assert other.spin_until(lambda: other.node.count_publishers("talk"), 60.0), (
            "it still hears"
        )
        beside.close()


@pytest.mark.long
def test_programs_leave_hundreds_of_times_amid_discovery(domain):
    def started(*command: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, "-c", *command])

    others = [started(COMING_AND_GOING) for _ in range(4)]
    try:
        for program in [started(LEAVING, "300") for _ in range(3)]:
            assert program.wait(600.0) == 0
    finally:
        for other in others:
            other.kill()
            other.wait()
