"""Machines of a swarm, as nodes: whom they hear, what is wrong, and what they keep of others."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hitab_msgs.msg import HostRoster, MachineStatus
from hitab_msgs.srv import ReadFiles, ReadLog, RunProcess
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.node import Node

from hitab_bringup import parse_swarm
from hitab_bringup.processes.leases import Leases
from hitab_client import RunFolder, RunRecord, SwarmError
from hitab_machines.node.machine_node import MachineNode
from hitab_ros import give_signs_of_life, make_node, names, qos
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART
from hitab_ros.testing import context_of_its_own, spin_until

SWARM = """\
swarm: lab
domain: keepaway
world: {kind: keepaway}
agents: {keeper_1: {}, keeper_2: {}, keeper_3: {}}
machines:
  lab_1: {runs: [keeper_1, world]}
  lab_2: {runs: [keeper_2, keeper_3]}
"""


class Lab:
    """Machines of a swarm, each with a run folder of its own, in one process."""

    def __init__(self, folder: Path, context: Context) -> None:
        self.folder, self.context = folder, context
        self.executor = EventsExecutor(context=context)
        self.machines: list[MachineNode] = []
        self.hosts: list[Node] = []
        self.asking = make_node("asking", context=context)
        self.executor.add_node(self.asking)

    def start(self, name: str, text: str = SWARM, place: str = "", **changes: Any) -> MachineNode:
        folder = self.folder / (place or name)
        (folder / "logs").mkdir(parents=True, exist_ok=True)
        file = folder / "swarm.yaml"
        file.write_text(text)
        swarm = parse_swarm(text, file)
        record = RunRecord(
            "lab",
            str(file),
            0,
            "",
            swarm.agent_names,
            True,
            1,
            str(folder / "socket"),
            "lab-12345678",
            machine=name,
            machines={machine.name: machine.processes for machine in swarm.machines},
            processes={
                process: tuple(m.name for m in swarm.members if m.process == process)
                for machine in swarm.machines
                for process in machine.processes
            },
        )
        node = MachineNode(
            RunFolder(folder), replace(record, **changes), swarm, context=self.context
        )
        self.machines.append(node)
        self.executor.add_node(node)
        return node

    def end(self, node: MachineNode) -> None:
        self.machines.remove(node)
        self.executor.remove_node(node)
        node.destroy_node()

    def wait(self, condition: Callable[[], Any]) -> None:
        spin_until(self.executor, condition)

    def said(self, node: MachineNode, text: str) -> None:
        """Wait until a machine reports a fault with a text."""
        try:
            self.wait(lambda: any(text in fault for fault in node.status.faults))
        except AssertionError:
            raise AssertionError(node.status.faults) from None

    def ask(self, kind: Any, machine: str, service: str, /, **fields: Any) -> Any:
        client = self.asking.create_client(kind, f"/{machine}/{service}")
        self.wait(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        self.wait(future.done)
        return future.result()


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    with context_of_its_own() as context:
        lab = Lab(tmp_path, context)
        yield lab
        for node in [*lab.machines, *lab.hosts, lab.asking]:
            lab.executor.remove_node(node)
            node.destroy_node()
        lab.executor.shutdown()


def test_machines_that_are_alike_have_no_faults_and_a_silent_one_is_named(lab: Lab) -> None:
    one, two = lab.start("lab_1"), lab.start("lab_2")
    lab.wait(lambda: "lab_2" in one.signs.heard and "lab_1" in two.signs.heard)
    lab.wait(lambda: one.status.sequence > 4)
    assert [*one.status.faults, *two.status.faults] == []
    lab.end(two)
    lab.said(one, "lab_2, which runs lab_2_host_1, has been silent for")


def test_what_is_unlike_is_said_by_name(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    one = lab.start("lab_1")
    monkeypatch.setattr("hitab_machines.node.machine_node.installed_version", lambda: "9.0")
    lab.start("lab_2", SWARM.replace("keeper_3: {}", "keeper_3: {seed: 7}"))
    lab.start("lab_3")
    lab.said(one, "lab_2 has HiTAB 9.0, lab_1")
    lab.said(one, "lab_2 was started with other files: swarm.yaml;")
    lab.said(one, "lab_3 is not a machine of the swarm file")


def test_a_machine_that_was_started_twice_is_said_by_all(lab: Lab) -> None:
    one = lab.start("lab_1")
    two, again = lab.start("lab_2"), lab.start("lab_2", place="again")
    for node in (one, two, again):
        lab.said(node, "lab_2 was started twice")


def test_a_machine_that_never_came_is_said(lab: Lab) -> None:
    one = lab.start("lab_1")
    lab.said(one, "lab_2 was not heard since lab_1 started")
    lab.said(one, "look there and here with `hitab doctor --network 10`")


def test_a_clock_that_is_off_is_said_with_what_depends_on_it(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, two = lab.start("lab_1"), lab.start("lab_2")
    lab.wait(lambda: "lab_2" in one.signs.heard)
    monkeypatch.setattr(one.signs.heard["lab_2"], "offset", 3.0)
    heard = one.signs.heard["lab_2"]
    monkeypatch.setattr(type(heard), "hear", lambda *_: None)
    lab.said(one, "the clock of lab_2 is 3.0 s ahead of that of lab_1: leases do not depend on it")
    del two


def test_what_a_machine_learns_is_copied_and_what_it_forgets_is_removed(lab: Lab) -> None:
    lab.start("lab_1")
    two = lab.folder / "lab_2"
    dig = two / "libraries/lab_2_host_1/Dig.yaml"
    training = two / "state/keeper_2"
    for folder in (dig.parent / "versions", training, two / "state/restart"):
        folder.mkdir(parents=True)
    dig.write_text("dig")
    (training / "agent.db").write_bytes(b"1")
    (training / "agent.db-wal").write_bytes(b"2")
    (two / "state/restart/keeper_2.json").write_text("{}")
    lab.start("lab_2")
    copy = lab.folder / "lab_1/copies/lab_2"
    lab.wait((copy / "state/restart/keeper_2.json").exists)
    assert (copy / "libraries/lab_2_host_1/Dig.yaml").read_text() == "dig"
    assert (copy / "state/keeper_2/agent.db-wal").read_bytes() == b"2"
    (training / "agent.db").write_bytes(b"12")
    (training / "agent.db-wal").unlink()
    dig.unlink()
    lab.wait(lambda: not (copy / "libraries/lab_2_host_1/Dig.yaml").exists())
    lab.wait(lambda: (copy / "state/keeper_2/agent.db").read_bytes() == b"12")
    assert not (copy / "state/keeper_2/agent.db-wal").exists()


def test_files_are_read_by_kind_and_path_and_nothing_else_is(lab: Lab) -> None:
    lab.start("lab_1")
    files = lab.ask(ReadFiles, "lab_1", names.READ_FILES, kind="description")
    assert [file.path for file in files.files] == ["swarm.yaml"]
    for fields, why in (
        ({"kind": "else"}, '"else" is no kind of files'),
        ({"kind": "run", "paths": ["../run.json"]}, "is not a path in a shared folder"),
        ({"kind": "run", "paths": ["libraries/../run.json"]}, "is not a path in a shared folder"),
        ({"kind": "description", "paths": ["/etc/passwd"]}, "is not a path in a shared folder"),
        ({"kind": "run", "paths": ["x"] * 20_001}, "the limit is 20000"),
    ):
        answer = lab.ask(ReadFiles, "lab_1", names.READ_FILES, **fields)
        assert not answer.success
        assert why in answer.message


def test_logs_are_read_from_the_end_and_then_on(lab: Lab) -> None:
    lab.start("lab_1")
    log = lab.folder / "lab_1/logs/world.log"
    log.write_text("".join(f"line {number}\n" for number in range(5000)))

    def read(**fields: Any) -> Any:
        return lab.ask(ReadLog, "lab_1", names.READ_LOG, process="world", **fields)

    last = read(lines=2)
    assert last.lines == ["line 4998", "line 4999"]
    assert read(lines=9, position=last.position).lines == []
    with log.open("a") as file:
        file.write("one\ntwo\nhalf")
    then = read(lines=1, position=last.position)
    assert then.lines == ["one"]
    assert read(lines=9, position=then.position).lines == ["two"]
    assert len(read(lines=2**32 - 1).lines) == 1000
    answer = lab.ask(ReadLog, "lab_1", names.READ_LOG, process="../run", lines=5)
    assert 'nothing called "../run" ran on lab_1' in answer.message


def test_a_process_is_not_run_here_without_a_reason(lab: Lab) -> None:
    lab.start("lab_1")
    for process, lease, why in (
        ("nobody", 2, 'no process "nobody" has agents'),
        ("world", 2, "world stays on lab_1"),
        ("lab_1_host_1", 2, "lab_1_host_1 runs on lab_1 already"),
        ("lab_2_host_1", 0, "the lease 0 of lab_2_host_1 is not the next after 1"),
        ("lab_2_host_1", 1, "the lease 1 of lab_2_host_1 is not the next after 1"),
        ("lab_2_host_1", 2**64 - 1, "is not the next after 1"),
        ("../lab_2_host_1", 2, 'no process "../lab_2_host_1" has agents'),
    ):
        answer = lab.ask(RunProcess, "lab_1", names.RUN_PROCESS, process=process, lease=lease)
        assert not answer.success
        assert why in answer.message


def live(lab: Lab, machine: str, lease: int) -> None:
    """Be the host of lab_2's agents on a machine."""
    host = names.of_host("keeper_2", machine)
    desk = make_node("host", namespace=f"/{host}", context=lab.context)
    lab.executor.add_node(desk)
    lab.hosts.append(desk)
    publisher = desk.create_publisher(HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    publisher.publish(
        HostRoster(
            host=host,
            number=time.time_ns(),
            agents=["keeper_2", "keeper_3"],
            machine=machine,
            lease=lease,
            swarm="lab-12345678",
        )
    )
    give_signs_of_life(desk, "lab-12345678")


def test_a_process_that_does_not_start_here_is_given_back(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    process = "lab_2_host_1"

    def states(record: RunRecord, seconds: float) -> list[dict[str, Any]]:
        yielded = Leases(lab.folder / record.machine).is_yielded(process)
        ended = {"statename": "EXITED", "exitstatus": DO_NOT_RESTART}
        found = ended if yielded else {"statename": "RUNNING"}
        return [{"name": process, **found}] if record.machine == "lab_2" else []

    def add(folder: RunFolder, record: RunRecord, process: str, lease: int) -> None:
        if record.machine == "lab_1":
            raise SwarmError("its disk is full")
        live(lab, record.machine, lease)

    monkeypatch.setattr("hitab_machines.node.local_processes.process_states", states)
    monkeypatch.setattr("hitab_machines.node.taking_over.add_process", add)
    one = lab.start("lab_1")
    lab.start("lab_2")
    lab.wait(lambda: "lab_2" in one.signs.heard)
    lab.wait(lambda: one.signs.heard["lab_2"].status.processes)
    answers = []

    def failed() -> bool:
        fields = {"process": process, "lease": 2}
        answers.append(lab.ask(RunProcess, "lab_1", names.RUN_PROCESS, **fields))
        return not answers[-1].success

    lab.wait(failed)
    assert answers[-1].message == (
        "its disk is full; lab_2_host_1 with 2 agents runs on lab_2 now (lease 3)"
    )
    kept = {name: Leases(lab.folder / name) for name in ("lab_1", "lab_2")}
    assert {name: (it.of(process), it.is_yielded(process)) for name, it in kept.items()} == {
        "lab_1": (3, True),
        "lab_2": (3, False),
    }


def test_a_roster_alone_takes_no_process_from_a_machine(lab: Lab) -> None:
    two = lab.start("lab_2")
    publisher = lab.asking.create_publisher(HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    claim = {"agents": ["keeper_2", "keeper_3"], "machine": "lab_1", "swarm": "lab-12345678"}
    publisher.publish(HostRoster(host="stray", number=time.time_ns(), lease=2, **claim))
    lab.wait(lambda: publisher.get_subscription_count())
    before = two.status.sequence
    lab.wait(lambda: two.status.sequence > before + 2)
    assert Leases(lab.folder / "lab_2").of("lab_2_host_1") == 1
    live(lab, "lab_1", 2)
    lab.wait(lambda: Leases(lab.folder / "lab_2").is_yielded("lab_2_host_1"))


def test_statuses_of_another_swarm_and_of_nobody_are_harmless(lab: Lab) -> None:
    one = lab.start("lab_1")
    publisher = lab.asking.create_publisher(MachineStatus, "/machines", qos.SIGNS_OF_LIFE)
    lab.wait(lambda: publisher.get_subscription_count() > 0)

    def tell() -> bool:
        for machine in ("lab_9", "../lab_2", ""):
            for swarm in ("other-12345678", "lab-12345678"):
                publisher.publish(MachineStatus(machine=machine, swarm=swarm, files="x"))
        return "../lab_2" in one.signs.heard

    lab.wait(tell)
    lab.said(one, "../lab_2 is not a machine of the swarm file")
    assert not (lab.folder / "lab_1/copies").exists()
    assert json.loads(json.dumps(one.guard.faults.texts())) == []
