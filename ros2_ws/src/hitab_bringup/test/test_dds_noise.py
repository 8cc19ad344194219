"""Messages of Fast DDS that only frighten do not reach the user; everything else does."""

import os
import subprocess
import sys

import pytest

from hitab_client.dds_profile import LOOPBACK, VARIABLES, is_users_own

NOISE = (
    "2026-11-22 05:34:15.047 [RTPS_TRANSPORT_SHM Error] Failed init_port fastrtps_port7411: "
    "open_and_lock_file failed -> Function open_port_internal"
)
SCRIPT = f"""
import os, subprocess, sys
from hitab_bringup.dds_noise import noise_left_out
with noise_left_out():
    os.write(2, b"{NOISE}\\nfrom a library\\n")
    print("from Python", file=sys.stderr)
    subprocess.run(["sh", "-c", "echo from a child >&2"])
    os.write(2, b"not ended")
print("afterwards", file=sys.stderr)
sys.exit(3)
"""


@pytest.mark.parametrize("own", [True, False])
def test_with_a_profile_of_the_users_own_the_noise_is_left_out(own, tmp_path):
    profile = tmp_path / "own.xml" if own else LOOPBACK
    environment = {name: str(profile) for name in VARIABLES}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 3
    assert (NOISE not in done.stderr) == own
    for line in ("from a library\n", "from Python\n", "from a child\n", "not ended"):
        assert line in done.stderr
    assert done.stderr.endswith("afterwards\n")


def test_what_stands_for_a_users_own_profile():
    assert not is_users_own({})
    assert not is_users_own({VARIABLES[0]: "/anywhere/dds_loopback.xml"})
    assert is_users_own({VARIABLES[1]: "/mine/profile.xml"})


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
