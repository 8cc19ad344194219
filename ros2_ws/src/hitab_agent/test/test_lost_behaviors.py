"""An agent with a damaged library is up, shows what it lost and gets it back while it is up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from bodies import Body
from hitab_msgs import msg

from hitab_agent.host_resources import HostResources
from hitab_agent.node.agent_node import AgentNode
from hitab_agent.node.restart_memory import RestartMemory
from hitab_core import BehaviorLibrary
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.operations import Distribute, LoadLibrary, Perform
from hitab_core.term import Term
from hitab_core.training import Curriculum
from hitab_core.training.operation import Operation

DOMAIN = Domain.of(
    "walkers",
    "1",
    Body,
    behaviors=[BasicBehavior("Wait"), BasicBehavior("Go")],
    features=[Feature("X", lambda body: body.x)],
)


class Walkers:
    """Agents in one process, and what is needed to talk to them."""

    def __init__(self, process: Any, folder: Path, start: Any) -> None:
        self.process, self.folder = process, folder
        self._start, self._shared = start, HostResources(process.node)
        self.agents: dict[str, Any] = {}

    def start(self, name: str, domain: Domain = DOMAIN, **settings: Any) -> AgentNode:
        shared = self._shared
        self.agents[name] = self._start(domain, name, shared=shared, swarm="s", **settings)
        return self.agents[name].node

    def status(self, name: str) -> msg.AgentStatus:
        return self.agents[name].status

    def do(self, name: str, operation: Operation) -> Any:
        return self.agents[name].do(operation)

    def library(self, name: str) -> BehaviorLibrary:
        return BehaviorLibrary(self.folder / name / "library", DOMAIN)

    def damage(self, name: str, behavior: str) -> None:
        path = self.library(name).on_disk.file(behavior)
        data = path.read_bytes()
        path.write_bytes(data[: len(data) // 2])


@pytest.fixture
def walkers(process: Any, tmp_path: Path, start: Any) -> Walkers:
    return Walkers(process, tmp_path, start)


def teach(node: AgentNode, name: str, *states: str) -> None:
    node.agent.begin(Curriculum(name, (Term("X"),)))
    node.agent.sense([0.0], [])
    for state in states:
        node.agent.command(Term(state))
    node.agent.save()


def give(walkers: Walkers, name: str) -> None:
    """Give an agent a library of two behaviors: Stroll uses Walk."""
    teacher = walkers.start("teacher")
    teach(teacher, "Walk", "Go")
    teach(teacher, "Stroll", "Walk", "Wait")
    walkers.library(name).install(teacher.agent.loaded.texts)


def test_it_is_up_idles_says_why_and_begins_once_the_behavior_is_back(walkers: Walkers) -> None:
    give(walkers, "one")
    walkers.damage("one", "Walk")
    node = walkers.start("one", behavior="Stroll")
    status = walkers.status("one")
    assert status.mode == msg.AgentStatus.IDLE
    fault, began = status.faults
    assert fault.startswith("Walk is lost: its file in ")
    assert fault.endswith("; it is needed for Stroll")
    assert [remedy.code for remedy in status.remedies] == ["RESTORE", "DELETE"]
    assert 'cannot perform its start behavior "Stroll": Stroll needs Walk: its file' in began
    assert status.last_error == began
    # Nor does another restart make it forget what it performed.
    assert RestartMemory(walkers.folder, "one", "s").performed == "Stroll"
    answer = walkers.do("one", Perform("Stroll"))
    assert not answer.success
    assert answer.message.startswith("Stroll needs Walk: its file ")
    walkers.library("one").restore("Walk", 1)
    answer = walkers.do("one", LoadLibrary())
    assert answer.success
    assert sorted(answer.behaviors) == ["Stroll", "Walk"]
    walkers.process.until(lambda: walkers.status("one").behavior == "Stroll")
    assert walkers.status("one").faults == []
    assert node.agent.behavior == "Stroll"


def test_a_sound_copy_that_is_distributed_brings_back_what_was_lost(walkers: Walkers) -> None:
    give(walkers, "one")
    walkers.damage("one", "Walk")
    walkers.start("one", behavior="Stroll")
    refused = walkers.do("one", Distribute("Stroll"))
    assert not refused.success
    assert refused.message.startswith("Stroll needs Walk: its file ")
    sent = walkers.do("teacher", Distribute("Walk"))
    assert sent.success
    walkers.process.until(lambda: walkers.status("one").behavior == "Stroll")
    assert walkers.status("one").faults == []
    assert sorted(walkers.library("one").load()) == ["Stroll", "Walk"]
