"""Swarms on several machines: who runs where, and what a faulty line says."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from hitab_bringup import Leases, described_files, description_digest, parse_swarm, read_swarm
from hitab_bringup.processes import swarm_processes
from hitab_bringup.processes.leases import as_leased
from hitab_bringup.processes.swarm_processes import all_processes, process_names, processes
from hitab_bringup.swarm_files.described_files import keep_description
from hitab_client import DescriptionError, SwarmError

HERE = Path("/somewhere/field.yaml")
SWARM = """\
swarm: field
domain: foraging
world: {kind: foraging}
agents:
  ant: {count: 12}
  scout: {count: 2}
kinds: {Squad: {orders: {Go: Stop}}, Army: {orders: {Go: Go}}}
commanders:
  squad: {kind: Squad, commands: {ant: 4}}
  chief: {kind: Army, commands: squad}
machines:
"""
THREE = """\
  lab_1: {runs: [world, chief]}
  lab_2: {runs: [squad_1, ant_7], ssh: ann@lab2.local, hitab: ~/hitab/scripts/hitab}
  lab_3: {runs: [squad_2], ssh: lab3, hosts: 2, when_out_of_reach: halt, takes_over: [lab_2]}
"""


def hosts(text: str) -> dict[str, str]:
    return {member.name: member.process for member in parse_swarm(text, HERE).members}


def test_the_nearest_name_says_where_a_member_runs():
    host_of = hosts(SWARM + THREE)
    assert {name: host_of[f"ant_{name}"] for name in range(1, 13)} == {
        **dict.fromkeys((1, 2, 3, 4, 7), "lab_2_host_1"),
        **dict.fromkeys((5, 6), "lab_3_host_1"),
        8: "lab_3_host_2",
        **dict.fromkeys(range(9, 13), "lab_1_host_1"),
    }
    assert host_of["squad_1"] == "lab_2_host_1"
    assert host_of["squad_2"] == "lab_3_host_1"
    # What nobody names is on the first machine; chief commands squad_3, and is named itself.
    for name in ("scout_1", "scout_2", "squad_3", "chief"):
        assert host_of[name] == "lab_1_host_1"


def test_a_line_is_nearer_than_a_commander_and_farther_than_a_member():
    host_of = hosts(SWARM + "  a: {runs: [ant_1]}\n  b: {runs: [ant]}\n  c: {runs: squad}\n")
    assert host_of["ant_1"] == "a_host_1"
    assert host_of["ant_2"] == "b_host_1"
    assert host_of["squad_1"] == "c_host_1"


def test_processes_of_a_machine_do_not_depend_on_the_others():
    more = THREE.replace("squad_1, ant_7", "squad_1, squad_3")
    before, after = hosts(SWARM + THREE), hosts(SWARM + more)
    assert (before["ant_1"], before["ant_5"]) == (after["ant_1"], after["ant_5"])
    assert {process for process in after.values() if process.startswith("lab_3")} == {
        "lab_3_host_1",
        "lab_3_host_2",
    }


def test_the_line_of_a_machine_says_what_its_members_do_out_of_reach():
    swarm = parse_swarm(SWARM + THREE, HERE)
    halting = {m.name for m in swarm.members if m.parameters.get("when_out_of_reach") == "halt"}
    assert halting == {"ant_5", "ant_6", "ant_8", "squad_2"}


ROBOT = """
from dataclasses import replace
from hitab_core import load_domain
DOMAIN = replace(load_domain("keepaway"), name="rover", link="hitab_robots:RobotLink")
"""


def test_robots_keep_processes_of_their_own_beside_what_they_need(tmp_path, monkeypatch):
    (tmp_path / "rover_words.py").write_text(ROBOT)
    monkeypatch.syspath_prepend(str(tmp_path))
    relay = SimpleNamespace(name="hitab_robots", value="hitab_robots.relay.velocity_relay")
    monkeypatch.setattr(swarm_processes, "entry_points", lambda group: [relay])
    text = """\
