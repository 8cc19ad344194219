"""Swarm descriptions: errors name the file, the line and the way out."""

import time
from pathlib import Path

import pytest

from hitab_bringup.processes.swarm_processes import processes
from hitab_bringup.swarm_files.swarm_file import parse_swarm, read_swarm
from hitab_client.errors import DescriptionError
from hitab_client.runs.shipped import find_file
from hitab_core.texts.errors import HitabError

HERE = Path("/somewhere/team.yaml")


def complaint(text: str, path: Path = HERE) -> str:
    with pytest.raises(DescriptionError) as error:
        parse_swarm(text, path)
    return str(error.value)


def test_what_is_no_swarm_file_is_told_apart(tmp_path, monkeypatch):
    behavior = tmp_path / "Run.hfa.yaml"
    behavior.touch()
    with pytest.raises(DescriptionError, match="this is the file of a behavior, not a swarm file"):
        read_swarm(behavior)
    with pytest.raises(HitabError, match="this is a folder"):
        find_file(str(tmp_path), "swarms", "swarm")
    # A path to a missing file does not fall back to the shipped file of this name.
    with pytest.raises(HitabError, match='Did you mean "keepaway"'):
        find_file("keepaway.yaml", "swarms", "swarm")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "keepaway").mkdir()
    assert find_file("keepaway", "swarms", "swarm").name == "keepaway.yaml"


def test_many_likes_take_one_line_and_few_processes():
    swarm = parse_swarm(
        "domain: keepaway\nagents:\n  ant: {count: 5, per_process: 2}\n  queen: {}\n", HERE
    )
    assert len(swarm.agents) == 6
    found = {process.name: process.agents for process in processes(swarm, Path("/run"))}
    assert found == {
        "ant_host_1": ("ant_1", "ant_2"),
        "ant_host_2": ("ant_3", "ant_4"),
        "ant_host_3": ("ant_5",),
        "queen": ("queen",),
    }


def test_an_agent_twice_is_refused_with_both_places():
    text = "domain: keepaway\nagents:\n  a: {}\n  b: {}\n  a: {}\n"
    assert complaint(text) == (
        '/somewhere/team.yaml:5: has the key "a" twice (first at line 3); remove one'
    )
    text = "domain: keepaway\nagents:\n  ant: {count: 2}\n  ant_2: {}\n"
    assert complaint(text).startswith('/somewhere/team.yaml:4: a second "ant_2" (see `ant`)')


def test_an_unknown_domain_is_told_once_and_with_what_was_meant():
    error = complaint("domain: keepawya\nagents: {a: {}, b: {}}\n")
    assert error.count("\n") == 0
    assert error.startswith('/somewhere/team.yaml:1: no domain "keepawya" is installed (known: ')
    assert 'Did you mean "keepaway"?); install the package' in error


def test_an_unknown_behavior_is_told_where_it_stands(tmp_path):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "Dance.hfa.yaml").touch()
    text = (
        "domain: keepaway\nstart_from: lib\n"
        "agents:\n  a: {behavior: Dance}\n  b: {behavior: Danse}\n"
    )
    error = complaint(text, tmp_path / "team.yaml")
    assert error.startswith(f'{tmp_path}/team.yaml:5: unknown behavior "Danse" (known: Dance, ')
    assert error.endswith('Did you mean "Dance"?)')


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("domain: keepaway\n", "1: a swarm needs `agents:`"),
        ("domain: keepaway\nagents: [a, b]\n", "must be `key: value` lines, not a list"),
        ("domain: keepaway\nagents: {1a: {}}\n", '2: `1a:` "1a" is not a name; use up to'),
        ("domain: keepaway\nagents: {world: {}}\n", "`world:` an agent cannot be called this"),
        ("domain: keepaway\nagent: {a: {}}\n", 'Did you mean "agents"?'),
        ("domain: keepaway\nagents: {a: {count: 0}}\n", "`count:` must be at least 1, not 0"),
        ("domain: keepaway\nworld: {kind: chess}\nagents: {a: {}}\n", 'unknown world "chess"'),
        ("domain: keepaway\nagents: {a: {behavior: 'Go('}}\n", "is not a use of a behavior"),
    ],
)
def test_everything_wrong_is_told_with_its_place(text, expected):
    assert expected in complaint(text)


def test_all_complaints_come_at_once():
    error = complaint("domain: keepaway\nworld: {pace: fast}\nagents:\n  a: {seed: -1}\n")
    assert [line.split(":")[1] for line in error.splitlines()] == ["2", "2", "4"]


def one_file(tmp_path: Path) -> Path:
    text = Path("examples/corridor.py").read_text()
    (tmp_path / "hall.py").write_text(text)
    return tmp_path / "team.yaml"


def test_the_world_of_a_swarm_may_be_one_file_whose_words_its_agents_have(tmp_path):
    text = (
        "world: {kind: hall.py}\n"
        "agents:\n  agent: {count: 2}\n"
        "kinds: {Squad: {}}\ncommanders:\n  captain: {kind: Squad, commands: agent}\n"
    )
    swarm = parse_swarm(text, one_file(tmp_path))
    file = str((tmp_path / "hall.py").resolve())
    assert swarm.world is not None
    assert (swarm.world.kind, swarm.world.module) == ("hall", "hitab_world.simulation_main")
    assert swarm.world.parameters == {"file": file, "agents": 2}
    assert {agent.domain for agent in swarm.agents} == {file}
    assert {order.name for order in swarm.commanders[0].kind.orders} == {"Left", "Right"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("world: {kind: hal.py}\nagents: {agent_1: {}}\n", "there is no such file"),
        ("world: {kind: hall.py}\nagents: {rover: {}}\n", "called agent_1, agent_2 and so on"),
    ],
)
def test_what_does_not_fit_a_world_in_one_file_is_told(tmp_path, text, expected):
    assert expected in complaint(text, one_file(tmp_path))


def test_agents_may_start_from_a_library_by_its_name_as_the_command_line_takes_it():
    text = "domain: foraging\nstart_from: foraging\nagents: {a: {}}\n"
    (agent,) = parse_swarm(text, HERE).agents
    assert agent.start_from is not None
    assert (agent.start_from / "Forage.hfa.yaml").is_file()
    assert '`start_from:` there is no folder "fouraging"' in complaint(
        text.replace("from: foraging", "from: fouraging")
    )


@pytest.mark.parametrize(
    ("count", "line", "all_at_once"),
    [
        (2, "", True),
        (200, "", False),
        (2, "all_endpoints: false", False),
        (200, "all_endpoints: true", True),
    ],
)
def test_hosts_of_few_agents_open_all_endpoints_at_once(tmp_path, count, line, all_at_once):
    text = f"swarm: s\ndomain: foraging\nhosts: 1\n{line}\nagents: {{ant: {{count: {count}}}}}\n"
    (host,) = processes(parse_swarm(text, tmp_path / "s.yaml"), tmp_path)
    assert host.parameters.get("all_endpoints", False) is all_at_once


def test_a_large_group_is_read_about_as_fast_as_a_small_one():
    def seconds(count: int) -> float:
        text = f"""
domain: foraging
start_from: foraging
agents: {{ant: {{count: {count}}}}}
machines: {{lab_1: {{runs: ant}}}}
"""
        began = time.process_time()
        parse_swarm(text, HERE)
        return time.process_time() - began

    assert min(seconds(300) for _ in range(3)) < 10.0 * min(seconds(1) for _ in range(3))
