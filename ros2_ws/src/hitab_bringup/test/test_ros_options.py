"""ROS settings in swarm descriptions: namespaces, remappings, parameters, processes."""

import json
from pathlib import Path

import pytest

from hitab_bringup.processes import swarm_processes
from hitab_bringup.processes.swarm_processes import processes
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.errors import DescriptionError

HERE = Path("/somewhere/team.yaml")
AGENTS = "domain: keepaway\nagents: {a: {}, b: {}}\n"


def complaint(text: str) -> str:
    with pytest.raises(DescriptionError) as error:
        parse_swarm(text, HERE)
    return str(error.value)


def found(text: str):
    """Return the processes of a swarm, by name."""
    return {process.name: process for process in processes(parse_swarm(text, HERE), Path("/run"))}


def rules(process) -> list[str]:
    """Return the remappings on a process's command line."""
    line = process.command
    return [line[i + 1] for i, word in enumerate(line) if word == "-r"]


def test_a_namespace_is_around_all_nodes_and_gives_the_swarm_its_own_clock():
    there = found(
        f"namespace: left\nworld: {{kind: keepaway}}\n{AGENTS}"
        "processes: {relay: {module: json.tool}}\n"
    )
    assert {name: rules(process) for name, process in there.items()} == {
        "world": ["__ns:=/left/world", "/clock:=/left/clock"],
        "a": ["__ns:=/left/a", "/clock:=/left/clock"],
        "b": ["__ns:=/left/b", "/clock:=/left/clock"],
        "relay": ["__ns:=/left", "/clock:=/left/clock"],
    }


def test_agents_that_share_a_process_have_the_swarms_namespace_around_theirs(tmp_path):
    swarm = parse_swarm(
        "namespace: left\ndomain: keepaway\nhosts: 1\nremap: {tf: /tf}\nagents:\n"
        "  a: {remap: {cmd: '/base/{agent}/cmd'}, parameters: {rate: 5.0}}\n  b: {}\n",
        HERE,
    )
    (host,) = processes(swarm, tmp_path)
    assert host.namespace == "/left"
    swarm_processes.write_rosters(swarm, tmp_path)
    text = (tmp_path / "rosters" / "host_1.json").read_text()
    first, second = json.loads(text)
    assert first["remap"] == {"/clock": "/left/clock", "tf": "/tf", "cmd": "/base/a/cmd"}
    assert first["parameters"]["rate"] == 5.0
    assert second["remap"] == {"/clock": "/left/clock", "tf": "/tf"}


def test_what_is_nearer_counts_and_the_rest_is_kept():
    there = found(
        "domain: keepaway\nuse_sim_time: true\nremap: {/clock: /time, tf: /tf}\n"
        "parameters: {rate: 10, scan.yaw: 1.5, scan.names: [a, b]}\n"
        "world: {kind: keepaway, node_parameters: {state_rate: 5.0}}\n"
        "agents:\n  b: {}\n"
        "  a: {remap: {tf: /a/tf}, parameters: {rate: 20}, use_sim_time: false}\n"
    )
    a, b, world = there["a"], there["b"], there["world"]
    assert rules(a)[1:] == ["/clock:=/time", "tf:=/a/tf"]
    assert rules(b)[1:] == rules(world)[1:] == ["/clock:=/time", "tf:=/tf"]
    assert (a.parameters["rate"], b.parameters["rate"]) == (20, 10)
    assert b.parameters["scan.yaw"] == 1.5
    assert 'scan.names:=["a", "b"]' in b.command
    assert (a.parameters["use_sim_time"], b.parameters["use_sim_time"]) == (False, True)
    assert "use_sim_time" not in world.parameters  # it would wait for its own clock
    assert world.parameters["state_rate"] == 5.0
    assert "rate" not in world.parameters


