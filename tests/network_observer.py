"""Watches agents from one host of a network, and gives orders to a commander.

Arguments: the folder to write into, then names of agents. What each was last heard to perform is
in the folder's file ``performed.json``. A line ``COMMANDER BEHAVIOR`` in its file ``orders`` is
carried out, and the answer written into ``answered``. Which squads this machine knows to be there
is in ``known.json``; ``obeyed.json`` has the order of each commander that all of its group obey.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from hitab_msgs import msg, srv

from hitab_ros import names, qos
from hitab_ros.nodes.spinning import Spinner, make_node, run

SQUADS = ("squad_1", "squad_2", "squad_3")


def start(spinning: Spinner) -> None:
    """Begin to watch."""
    folder, agents = Path(sys.argv[1]), sys.argv[2:]
    node = make_node("observer")
    performed: dict[str, str] = {}
    obeyed: dict[str, str] = {}
    clients: dict[str, Any] = {}
    done: list[str] = []

    def write(name: str, content: object) -> None:
        partial = folder / f"{name}.partial"
        partial.write_text(json.dumps(content))
        partial.replace(folder / name)

    def hear(status: msg.AgentStatus) -> None:
        performed[status.agent] = status.behavior
        write("performed.json", performed)

    def hear_group(group: msg.CommanderStatus) -> None:
        all_obey = all(one.obeys and not one.silent for one in group.subordinates)
        obeyed[group.commander] = group.order if all_obey else ""
        write("obeyed.json", obeyed)

    def look() -> None:
        known = [a for a in SQUADS if node.count_publishers(f"/{a}/{names.GROUP}")]
        write("known.json", known)
        lines = (folder / "orders").read_text().splitlines()
        for line in lines[len(done) :]:
            commander, behavior = line.split()
            if commander not in clients:
                service = f"/{commander}/perform"
                clients[commander] = node.create_client(srv.Perform, service)
            if not clients[commander].service_is_ready():
                return
            done.append(line)
            future = clients[commander].call_async(srv.Perform.Request(behavior=behavior))
            future.add_done_callback(lambda answer: write("answered", answer.result().message))

    for agent in agents:
        node.create_subscription(msg.AgentStatus, f"/{agent}/{names.STATUS}", hear, qos.LATCHED)
    for commander in ("root", *SQUADS):
        topic = f"/{commander}/{names.GROUP}"
        node.create_subscription(msg.CommanderStatus, topic, hear_group, qos.LATCHED)
    node.create_timer(0.05, look)
    spinning.executor.add_node(node)


if __name__ == "__main__":
    sys.exit(run(start, []))
