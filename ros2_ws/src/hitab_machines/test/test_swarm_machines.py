"""What a person's program makes of signs of life that were lost or have not come yet."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import MachineLink, MachineStatus

from hitab_client import SwarmError
from hitab_machines.swarm_machines import SwarmMachines
from hitab_ros.timing import DISCOVERY_S, SETTLE_S, SILENT_AFTER_S


@dataclass
class Signs:
    """Stands for the signs of life: whom the program has heard, and who is silent."""

    heard: set[str] = field(default_factory=lambda: {"lab_1"})
    lost: dict[str, float] = field(default_factory=dict)

    def silent(self) -> dict[str, float]:
        return dict(self.lost)


@dataclass
class Link:
    """Stands for the program's node; time passes while it spins."""

    signs: Signs
    lasts: float
    heard_at_end: str = ""

    def spin_until(self, condition: Any, seconds: float) -> bool:
        if condition():
            return True
        self.lasts -= min(seconds, self.lasts)
        if not self.lasts:
            self.signs.lost.clear()
            self.signs.heard |= {self.heard_at_end} - {""}
        return bool(condition())

    def call(self, *_: Any, **__: Any) -> str:
        return "answered"


def program(signs: Signs, age: float, lasts: float = 0.0) -> SwarmMachines:
    """Return a program on lab_1, which heard lab_2 some time ago; the silence lasts so long."""
    machines = SwarmMachines.__new__(SwarmMachines)
    machines.link = Link(signs, lasts)  # type: ignore[assignment]
    machines.record = SimpleNamespace(machines=["lab_1", "lab_2"], namespace="")  # type: ignore[assignment]
    machines._signs = signs  # type: ignore[assignment]
    status = MachineStatus(machine="lab_1", links=[MachineLink(machine="lab_2", age=age)])
    machines.holders = SimpleNamespace(  # type: ignore[assignment]
        statuses=lambda: {"lab_1": status}, held_by=lambda machine: []
    )
    return machines


def test_a_machine_that_others_hear_is_not_silent_before_this_program_hears_it() -> None:
    assert program(Signs(), age=SILENT_AFTER_S / 2).silent() == {}
    assert program(Signs(), age=SILENT_AFTER_S * 2).silent() == {"lab_2": SILENT_AFTER_S * 2}


def test_a_program_listens_until_it_hears_the_machines_that_others_hear() -> None:
    signs = Signs()
    machines = program(signs, age=0.5, lasts=5.0)
    machines.link.heard_at_end = "lab_2"  # type: ignore[attr-defined]
    machines.listen()
    assert "lab_2" in signs.heard
    machines = program(Signs(), age=SILENT_AFTER_S * 2, lasts=60.0)
    machines.listen()
    assert machines.link.lasts == 60.0 - SETTLE_S  # type: ignore[attr-defined]


@pytest.mark.parametrize(("age", "lasts", "answers"), [(2.0, 5.0, True), (2.0, 60.0, False)])
def test_a_machine_is_asked_once_it_is_heard_again(
    age: float, lasts: float, answers: bool
) -> None:
    signs = Signs({"lab_1", "lab_2"}, {"lab_2": age})
    machines = program(signs, age, lasts)
    if answers:
        assert machines.ask("lab_2", None, "run_process", None) == "answered"
    else:
        with pytest.raises(SwarmError, match="lab_2 has been silent for 2 s"):
            machines.ask("lab_2", None, "run_process", None)


def test_a_machine_that_is_silent_for_long_is_not_waited_for() -> None:
    signs = Signs({"lab_1", "lab_2"}, {"lab_2": DISCOVERY_S * 2})
    machines = program(signs, DISCOVERY_S, lasts=1.0)
    with pytest.raises(SwarmError, match="silent for 16 s"):
        machines.ask("lab_2", None, "run_process", None)
