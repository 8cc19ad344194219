"""HiTAB's DDS profiles."""

import os
import subprocess
import sys

from hitab_client.dds_profile import VARIABLES


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
