"""Each swarm has an identity: what is meant for one never reaches another one."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import within

from hitab_bringup.processes import supervision
from hitab_bringup.processes.bringing_up import bring_up
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.connecting.ros_link import RosLink
from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import RunFolder, running_swarms
from hitab_client.runs.run_processes import process_states
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core.operations import Perform
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART

LONE = "swarm: lone\ndomain: keepaway\nagents: {lone: {}}\n"
SOCCER = """\
swarm: soccer
world: {kind: keepaway, pace: lockstep, paused: true}
domain: keepaway
agents: {keeper_1: {}, keeper_2: {}, keeper_3: {}}
"""
WITH_A_WORLD_ALONE = LONE.replace("domain:", "world: {kind: keepaway, paused: true}\ndomain:")
IN_A_NAMESPACE = f"{WITH_A_WORLD_ALONE}namespace: apart\n"


def described(folder: Path, text: str = LONE, name: str = "swarm") -> str:
    path = folder / f"{name}.yaml"
    path.write_text(text)
    return str(path)


def up(hitab, path: str, *more: str):
    done = hitab("up", path, *more)
    assert done.returncode == 0, done.stderr
    return done


def test_names_taken_by_a_swarm_of_another_registry_are_refused_as_well(hitab, apart, monkeypatch):
    # Nothing but what is heard in the ROS domain tells of it.
    path = described(apart)
    up(hitab, path)
    ((folder, record),) = running_swarms()
    monkeypatch.setenv("HITAB_HOME", str(apart / "another_home"))
    again = hitab("up", path)
    monkeypatch.undo()
    assert again.returncode == 1
    refused, *ways_out = again.stderr.splitlines()
    assert record.identity in refused
    assert all(line.startswith("  ") for line in ways_out)
    assert RunFolder(apart / "another_home" / "lone").processes() == []
    assert folder.supervisor(record) is not None


def test_a_swarm_without_a_world_lives_beside_a_swarm_with_one_in_its_domain(apart):
    soccer = bring_up(parse_swarm(SOCCER, apart / "soccer.yaml"), RunFolder(apart / "soccer"))
    lone = parse_swarm(LONE, apart / "lone.yaml")
    with pytest.raises(SwarmError, match="its world publishes the clock from which lone takes"):
        bring_up(lone.with_sim_time(), RunFolder(apart / "lone"))
    record = bring_up(lone, RunFolder(apart / "lone"))
    assert record.domain_id == soccer.domain_id
    with RosLink(record.domain_id) as link:
        agents = SwarmClient(link, record.agents, identity=record.identity)
        agents.do("lone", Perform("Stop"))
        assert link.spin_until(lambda: agents.statuses["lone"].behavior == "Stop", 60.0)
        keepers = SwarmClient(link, soccer.agents, identity=soccer.identity)
        assert keepers.await_agents() == list(soccer.agents)
        assert {status.behavior for status in keepers.statuses.values()} == {""}
        world = WorldClient(link, identity=record.identity)
        assert link.spin_until(lambda: [*world.strangers.values()] == [soccer.identity], 60.0)
        assert world.status is None


def test_a_process_whose_name_is_taken_is_not_started_again_and_again(hitab, apart):
    up(hitab, described(apart))
    domain_id = int(os.environ["ROS_DOMAIN_ID"])
    second = RunFolder(apart / "second")
    swarm = parse_swarm(LONE, apart / "lone.yaml")
    record = supervision.launch(swarm, second, domain_id)
    try:
        ended = {"EXITED", "FATAL"}
        assert within(60, lambda: process_states(record)[0]["statename"] in ended)
        (state,) = process_states(record)
        assert (state["statename"], state["exitstatus"]) == ("EXITED", DO_NOT_RESTART)
        log = (second.path / "supervisord.log").read_text()
        assert log.count("spawned: 'lone'") == 1
        ((_, other),) = [f for f in running_swarms() if f[0].path != second.path]
        with pytest.raises(
            SwarmError, match=f'"lone" is already running in swarm {other.identity}'
        ):
            supervision.refuse_failed(record, second)
    finally:
        supervision.stop(second)


def test_two_swarms_of_one_name_are_told_apart_by_folder_and_identity(hitab, apart, monkeypatch):
    path = described(apart, IN_A_NAMESPACE)
    monkeypatch.delenv("ROS_DOMAIN_ID")
    up(hitab, path)
    second = up(hitab, path, "--run-dir", str(apart / "other"))
    both = dict(running_swarms())
    assert len({record.domain_id for record in both.values()}) == 2
    which = hitab("down", "lone")
    assert which.returncode == 1
    assert all(record.identity in which.stderr for record in both.values())
    other = next(r for f, r in both.items() if f.path == apart / "other")
    assert f"look with `hitab status --swarm {other.identity}`" in second.stdout
    status = hitab("status", "--swarm", str(apart / "other"), "--json", "-")
    assert json.loads(status.stdout)["identity"] == other.identity
    assert hitab("down", "--swarm", other.identity).stdout == f"{other.identity} is down\n"
    assert [r.identity for _, r in running_swarms()] != [other.identity]
    assert hitab("down").stdout == "lone is down\n"
    assert list(running_swarms()) == []


def test_two_swarms_that_start_at_once_choose_different_ros_domains(hitab, apart, monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID")
    command = [sys.executable, "-m", "hitab_cli.main", "up"]
    path = described(apart, IN_A_NAMESPACE)
    started = [
        subprocess.Popen([*command, path, "--run-dir", str(apart / name)], stderr=subprocess.PIPE)
        for name in ("one", "two", "three")
    ]
    for process in started:
        _, told = process.communicate(timeout=120)
        assert process.returncode == 0, told
    assert len({record.domain_id for _, record in running_swarms()}) == 3


def test_a_library_that_was_being_copied_is_copied_again(apart):
    from hitab_bringup.libraries import run_libraries as libraries
    from hitab_bringup.libraries.run_libraries import fill_libraries

    source = apart / "source"
    source.mkdir()
    for name in ("A", "B"):
        (source / f"{name}.hfa.yaml").write_text(name)
    swarm = parse_swarm(LONE.replace("{}", f"{{start_from: {source}}}"), apart / "lone.yaml")
    copied: list[Path] = []

    def interrupted(source_file: Path, destination: Path) -> None:
        if copied:
            raise KeyboardInterrupt
        copied.append(destination)
        destination.write_text(source_file.read_text())

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(libraries.shutil, "copyfile", interrupted)
        with pytest.raises(KeyboardInterrupt):
            fill_libraries(swarm.members, apart / "run")
    fill_libraries(swarm.members, apart / "run")
    names = sorted(path.name for path in (apart / "run" / "libraries" / "lone").iterdir())
    assert names == ["A.hfa.yaml", "B.hfa.yaml"]
