"""The views for RViz and Foxglove show topics that are there, as they are published."""

import json
import re
from typing import Any

import yaml
from mentions import ROOT
from visualization_msgs.msg import Marker, MarkerArray

from hitab_ros import qos

VIEWERS = ROOT / "ros2_ws/src/hitab_studio/viewers"
RVIZ = yaml.safe_load((VIEWERS / "field.rviz").read_text())["Visualization Manager"]
FOXGLOVE = json.loads((VIEWERS / "keepaway.foxglove.json").read_text())
SECONDS = 60.0
FIELDS = {
    "3D": lambda config: config["topics"],
    "StateTransitions": lambda config: [path["value"] for path in config["paths"]],
    "RawMessages": lambda config: [config["topicPath"]],
    "DiagnosticSummary": lambda config: [config["topicToRender"]],
    "RosOut": lambda config: [config["topicToRender"]],
}
"""Where the configuration of each kind of panel names topics."""


def displays() -> list[dict[str, Any]]:
    return [display for display in RVIZ["Displays"] if "Topic" in display]


def shown_by_foxglove() -> set[str]:
    """Return the topics, each with the path of the field that is shown, if only one is."""
    return {
        topic
        for panel, config in FOXGLOVE["configById"].items()
        for topic in FIELDS[panel.partition("!")[0]](config)
    }


def test_the_views_match_the_topics_of_a_running_swarm(swarm, url):
    (display,) = displays()
    assert display["Class"] == "rviz_default_plugins/MarkerArray"
    topic = display["Topic"]["Value"]
    arrays: list[MarkerArray] = []
    swarm.link.subscribe(MarkerArray, topic, arrays.append, qos.LATCHED)
    # The world is paused, and nothing changes meanwhile.
    assert swarm.link.spin_until(lambda: len(arrays) >= 2, SECONDS)
    there = [marker for marker in arrays[-1].markers if marker.action == Marker.ADD]
    assert {marker.header.frame_id for marker in there} == {RVIZ["Global Options"]["Fixed Frame"]}
    assert {marker.ns for marker in there} == set(display["Namespaces"])
    assert all(marker.lifetime.sec > 0 for marker in there)
    (publisher,) = swarm.link.node.get_publishers_info_by_topic(topic)
    offered, asked = publisher.qos_profile, display["Topic"]
    assert offered.reliability.name == asked["Reliability Policy"].upper().replace(" ", "_")
    assert offered.durability.name == asked["Durability Policy"].upper().replace(" ", "_")

    (panel,) = [c for name, c in FOXGLOVE["configById"].items() if name.startswith("3D!")]
    assert panel["followTf"] == RVIZ["Global Options"]["Fixed Frame"]
    assert panel["topics"][topic]["namespaces"].keys() == display["Namespaces"].keys()
    types = dict(swarm.link.node.get_topic_names_and_types())
    for path in shown_by_foxglove():
        name, _, field = path.partition(".")
        assert name in types, name
        if field:
            (kind,) = types[name]
            package, _, message = kind.split("/")
            module = __import__(f"{package}.msg", fromlist=[message])
            fields = getattr(module, message).get_fields_and_field_types()
            assert re.sub(r"\[\d+\]$", "", field) in fields
