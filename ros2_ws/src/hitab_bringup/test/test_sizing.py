"""What a swarm takes is predicted from parts of it that were run."""

from dataclasses import asdict, replace
from pathlib import Path

import pytest

from hitab_bringup import (
    Needs,
    lacks,
    parse_swarm,
    predict,
    reduced,
    refuse_untriable,
    trial_sizes,
    try_out,
)
from hitab_client import DescriptionError
from hitab_client.runs.shipped import shipped

LIBRARY = shipped("libraries", "foraging")


def needs(members: int) -> Needs:
    return Needs(
        start_s=3 + 0.01 * members,
        start_cpu_s=2 + 0.02 * members,
        cycle_ms=5 + 0.1 * members,
        world_cores=0.1 + 0.0002 * members,
        agents_cores=0.05 + 0.001 * members,
        world_mb=60.0,
        agents_mb=100 + 0.2 * members,
        strangers_cores=0.0,
    )


def swarm(folder: Path, agents: int = 60, more: str = "", world: str = "") -> object:
    text = f"""
swarm: sized
domain: foraging
start_from: {LIBRARY}
behavior: Search
world: {{kind: foraging, parameters: {{foragers: {agents}}}{world}}}
agents:
  forager: {{count: {agents}}}
kinds:
  Leader: {{orders: {{Search: Search}}}}
commanders:
  squad: {{kind: Leader, commands: {{forager: 5}}}}
  chief: {{kind: Leader, commands: squad, host: headquarters}}
{more}
"""
    return parse_swarm(text, folder / "sized.yaml")


def test_a_swarm_takes_what_the_line_through_two_parts_says():
    trials = {size: needs(size) for size in (100, 400)}
    assert asdict(predict(trials, 2000, 2)) == pytest.approx(asdict(needs(2000)))


def test_more_processes_at_the_same_time_only_shorten_the_start():
    trials = {size: needs(size) for size in (100, 400)}
    few, many = predict(trials, 2000, 2), predict(trials, 2000, 8)
    assert many.start_s < few.start_s
    assert replace(many, start_s=few.start_s) == few


def test_noise_does_not_make_a_swarm_cheaper_than_its_part_nor_a_whole_other_than_it_was():
    trials = {100: replace(needs(100), world_mb=70.0), 400: needs(400)}
    assert predict(trials, 2000, 2).world_mb == 60.0
    assert predict({12: needs(12)}, 12, 2) == needs(12)


def test_other_programs_are_named_if_they_disturbed_any_trial(tmp_path):
    trials = {100: replace(needs(100), strangers_cores=1.5), 400: needs(400)}
    (found,) = lacks(swarm(tmp_path), predict(trials, 500, 2), 2, 1e6)
    assert "other programs used 1.5 of 2 cores" in found


def test_small_swarms_are_run_whole_and_of_large_ones_two_parts():
    assert trial_sizes(60) == (60,)
    for members in (61, 300, 1251, 100_000):
        small, large = trial_sizes(members)
        assert 2 * small <= large < members
        assert large <= 1000


@pytest.mark.parametrize("hosts", [0, 2, 5])
@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_part_has_whole_squads_and_every_host_of_the_swarm(tmp_path, hosts, share):
    whole = swarm(tmp_path, 300, f"hosts: {hosts}" if hosts else "")
    part = reduced(whole, share)
    assert len(whole.agents) * share <= len(part.agents) < len(whole.agents) * share + 5 * 6
    assert part.world == whole.world
    before = {one.name: one.subordinates for one in whole.commanders}
    names = {member.name for member in part.members}
    for squad in part.commanders:
        assert {*squad.subordinates} <= names
        if squad.name != "chief":
            assert squad.subordinates == before[squad.name]
    assert {agent.superior for agent in part.agents} < names
    if hosts:
        assert {m.process for m in part.members} == {m.process for m in whole.members}


def test_a_part_opens_as_many_endpoints_as_the_whole_would(tmp_path):
    whole = swarm(tmp_path, 60, "hosts: 2")
    assert reduced(whole, 0.1).all_endpoints is False
    assert reduced(replace(whole, all_endpoints=True), 0.1).all_endpoints is True


def test_one_commander_of_all_keeps_only_a_share(tmp_path):
    text = (
        "swarm: flat\ndomain: foraging\nhosts: 2\nworld: {kind: foraging}\n"
        "agents: {ant: {count: 200}}\nkinds: {Leader: {orders: {Search: Search}}}\n"
        "commanders: {root: {kind: Leader, commands: ant}}\n"
    )
    part = reduced(parse_swarm(text, tmp_path / "flat.yaml"), 0.2)
    assert len(part.agents) == 40
    assert [len(one.subordinates) for one in part.commanders] == [40]


@pytest.mark.parametrize(
    ("cores", "memory_mb", "said"),
    [
        (2, 1000.0, "it takes 2.4 cores, and there are 2: give the world a `factor` below 0.82"),
        (4, 400.0, "it takes 540 MB, and 400 MB are available: use more machines or fewer"),
    ],
)
def test_what_a_machine_lacks_is_said_with_ways_out(tmp_path, cores, memory_mb, said):
    (found,) = lacks(swarm(tmp_path), needs(1900), cores, memory_mb)
    assert said in found
    assert list(lacks(swarm(tmp_path), needs(1900), 4, 1000.0)) == []


def test_in_lockstep_no_cores_are_lacking(tmp_path):
    in_lockstep = swarm(tmp_path, world=", pace: lockstep")
    assert list(lacks(in_lockstep, needs(2000), 1, 1e6)) == []


def test_nothing_but_a_simulated_world_is_moved_for_a_trial(tmp_path):
    refuse_untriable(swarm(tmp_path))
    drivers = swarm(tmp_path, more="processes: {lidar: {command: sleep 1}}")
    with pytest.raises(DescriptionError, match=r"starts programs of its own \(lidar\).*processes"):
        refuse_untriable(drivers)
    with pytest.raises(
        DescriptionError, match="has no `world:`, so a trial run would move robots"
    ):
        refuse_untriable(replace(swarm(tmp_path), world=None))


@pytest.mark.parametrize("pace", ["realtime", "lockstep"])
def test_a_part_plays_and_leaves_the_swarm_as_it_was(tmp_path, monkeypatch, pace):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    whole = swarm(tmp_path, 10, "hosts: 2", f", pace: {pace}, paused: true")
    folder = tmp_path / "sized"
    learned = folder / "libraries" / whole.agents[0].process
    learned.mkdir(parents=True)
    (learned / "note.txt").write_text("mine")
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    seen = []
    part = reduced(whole, 0.5)
    found = try_out(part, folder, 1.0, lambda up, of, missing: seen.append((up, of)))
    assert seen[-1][0] == seen[-1][1]
    assert all(value > 0.0 for name, value in asdict(found).items() if name != "strangers_cores")
    assert found.start_cpu_s > 0.5  # interpreters alone take that
    assert found.agents_mb > found.world_mb / 2
    if pace == "realtime":
        assert found.cycle_ms > 80.0
    after = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    assert {path: after[path] for path in before} == before
    assert not list((tmp_path / "home" / "running").glob("*"))
