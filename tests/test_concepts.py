"""Who looks for a concept finds a file of its name."""

import pytest
from mentions import ROOT

PACKAGES = ROOT / "ros2_ws/src"

FILES = {
    "caution": "hitab_core/hitab_core/assistant/caution.py",
    "default example": "hitab_core/hitab_core/default_example.py",
    "distribution": "hitab_agent/hitab_agent/topics/distribution.py",
    "emergency stop": "hitab_ros/hitab_ros/stopping/emergency_stop.py",
    "keys": "hitab_studio/hitab_studio/static/keys.js",
    "lockstep": "hitab_world/hitab_world/simulating/lockstep.py",
    "order": "hitab_core/hitab_core/orders/order.py",
    "lateness": "hitab_core/hitab_core/assistant/lateness.py",
    "recording": "hitab_client/hitab_client/recording/recordings.py",
    "retiming": "hitab_core/hitab_core/training/retiming.py",
    "saving": "hitab_core/hitab_core/library/saving.py",
    "swarm file": "hitab_bringup/hitab_bringup/swarm_files/swarm_file.py",
    "undo": "hitab_core/hitab_core/training/undo.py",
}


@pytest.mark.parametrize("concept", FILES)
def test_a_concept_has_a_file_of_its_name_that_says_what_it_is(concept):
    file = PACKAGES / FILES[concept]
    assert concept.replace(" ", "_") in file.name
    first = file.read_text(encoding="utf-8").strip().split("\n\n")[0]
    assert concept in first.lower(), f"{file} begins without the word"