def test_a_process_runs_in_a_namespace_of_the_swarm_or_is_no_node_of_ros():
    there = found(
        "domain: keepaway\nnamespace: left\nuse_sim_time: true\n"
        "agents:\n  robot: {count: 2}\n"
        "processes:\n"
        "  relay: {module: json.tool, namespace: robot_2, parameters: {base: 2}, "
        "remap: {cmd_vel: /robot_2/base}}\n"
        "  driver: {command: sh -c 'exec true' x, namespace: robot_1}\n"
        "  field: {command: sh -c exit}\n"
        "  lidar: {command: sh, namespace: /front}\n"
    )
    assert list(there) == ["robot_1", "robot_2", "relay", "driver", "field", "lidar"]
    relay = there["relay"]
    assert rules(relay) == [
        "__ns:=/left/robot_2", "/clock:=/left/clock", "cmd_vel:=/robot_2/base",
    ]  # fmt: skip
    assert relay.parameters == {"base": 2, "use_sim_time": True}
    assert relay.command[1:3] == ["-m", "json.tool"]
    driver = there["driver"].command
    assert driver[:5] == ["sh", "-c", "exec true", "x", "--ros-args"]
    assert "__ns:=/left/robot_1" in driver
    assert there["field"].command == ["sh", "-c", "exit"]  # no node of ROS
    assert "__ns:=/front" in there["lidar"].command


def test_the_companion_of_a_link_runs_beside_each_agent_that_has_the_link(monkeypatch):
    class Point:
        name, value = "my_robot", "my_robot.relay"

    monkeypatch.setattr(swarm_processes, "entry_points", lambda group: [Point])

    class Linked:
        link = "my_robot.links:Link"

    monkeypatch.setattr(swarm_processes, "load_domain", lambda name: Linked)
    text = (
        "namespace: left\ndomain: keepaway\nagents:\n"
        "  a: {remap: {cmd_vel: /base}, parameters: {speed: 1.5}}\n  b: {}\n"
    )
    there = found(text)
    assert list(there) == ["a", "b", "a_relay", "b_relay"]
    assert rules(there["a_relay"]) == [
        "__ns:=/left/a", "/clock:=/left/clock", "cmd_vel:=/base",
    ]  # fmt: skip
    assert there["a_relay"].parameters == {
        "speed": 1.5, "domain": "keepaway", "state_dir": "/run/state",
    }  # fmt: skip
    # A relay in the description replaces the default one.
    monkeypatch.setattr(Point, "value", "json.tool")
    own = "processes: {own: {module: json.tool, namespace: a, parameters: {speed: 9.0}}}\n"
    assert list(found(text + own)) == ["a", "b", "own", "b_tool"]


def test_what_is_not_finite_reaches_a_node_as_a_number():
    a = found("domain: keepaway\nagents: {a: {parameters: {far: .inf, mixed: [1, 2.5]}}}\n")["a"]
    assert "far:=.inf" in a.command
    assert "mixed:=[1.0, 2.5]" in a.command


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"namespace: a-b\n{AGENTS}", '1: `namespace:` "a-b" is not a name in ROS, such as'),
        (f"remap: {{__ns: /x}}\n{AGENTS}", "1: `__ns:` cannot be remapped, since the swarm "),
        (f"parameters: {{seed: 1}}\n{AGENTS}", "1: `seed:` has a line of its own; move it out"),
        (f"parameters: {{x: [1, a]}}\n{AGENTS}", "1: `x:` must be a number, a text, true"),
        (f"parameters: {{x: {{y: 1}}}}\n{AGENTS}", "1: `x:` has values inside; write each with"),
        (
            f"world: {{kind: keepaway, use_sim_time: true}}\n{AGENTS}",
            "1: `use_sim_time:` is not known here",
        ),
        (
            f"{AGENTS}processes: {{x: {{}}}}\n",
            "3: `x:` needs either `module:`, run with Python, or ",
        ),
        (
            f"{AGENTS}processes: {{x: {{command: no_such_program}}}}\n",
            '3: `command:` there is no program "no_such_program" on the PATH; install it',
        ),
        (
            f"{AGENTS}processes: {{x: {{module: json, remap: {{y: '{{agent}}'}}}}}}\n",
            '3: "{agent}" stands for an agent: have it in the lines of `agents:` alone',
        ),
        (
            f"{AGENTS}processes: {{a: {{module: json}}}}\n",
            '3: a second "a" (see `a`); rename one',
        ),
    ],
)
def test_a_fault_is_told_with_its_line_and_the_way_out(text, expected):
    error = complaint(text)
    assert error.startswith("/somewhere/team.yaml:")
    assert expected in error


def test_a_swarm_can_be_put_into_a_namespace_under_a_name_of_its_own():
    swarm = parse_swarm(AGENTS, HERE).in_namespace("lab/left/")
    assert (swarm.name, swarm.namespace) == ("team_lab_left", "/lab/left")
    assert swarm.full_name("a") == "/lab/left/a"
    with pytest.raises(DescriptionError, match=r'"a-b" is not a namespace; use up to 100 letters'):
        swarm.in_namespace("a-b")
