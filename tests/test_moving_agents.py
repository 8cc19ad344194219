"""Agents move to another machine with what they have learned, also if theirs is lost."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import psutil
import pytest
from hitab_msgs.msg import AgentStatus
from lossy_network import shifted_clock
from waiting import within

from hitab_bringup import described_swarm
from hitab_bringup.libraries.library_choice import shipped_libraries
from hitab_bringup.processes import supervision
from hitab_bringup.processes.bringing_up import bring_up
from hitab_client import MachineSigns, RosLink, RunFolder, RunRecord, SwarmClient
from hitab_client.runs.run_processes import process_states
from hitab_core.operations import BeginTraining, Command, SaveBehavior

SECONDS = 60.0
LAB = """\
swarm: lab
domain: keepaway
world: {kind: keepaway, pace: realtime}
agents: {keeper_1: {}, keeper_2: {}, keeper_3: {}}
machines:
  lab_1: {runs: [keeper_1, world]%s}
  lab_2: {runs: [keeper_2, keeper_3]}
"""
MOVED = "lab_2_host_1"
Hitab = Callable[..., subprocess.CompletedProcess[str]]


class Lab:
    """A swarm on two machines, each of which is a run folder."""

    def __init__(
        self,
        place: Path,
        hitab: Hitab,
        more: str = "",
        before: str = "",
        machines: Sequence[str] = ("lab_1", "lab_2"),
    ) -> None:
        self.file = place / "lab.yaml"
        self.file.write_text(before + LAB % more)
        self.folders = {name: RunFolder(place / name) for name in ("lab_1", "lab_2")}
        self._hitab = hitab
        for name in machines:
            self.up(name)

    def up(self, name: str) -> None:
        folder = self.folders[name]
        bring_up(described_swarm(str(self.file), folder.path, machine=name), folder)

    def record(self, name: str = "lab_1") -> RunRecord:
        record = self.folders[name].read()
        assert record is not None
        return record

    def hitab(self, verb: str, *arguments: str, on: str = "lab_1") -> tuple[int, str]:
        done = self._hitab(verb, *arguments, "--swarm", str(self.folders[on].path))
        return done.returncode, done.stdout + done.stderr

    def agents(self, link: RosLink) -> SwarmClient:
        record = self.record()
        agents = SwarmClient(link, record.agents, identity=record.identity)
        agents.await_agents()
        return agents

    def teach(self) -> AgentStatus:
        """Save one behavior of keeper_2, and leave the training of another one."""
        with RosLink(self.record().domain_id) as link:
            agents = self.agents(link)
            for name, commands in (("Saved", 2), ("Unsaved", 3)):
                agents.do("keeper_2", BeginTraining(name, features=["Done"]))
                for number in range(commands):
                    agents.do("keeper_2", Command(("Stop", "GoFast")[number % 2]))
                if name == "Saved":
                    agents.do("keeper_2", SaveBehavior())
            return agents.statuses["keeper_2"]

    def state(self, name: str) -> str:
        """Return what the supervisor of a machine says of the process that moves."""
        states = {state["name"]: state["statename"] for state in process_states(self.record(name))}
        return states.get(MOVED, "not there")

    def copied(self) -> bool:
        """Whether lab_1 has a copy of the unsaved training and the saved behavior."""
        theirs, copy = self.folders["lab_2"].path, self.folders["lab_1"].path / "copies/lab_2"
        files = [*theirs.glob("libraries/*/*"), *theirs.glob("state/*/*.db*")]
        return all(
            (copy / path.relative_to(theirs)).exists()
            and (copy / path.relative_to(theirs)).read_bytes() == path.read_bytes()
            for path in files
            if path.is_file()
        )

    def lose(self, name: str) -> None:
        """Kill all processes of a machine, its supervisor first."""
        found = self.folders[name].processes()
        found.sort(key=lambda process: process.pid)
        for process in found:
            process.send_signal(signal.SIGKILL)
        psutil.wait_procs(found)

    def learned(self) -> AgentStatus:
        """Return the status of keeper_2, which runs again."""
        with RosLink(self.record().domain_id) as link:
            agents = self.agents(link)
            trained = lambda: agents.statuses["keeper_2"].training.examples  # noqa: E731
            assert link.spin_until(trained, SECONDS)
            return agents.statuses["keeper_2"]

    def heard_saying(self, text: str) -> bool:
        """Whether a machine says something."""
        record = self.record()
        with RosLink(record.domain_id) as link:
            signs = MachineSigns(link.node, "", record.identity)
            heard = lambda: [f for m in signs.heard.values() for f in m.status.faults]  # noqa: E731
            return link.spin_until(lambda: any(text in fault for fault in heard()), SECONDS)


@pytest.fixture
def folder(apart: Path) -> Iterator[Path]:
    yield apart
    for name in ("lab_1", "lab_2"):
        supervision.stop(RunFolder(apart / name))


def test_agents_move_with_what_they_have_learned_and_back(hitab: Hitab, folder: Path) -> None:
    lab = Lab(folder, hitab)
    before = lab.teach()
    code, said = lab.hitab("move", "keeper_2", "--to", "lab_1")
    assert code == 1
    assert f"{MOVED}, which runs keeper_2, runs keeper_3 as well; move {MOVED}" in said
    code, said = lab.hitab("move", "keeper", "--to", "lab_3")
    assert (code, 'no machine "lab_3"' in said) == (1, True)
    code, said = lab.hitab("move", "world", "--to", "lab_2")
    assert (code, "world stays on lab_1" in said) == (1, True)

    code, said = lab.hitab("move", MOVED, "--to", "lab_1", on="lab_2")
    assert code == 0, said
    assert f"{MOVED} with 2 agents runs on lab_1 now (lease 2)" in said
    assert within(SECONDS, lambda: lab.state("lab_2") == "EXITED")
    assert within(SECONDS, lambda: lab.state("lab_1") == "RUNNING")
    after = lab.learned()
    assert after.process != before.process
    assert after.training.examples == before.training.examples > 0
    assert (after.training.automaton, after.library_digest) == ("Unsaved", before.library_digest)

    found = json.loads(lab.hitab("status", "--json", "-", on="lab_2")[1])
    assert {agent["agent"]: agent["machine"] for agent in found["agents"]} == dict.fromkeys(
        ("keeper_1", "keeper_2", "keeper_3"), "lab_1"
    )
    assert found["silent"] == {}
    assert "from lab_1" in lab.hitab("logs", "keeper_2", on="lab_2")[1]
    code, said = lab.hitab("move", "keeper_2", "--to", "lab_1")
    assert code == 1

    code, said = lab.hitab("move", MOVED, "--to", "lab_2")
    assert code == 0, said
    assert "(lease 3)" in said
    assert lab.learned().training.examples == before.training.examples
    assert lab.hitab("down")[0] == 0
    assert not any(folder.processes() for folder in lab.folders.values())


def test_agents_of_a_lost_machine_are_moved_and_it_yields_when_it_is_back(
    hitab: Hitab, folder: Path
) -> None:
    lab = Lab(folder, hitab)
    before = lab.teach()
    assert within(SECONDS, lab.copied)
    lab.lose("lab_2")
    code, said = lab.hitab("status", "--check")
    assert code == 1
    assert "which runs keeper_2, keeper_3, has been silent for" in said
    assert "`hitab move lab_2 --to lab_1` starts its agents there" in said
    assert lab.heard_saying(f"lab_2, which runs {MOVED}, has been silent for")
    code, said = lab.hitab("move", "lab_2", "--to", "lab_1")
    assert code == 0, said
    assert "and its copy is" in said
    after = lab.learned()
    assert after.training.examples == before.training.examples > 0
    assert after.library_digest == before.library_digest

    lab.up("lab_2")
    assert within(SECONDS, lambda: lab.state("lab_2") in ("EXITED", "not there"))
    assert lab.learned().process == after.process
    assert lab.state("lab_1") == "RUNNING"
    supervision.stop(lab.folders["lab_2"])
    lab.up("lab_2")
    assert lab.state("lab_2") == "not there"


def test_a_wrong_clock_and_another_library_of_a_machine_are_said_by_name(
    hitab: Hitab, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = folder / "mine"
    library.mkdir()
    behavior = next(shipped_libraries()["keepaway"].glob("*.yaml"))
    (library / behavior.name).write_bytes(behavior.read_bytes())
    lab = Lab(folder, hitab, before="start_from: mine\n", machines=("lab_1",))
    with (library / behavior.name).open("a") as file:
        file.write("# learned since\n")
    monkeypatch.setenv("CLOCK_SHIFT_S", "3")
    monkeypatch.setenv("LD_PRELOAD", str(shifted_clock(folder)))
    lab.up("lab_2")
    assert lab.heard_saying("the clock of lab_2 is 3.0 s ahead of that of lab_1")
    assert lab.heard_saying(f"lab_2 was started with other files: mine/{behavior.name}")


def test_a_machine_takes_over_by_itself_if_the_file_says_so(hitab: Hitab, folder: Path) -> None:
    lab = Lab(folder, hitab, ", takes_over: [lab_2]")
    before = lab.teach()
    assert within(SECONDS, lab.copied)
    lab.lose("lab_2")
    assert within(SECONDS, lambda: lab.state("lab_1") == "RUNNING")
    after = lab.learned()
    assert after.process != before.process
    assert after.training.examples == before.training.examples > 0


def test_a_machine_that_stood_still_yields_when_it_goes_on(hitab: Hitab, folder: Path) -> None:
    lab = Lab(folder, hitab)
    lab.teach()
    assert within(SECONDS, lab.copied)
    frozen = lab.folders["lab_2"].processes()
    for process in frozen:
        process.suspend()
    try:
        assert lab.heard_saying(f"lab_2, which runs {MOVED}, has been silent for")
        code, said = lab.hitab("move", "lab_2", "--to", "lab_1")
        assert code == 0, said
        moved = lab.learned()
    finally:
        for process in frozen:
            process.resume()
    log = lab.folders["lab_2"].log(MOVED)
    yielded = f"{MOVED} runs on lab_1 now (lease 2); this one yields"
    assert within(SECONDS, lambda: yielded in log.read_text())
    assert within(SECONDS, lambda: lab.state("lab_2") == "EXITED")
    leases = lab.folders["lab_2"].path / "leases.json"
    assert within(
        SECONDS, lambda: leases.exists() and json.loads(leases.read_text()) == {MOVED: -2}
    )
    assert lab.learned().process == moved.process
