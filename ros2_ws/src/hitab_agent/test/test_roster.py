"""A roster tells whom a host runs; one that cannot be used is refused with the way out."""

import json

import pytest
import rclpy
from rclpy.parameter import Parameter

from hitab_agent.host.roster import read_roster
from hitab_core.texts.errors import HitabError


def read(process, folder, roster):
    file = folder / "roster.json"
    file.write_text(json.dumps(roster))
    host = rclpy.create_node(
        "host",
        context=process.node.context,
        parameter_overrides=[Parameter("roster", value=str(file))],
        use_global_arguments=False,
    )
    process.add(host)
    return read_roster(host)


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ({"parameters": {}}, "name"),
        ({"name": 3}, "3 must be a name"),
        ({"name": "a", "parameters": ["seed"]}, "parameters .*'seed'.* a mapping"),
        ({"name": "a", "node": "os:path"}, '"os:path" is not a subclass'),
        ({"name": "a", "node": "nowhere:Node"}, "nowhere"),
        ({"name": "a", "parametres": {}}, "parametres"),
        ("a", "str"),
    ],
)
def test_a_roster_that_cannot_be_used_is_refused_by_file(process, tmp_path, entry, why):
    with pytest.raises(HitabError, match=rf"roster.json: not a roster of agents: .*{why}"):
        read(process, tmp_path, [entry])
