"""A machine does not join a swarm in which another computer has its name."""

import contextlib
from types import SimpleNamespace

import pytest
from hitab_msgs.msg import MachineLink, MachineStatus

from hitab_client import SwarmError
from hitab_machines import joining
from hitab_ros.timing import SILENT_AFTER_S


@pytest.fixture
def heard(monkeypatch) -> dict[str, SimpleNamespace]:
    """Return what this computer has heard, by machine; nothing more arrives."""
    signs: dict[str, SimpleNamespace] = {}
    link = SimpleNamespace(spin_until=lambda condition, seconds: condition())
    monkeypatch.setattr(joining, "refuse_limits", lambda name: None)
    monkeypatch.setattr(joining, "_differences", lambda swarm, statuses: [])
    monkeypatch.setattr(joining.domain_ids, "for_swarm", lambda **options: 7)
    monkeypatch.setattr(
        joining,
        "_signs_of",
        lambda swarm, domain: contextlib.nullcontext((link, SimpleNamespace(heard=signs))),
    )
    return signs


SWARM = SimpleNamespace(
    name="field",
    machine="lab_2",
    machines=[SimpleNamespace(name=name) for name in ("lab_1", "lab_2", "lab_3")],
)


def hears(age: float) -> SimpleNamespace:
    """Return a machine that has heard lab_2 so many seconds ago."""
    return SimpleNamespace(status=MachineStatus(links=[MachineLink(machine="lab_2", age=age)]))


def test_a_name_is_taken_though_only_others_hear_who_has_it(heard):
    heard |= {"lab_1": hears(0.2), "lab_3": hears(90.0)}
    with pytest.raises(SwarmError, match=r"lab_2 of swarm field is already up.*not up: none"):
        joining.refuse_to_join(SWARM)


def test_the_name_of_a_lost_machine_is_free(heard):
    heard |= {"lab_1": hears(SILENT_AFTER_S + 0.1), "lab_3": hears(90.0)}
    joining.refuse_to_join(SWARM)
