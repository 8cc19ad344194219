"""Wrong names and parameters of a node are reported in one line, without a traceback."""

import os
import subprocess
import sys

import pytest

from hitab_ros.ros_domains import reserved_domain


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (
            ["__ns:=/a", "-p", "seed:=soon"],
            '"seed" is the text "soon"; it must be such as 0',
        ),
        (["__ns:=/a", "-p", "domain:=nothing"], "nothing"),
    ],
)
def test_an_agent_with_a_wrong_parameter_ends_with_one_line(arguments, why):
    with reserved_domain() as number:
        ended = subprocess.run(
            [sys.executable, "-m", "hitab_agent.agent_main", "--ros-args", "-r", *arguments],
            env={
                **os.environ,
                "ROS_DOMAIN_ID": str(number),
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            },
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    assert ended.returncode == 1, ended.stderr
    assert "Traceback" not in ended.stderr
    assert why in ended.stderr.splitlines()[-1]
