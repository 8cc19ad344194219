"""The studio names the machine of each agent, and reports the machines that are silent."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from hitab_msgs.msg import AgentStatus, MachineProcess, MachineStatus

from hitab_ros import names, qos
from hitab_studio.studio import Studio
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState
from hitab_studio.views import render

ANTS = ("ant_1", "ant_2")
MACHINE_OF = {"ant_1": "lab_1", "ant_2": "lab_2"}


def shown(known: SwarmState, *panels: str, agent: str = "ant_2") -> str:
    """Return the text of panels of a page, without tags between words."""

    async def made() -> str:
        page = Studio(lambda: SwarmTarget(0)).open()
        page.studio.known = known
        page.agent, page.tab = agent, "swarm"
        return "".join(render(panel, page) for panel in panels)

    return asyncio.run(made())


def known(*silent: str, **changes: object) -> SwarmState:
    last = time.monotonic() - 3.0
    machines = {name: last if name in silent else None for name in ("lab_1", "lab_2")}
    statuses = {name: AgentStatus(agent=name, mode="idle") for name in ANTS}
    gone = {name: last for name in ANTS if MACHINE_OF[name] in silent}
    settings = {"machines": machines, "machine_of": MACHINE_OF, "silent": gone, **changes}
    return SwarmState(statuses=statuses, **settings)


def test_the_machine_of_each_agent_is_named():
    said = shown(known(), "agents", "overlay", "side")
    assert 'data-test="machine-ant_1">lab_1<' in said
    assert 'data-test="machine-ant_2">lab_2<' in said
    assert 'data-test="runs-on">on lab_2<' in said
    assert 'lab_2: <span class="soft">1 agent<' in said
    assert "has been silent" not in said


def test_a_swarm_on_one_machine_names_none():
    said = shown(known(machines={}, machine_of={}), "agents", "overlay", "side")
    assert not [word for word in ("lab_", "runs-on", "Machines", "machine-") if word in said]


def test_a_silent_machine_is_reported_with_the_way_out():
    said = shown(known("lab_2"), "overlay", "side", agent="ant_1")
    assert (
        "lab_2 has been silent for 3 s; `hitab move lab_2 --to lab_1` starts its agents there"
    ) in said
    assert 'lab_2: <span class="soft">1 agent, silent<' in said
    of_agent = shown(known("lab_2"), "overlay")
    assert "does not answer: lab_2, which runs it, has been silent for 3 s" in of_agent


def test_nothing_is_moved_from_a_machine_without_agents_or_with_none_left_to_move_to():
    without = shown(known("lab_2", machine_of=dict.fromkeys(ANTS, "lab_1")), "overlay")
    assert "lab_2 has been silent for 3 s<" in without
    assert "lab_1 has been silent for 3 s<" in shown(known("lab_1", "lab_2"), "overlay")


def test_what_machines_publish_is_shown_and_the_highest_lease_has_an_agent(stand_in):
    """While agents move, two machines list them."""
    topic = names.of_swarm(names.MACHINES)
    publisher = stand_in.node.create_publisher(MachineStatus, topic, qos.SIGNS_OF_LIFE)

    def publish(**leases: int) -> None:
        for machine, lease in leases.items():
            process = MachineProcess(name="host_1", lease=lease, agents=["keeper_1"])
            publisher.publish(MachineStatus(machine=machine, processes=[process]))

    async def wait(true: Callable[[], bool], what: str, **leases: int) -> None:
        deadline = time.monotonic() + 60.0
        while not true():
            assert time.monotonic() < deadline, what
            publish(**leases)
            await asyncio.sleep(0.02)

    async def run() -> None:
        studio = Studio(lambda: stand_in.target)
        await studio.start()

        def is_on(machine: str) -> bool:
            return studio.known.machine_of == {"keeper_1": machine}

        try:
            await wait(lambda: is_on("lab_2"), "it was moved to lab_2", lab_1=1, lab_2=2)
            await wait(lambda: studio.known.machines["lab_2"] is not None, "it is silent", lab_1=1)
            assert studio.known.machines["lab_1"] is None
            await wait(lambda: is_on("lab_1"), "it was moved to lab_1", lab_1=3)
        finally:
            await studio.stop()

    asyncio.run(asyncio.wait_for(run(), 100.0))