domain: rover_words:DOMAIN
agents: {robot: {count: 3}}
processes: {lidar: {command: cat, namespace: robot_2}}
machines: {desk: {runs: robot_1}, field: {runs: robot}}
"""
    swarm = parse_swarm(text, HERE)
    assert [agent.process for agent in swarm.agents] == ["robot_1", "robot_2", "robot_3"]
    on_field = processes(swarm.on_machine("field"), HERE.parent)
    assert [process.name for process in on_field] == [
        *("robot_2", "robot_3", "lidar"),
        *("robot_2_velocity_relay", "robot_3_velocity_relay", "field"),
    ]
    assert {process.module for process in on_field if process.agents} == {"hitab_agent.host_main"}


def test_a_machine_starts_its_own_processes_with_leases_and_its_node(tmp_path):
    swarm = parse_swarm(SWARM + THREE, HERE)
    Leases(tmp_path).take("lab_3_host_2", 4)
    found = {p.name: p for p in processes(swarm.on_machine("lab_3"), tmp_path, "field-1")}
    assert [*found] == ["lab_3_host_1", "lab_3_host_2", "lab_3"]
    assert found["lab_3_host_1"].parameters["lease"] == 1
    assert found["lab_3_host_2"].parameters["lease"] == 4
    node = found.pop("lab_3")
    assert {p.parameters["machine"] for p in found.values()} == {"lab_3"}
    assert (node.module, node.namespace) == ("hitab_machines.machine_main", "/lab_3")
    first, *_ = processes(swarm.on_machine("lab_1"), tmp_path)
    assert first.parameters["machines"] == ("lab_1", "lab_2", "lab_3")
    assert first.parameters["hosts"] == 4


def test_a_world_waits_for_no_host_of_robots_which_have_no_place_in_it(tmp_path, monkeypatch):
    (tmp_path / "rover_words.py").write_text(ROBOT)
    monkeypatch.syspath_prepend(str(tmp_path))
    robots = SWARM.replace("scout: {count: 2}", 'rover: {count: 2, domain: "rover_words:DOMAIN"}')
    swarm = parse_swarm(robots + "  lab_1: {runs: world}\n  lab_2: {runs: [ant, rover]}\n", HERE)
    world, *_ = processes(swarm.on_machine("lab_1"), HERE.parent)
    assert world.parameters["hosts"] == 1


def test_all_machines_know_all_processes_and_the_same_identity(tmp_path):
    swarm = parse_swarm(SWARM + THREE, HERE)
    parts = [swarm.on_machine(name) for name in ("lab_1", "lab_2", "lab_3")]
    named = [process_names(part, all_processes(part, tmp_path)) for part in parts]
    assert named[0] == named[1] == named[2]
    assert named[0]["lab_1"] == ("world", "lab_1_host_1")
    assert len({part.identity() for part in parts}) == 1
    left = swarm.in_namespace("left").on_machine("lab_1").identity()
    assert left != parts[0].identity()
    assert left.startswith("field_left-")


def test_without_a_chosen_machine_all_runs_here_and_as_without_machines(tmp_path):
    swarm = parse_swarm(SWARM + THREE, HERE)
    found = processes(swarm, tmp_path, "field-1")
    assert {name for p in found for name in p.agents} == {*swarm.agent_names}
    assert not any("machine" in p.parameters or "machines" in p.parameters for p in found)


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("  a: {runs: [squad_9]}\n", '12: `runs:` there is no agent, commander or process "squad'),
        ("  a: {runs: ant}\n  b: {runs: ant}\n", '13: `runs:` "ant" also runs on "a"; remove it'),
        ("  a: {}\n  b: {runs: []}\n", "13: runs nothing: name a line, a member or a process"),
        ("  ant_1: {}\n", '12: a second "ant_1" (see `ant`); rename one'),
        ("  world: {}\n", "12: `world:` a machine cannot be called this; rename it"),
        ("  a: {takes_over: b}\n", '12: `takes_over:` there is no other machine "b"'),
        (
            "  a: {takes_over: b}\n  b: {runs: squad_2, takes_over: a}\n",
            "12: `takes_over:` of two machines that take over from each other, each would after a",
        ),
        ("  a: {takes_over: a}\n", '12: `takes_over:` there is no other machine "a"'),
        ("  a: {ssh: -oProxyCommand=x}\n", '12: `ssh:` "-oProxyCommand=x" is not a destination'),
        ("  a: {hitab: hitab; rm x}\n", '12: `hitab:` "hitab; rm x" is not the path of a command'),
        ("  a: {hosts: 0}\n", "12: `hosts:` must be at least 1"),
    ],
)
def test_a_faulty_machine_is_refused_with_its_line(lines, expected):
    with pytest.raises(DescriptionError) as error:
        parse_swarm(SWARM + lines, HERE)
    assert f"/somewhere/field.yaml:{expected}" in str(error.value)


def test_a_process_over_two_machines_and_a_library_on_one_are_refused(tmp_path):
    text = SWARM.replace("{count: 12}", "{count: 12, per_process: 6}")
    with pytest.raises(DescriptionError, match=r'"ant_host_1" would run .* on "a" and .* on "b"'):
        parse_swarm(text + "  a: {runs: squad_1}\n  b: {runs: squad_2}\n", HERE)
    text = f"library: {tmp_path}\n" + SWARM + "  a: {}\n"
    with pytest.raises(DescriptionError, match=r"field.yaml:1: `library:` each machine keeps"):
        parse_swarm(text, HERE)
    text = f"start_from: {tmp_path}\n" + SWARM + "  a: {}\n"
    with pytest.raises(DescriptionError, match="is on this machine only; write a path relative"):
        parse_swarm(text, HERE)


def test_a_machine_is_chosen_by_name_and_a_swarm_without_any_has_none():
    swarm = parse_swarm(SWARM + THREE, HERE)
    with pytest.raises(DescriptionError, match="runs on lab_1, lab_2, lab_3; say which of these"):
        swarm.on_machine("")
    with pytest.raises(DescriptionError, match=r'no machine "lab_4" .*Did you mean "lab_'):
        swarm.on_machine("lab_4")
    alone = parse_swarm(SWARM.replace("machines:\n", ""), HERE)
    assert alone.on_machine("") == alone
    with pytest.raises(DescriptionError, match=r"has no `machines:`; leave out the machine"):
        alone.on_machine("lab_1")


def test_a_machine_runs_again_what_it_had_taken_and_nothing_that_it_had_yielded(tmp_path):
    swarm = parse_swarm(SWARM + THREE, HERE).on_machine("lab_3")
    Leases(tmp_path).take("lab_2_host_1", 2)
    Leases(tmp_path).give_up("lab_3_host_1", 2)
    leased = {machine.name: machine.processes for machine in as_leased(swarm, tmp_path).machines}
    before = {machine.name: machine.processes for machine in swarm.machines}
    assert leased["lab_3"] == ("lab_3_host_2", "lab_2_host_1")
    assert "lab_2_host_1" not in leased["lab_2"]
    assert leased["lab_1"] == before["lab_1"]


def test_leases_are_kept_and_a_broken_file_is_refused_with_the_way_out(tmp_path):
    assert Leases(tmp_path).of("host_1") == 1
    Leases(tmp_path).take("host_1", 2)
    Leases(tmp_path).give_up("host_2", 7)
    kept = Leases(tmp_path)
    assert [(kept.of(name), kept.is_yielded(name)) for name in ("host_1", "host_2", "host_3")] == [
        (2, False),
        (7, True),
        (1, False),
    ]
    for text in ("[1]", "{", json.dumps({"host_1": 0}), json.dumps({"host_1": "2"})):
        (tmp_path / "leases.json").write_text(text)
        with pytest.raises(SwarmError, match=r"leases\.json cannot be read .*; remove it"):
            Leases(tmp_path).of("host_1")


def described(folder: Path, library: str, kind: str) -> Path:
    (folder / "swarms").mkdir(parents=True)
    text = SWARM.replace("Squad: {orders: {Go: Stop}}", f"Squad: {kind}")
    file = folder / "swarms" / "field.yaml"
    file.write_text(f"start_from: {library}\n{text}{THREE}")
    return file


def test_the_files_that_a_swarm_file_names_keep_their_places(tmp_path):
    file = described(tmp_path, "../mine", "kinds/squad.yaml")
    for inner, text in (
        ("mine/Go.hfa.yaml", "x"),
        ("mine/.lock", ""),
        ("swarms/kinds/squad.yaml", "commander: Squad\norders: {Go: Stop}\n"),
    ):
        (tmp_path / inner).parent.mkdir(exist_ok=True)
        (tmp_path / inner).write_text(text)
    swarm = read_swarm(file)
    assert described_files(swarm) == {
        "swarms/field.yaml": file,
        "swarms/kinds/squad.yaml": file.parent / "kinds/squad.yaml",
        "mine/Go.hfa.yaml": file.parent / "../mine/Go.hfa.yaml",
    }
    before = description_digest(swarm)
    (tmp_path / "mine/Go.hfa.yaml").write_text("learned")
    assert description_digest(swarm) == before
    copy = tmp_path / "elsewhere"
    for path, source in described_files(swarm).items():
        (copy / path).parent.mkdir(parents=True, exist_ok=True)
        (copy / path).write_bytes(source.read_bytes())
    assert description_digest(read_swarm(copy / "swarms/field.yaml")) == before
    (copy / "swarms/kinds/squad.yaml").write_text("commander: Squad\norders: {Halt: Stop}\n")
    assert description_digest(read_swarm(copy / "swarms/field.yaml")) != before


def test_a_swarm_keeps_what_it_was_started_with(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "Go.hfa.yaml").write_text("x")
    swarm = read_swarm(described(tmp_path, "../mine", "{orders: {Go: Stop}}"))
    before = description_digest(swarm)
    kept = keep_description(swarm, tmp_path / "run")
    swarm.file.write_text("nonsense: [")
    assert kept.is_relative_to(tmp_path / "run")
    assert description_digest(read_swarm(kept)) == before
    assert "mine/Go.hfa.yaml" in described_files(read_swarm(kept))
    assert keep_description(read_swarm(kept), tmp_path / "run") == kept

    (tmp_path / "hall.py").write_text(Path("examples/corridor.py").read_text())
    hall = tmp_path / "hall.yaml"
    hall.write_text("world: {kind: hall.py}\nagents: {agent: {count: 2}}\nmachines: {a: {}}\n")
    before = description_digest(read_swarm(hall))
    assert description_digest(read_swarm(keep_description(read_swarm(hall), tmp_path))) == before


def test_shipped_libraries_are_not_sent_and_python_never(tmp_path):
    field = described(tmp_path, "foraging", "{orders: {Go: Stop}}")
    assert [*described_files(read_swarm(field))] == ["field.yaml"]
    (tmp_path / "hall.py").write_text(Path("examples/corridor.py").read_text())
    hall = tmp_path / "hall.yaml"
    hall.write_text("world: {kind: hall.py}\nagents: {agent: {count: 2}}\nmachines: {a: {}}\n")
    with pytest.raises(DescriptionError, match=r"hall\.py is a Python file, which is not sent"):
        described_files(read_swarm(hall))
    before = description_digest(read_swarm(hall))
    with (tmp_path / "hall.py").open("a") as file:
        file.write("# changed\n")
    assert description_digest(read_swarm(hall)) != before
