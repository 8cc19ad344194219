"""A swarm over three machines whose network delays, loses and breaks.

The machines are network namespaces joined by veth; see `lossy_switch`.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from lossy_network import LossyNetwork, why_not

from hitab_client.runs.shipped import shipped

HOSTS = (1, 2, 3)
DELAY_S, LOSS = 0.02, 0.05
KIND = """\
commander: Leader
orders: {Halt: Stop, Spread: GetOpen, Run: GoFast}
deadline: 2
"""
MEANT = {"Halt": "Stop", "Spread": "GetOpen", "Run": "GoFast"}
UPPER = """\
commander: Upper
orders: {Halt: Halt, Spread: Spread, Run: Run}
deadline: 2
"""
COMMANDER = "hitab_commander.commander_node:CommanderNode"

pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())


class Machines:
    """Three hosts with a squad each; one agent of each squad is on the next machine.

    The commander of the squads is on the first one.
    """

    def __init__(self, folder: Path, network: LossyNetwork) -> None:
        self.folder = folder
        self.network = network
        self.agents = {h: [f"ant_{h}_{i}" for i in (1, 2, 3)] for h in HOSTS}
        (folder / "leader.yaml").write_text(KIND)
        (folder / "upper.yaml").write_text(UPPER)
        for host in HOSTS:
            self._start(host)

    def _start(self, host: int) -> None:
        place = self.folder / f"machine_{host}"
        place.mkdir()
        (place / "orders").touch()
        before = (host - 2) % 3 + 1
        roster = [
            self._ant(f"ant_{host}_1", f"squad_{host}", place),
            self._ant(f"ant_{host}_2", f"squad_{host}", place),
            self._ant(f"ant_{before}_3", f"squad_{before}", place),
            self._commander(f"squad_{host}", "leader", self.agents[host], place, "root"),
        ]
        if host == 1:
            squads = [f"squad_{h}" for h in HOSTS]
            roster.append(self._commander("root", "upper", squads, place))
        (place / "roster.json").write_text(json.dumps(roster))
        environment = {
            "ROS_DOMAIN_ID": "7",
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
            # The namespaces share memory, as machines do not.
            "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
            "FASTRTPS_DEFAULT_PROFILES_FILE": str(Path(__file__).with_name("impatient_dds.xml")),
        }
        parameters = ["--ros-args", "-p", f"roster:={place / 'roster.json'}"]
        program = [sys.executable, "-m", "hitab_agent.host_main", *parameters]
        self.network.run(host, program, place / "host.log", **environment)
        observer = str(Path(__file__).with_name("network_observer.py"))
        watched = [entry["name"] for entry in roster if entry["name"].startswith("ant")]
        program = [sys.executable, observer, str(place), *watched]
        self.network.run(host, program, place / "observer.log", **environment)

    def _ant(self, name: str, commander: str, place: Path) -> dict[str, object]:
        parameters = {"domain": "keepaway", "commander": commander}
        return {"name": name, "parameters": parameters | self._folders(place)}

    def _commander(
        self, name: str, kind: str, subordinates: list[str], place: Path, superior: str = ""
    ) -> dict[str, object]:
        parameters = {
            "domain": str(self.folder / f"{kind}.yaml"),
            "subordinates": subordinates,
            "commander": superior,
        }
        return {"name": name, "node": COMMANDER, "parameters": parameters | self._folders(place)}

    def _folders(self, place: Path) -> dict[str, str]:
        return {
            "library": str(shipped("libraries", "foraging").parent / "none"),
            "state_dir": str(place / "state"),
        }

    def performed(self, host: int) -> dict[str, str]:
        """Return what the agents on a machine perform, as seen from there."""
        try:
            found: dict[str, str] = json.loads(
                (self.folder / f"machine_{host}" / "performed.json").read_text()
            )
        except FileNotFoundError:
            return {}
        return found

    def known(self, host: int) -> list[str]:
        """Return the squads that a machine knows to be there."""
        found: list[str] = json.loads((self.folder / f"machine_{host}" / "known.json").read_text())
        return found

    def obey(self, order: str) -> bool:
        """Whether all commanders report, as seen from the first machine, that all obey."""
        file = self.folder / "machine_1" / "obeyed.json"
        obeyed = json.loads(file.read_text()) if file.exists() else {}
        return len(obeyed) == 1 + len(HOSTS) and set(obeyed.values()) == {order}

    def order(self, order: str) -> None:
        """Have the root order something."""
        with (self.folder / "machine_1" / "orders").open("a") as file:
            file.write(f"root {order}\n")

    def perform(self, order: str, hosts: tuple[int, ...] = HOSTS) -> Callable[[], bool]:
        """Return whether all agents on some machines perform what an order means."""
        return lambda: all(
            list(self.performed(host).values()) == [MEANT[order]] * 3 for host in hosts
        )

    def until(self, condition: Callable[[], bool], seconds: float = 40.0) -> None:
        """Wait until a condition holds."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                logs = [
                    (self.folder / f"machine_{h}" / "host.log").read_text()[-1000:] for h in HOSTS
                ]
                pytest.fail(f"not in time: {[self.performed(h) for h in HOSTS]}\n{logs}")
            time.sleep(0.05)


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Machines]:
    """Return three machines with a swarm."""
    with LossyNetwork(len(HOSTS), DELAY_S, LOSS) as network:
        yield Machines(tmp_path, network)


def test_a_swarm_obeys_over_a_network_that_loses_and_breaks(machines: Machines) -> None:
    machines.order("Spread")
    machines.until(machines.perform("Spread"))
    for order in ("Run", "Halt", "Spread", "Run"):
        machines.order(order)
        machines.until(machines.perform(order))

    machines.network.cut_off(3)
    machines.order("Halt")
    # Whoever is on the third machine, and whoever is commanded from there, hears nothing.
    alone = {**machines.performed(3), "ant_3_3": machines.performed(1)["ant_3_3"]}
    machines.until(
        lambda: all(
            behavior == "Stop"
            for host in (1, 2)
            for name, behavior in machines.performed(host).items()
            if name not in alone
        )
    )
    machines.order("Spread")
    machines.order("Halt")
    machines.until(lambda: machines.known(1) == ["squad_1", "squad_2"])
    machines.until(lambda: machines.known(3) == ["squad_3"])
    assert set(machines.performed(3).values()) == {"GoFast"}

    counts = machines.network.heal()
    machines.until(machines.perform("Halt"))
    machines.order("Run")
    machines.until(machines.perform("Run"))
    assert 0.02 < counts["lost"] / (counts["lost"] + counts["passed"]) < 0.08


def test_orders_and_reports_arrive_though_a_fifth_of_all_frames_is_lost(tmp_path: Path) -> None:
    with LossyNetwork(len(HOSTS), DELAY_S, 0.2) as network:
        machines = Machines(tmp_path, network)
        for order in ("Spread", "Run", "Halt"):
            machines.order(order)
            machines.until(machines.perform(order))
            machines.until(lambda order=order: machines.obey(order))
