"""`hitab doctor --network` on machines whose network delays, loses, or passes nothing."""

import json
import sys
import time

import pytest
from lossy_network import LossyNetwork, why_not

pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())

HOSTS = (1, 2, 3)
LISTENING_S = 20


def _doctors(folder, *, cut_off=0, loss=0.0, **environment):
    """Run the doctor on all hosts; return what each says of the network."""
    files = {host: folder / f"{host}.json" for host in HOSTS}
    with LossyNetwork(len(HOSTS), 0.02, loss) as network:
        if cut_off:
            network.cut_off(cut_off)
        for host, file in files.items():
            line = [sys.executable, "-m", "hitab_cli.main", "doctor"]
            line += ["--network", str(LISTENING_S), "--json", str(file)]
            variables = {
                "ROS_DOMAIN_ID": "38",
                "HITAB_HOME": str(folder / f"home_{host}"),
                "FASTRTPS_DEFAULT_PROFILES_FILE": "",
                "FASTDDS_DEFAULT_PROFILES_FILE": "",
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
                **environment,
            }
            network.run(host, line, folder / f"{host}.log", **variables)
        deadline = time.monotonic() + 120.0
        while not all(
            file.exists() and file.read_text().endswith("]\n") for file in files.values()
        ):
            assert time.monotonic() < deadline, (folder / "1.log").read_text()
            time.sleep(0.1)
    return {
        host: [f for f in json.loads(file.read_text()) if f["about"] == "network"]
        for host, file in files.items()
    }


def test_each_machine_says_whom_it_hears_and_who_is_cut_off_why_it_may_hear_none(tmp_path):
    found = _doctors(tmp_path, cut_off=3, loss=0.3)
    for host, other in ((1, 2), (2, 1)):
        own, heard = found[host]
        assert f"(10.77.0.{host}); it sends on eth0" in own["text"]
        assert f"(10.77.0.{other}): " in heard["text"]
        assert " ms one way, clock " in heard["text"]
        assert heard["level"] == "warning", "a third of its messages is lost"
    assert found[3][-1]["text"].startswith("no other computer was heard")
    assert "UDP ports 16900 to 17149" in found[3][-1]["way_out"]


def test_a_swarm_that_stays_on_its_machine_is_told_how_to_leave_it(tmp_path):
    found = _doctors(tmp_path, ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST")
    for own, nobody in found.values():
        assert own["text"].endswith("it sends on lo only")
        assert nobody["way_out"].startswith("export ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET")
