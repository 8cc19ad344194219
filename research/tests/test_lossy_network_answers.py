"""The experiment on networks that lose plays, and what it shows of real time holds."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from lossy_network import why_not
from lossy_network_answers import measure

pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())


def test_few_answers_are_late_though_a_twentieth_of_all_frames_is_lost():
    one = measure(15, 5.0, 10.0, 0.02, 0.05, 35)
    assert 0.02 < one.lost < 0.08
    # Sent once, a tenth of the percepts or of the answers from other machines would be lost.
    assert one.late < 0.035


@pytest.mark.parametrize(
    ("variables", "multicast"),
    [
        ({"HITAB_INTERFACE": "eth0"}, True),
        ({"ROS_STATIC_PEERS": "10.77.0.1;10.77.0.2;10.77.0.3"}, False),
        ({"ROS_DISCOVERY_SERVER": "10.77.0.1:11811"}, False),
    ],
    ids=["interface", "peers", "server"],
)
def test_machines_find_each_other_by_what_the_user_names(variables, multicast):
    one = measure(15, 5.0, 3.0, 0.001, 0.0, 35, variables=variables, multicast=multicast)
    assert one.late < 0.3, "two thirds are late if the other machines are not found"
