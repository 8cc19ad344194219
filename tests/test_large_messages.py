"""Large messages arrive over a network that loses frames."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from lossy_network import LossyNetwork, why_not

from hitab_client.connecting.dds_profile import GIVES_BACK, INTERFACE, NETWORK, RANGE, VARIABLES

SERVER = """
import rclpy
from hitab_msgs.msg import MachineFile
from hitab_msgs.srv import ReadFiles
rclpy.init()
node = rclpy.create_node("server")
file = MachineFile(path="p", data=bytes(500))
node.create_service(ReadFiles, "/read", lambda _, given: ReadFiles.Response(files=400 * [file]))
rclpy.spin(node)
"""
CLIENT = """
import rclpy
from hitab_msgs.srv import ReadFiles
rclpy.init()
node = rclpy.create_node("client")
client = node.create_client(ReadFiles, "/read")
assert client.wait_for_service(60.0)
for _ in range(4):
    answer = client.call_async(ReadFiles.Request())
    rclpy.spin_until_future_complete(node, answer, timeout_sec=30.0)
    print("arrived" if answer.done() else "lost", flush=True)
"""


@pytest.mark.skipif(bool(why_not()), reason=why_not())
def test_answers_of_200_kb_arrive_though_a_twentieth_of_all_frames_is_lost(tmp_path: Path) -> None:
    environment = {"ROS_DOMAIN_ID": "7", RANGE: "SUBNET", INTERFACE: ""}
    environment |= dict.fromkeys(VARIABLES, str(NETWORK)) | GIVES_BACK
    with LossyNetwork(2, 0.02, 0.05) as network:
        network.run(1, [sys.executable, "-c", SERVER], tmp_path / "server.log", **environment)
        log = tmp_path / "client.log"
        network.run(2, [sys.executable, "-c", CLIENT], log, **environment).wait(180.0)
    # What is sent while the two are just being connected may be lost.
    assert log.read_text().split()[1:] == 3 * ["arrived"], log.read_text()
