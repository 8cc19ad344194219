"""Runs the node of a machine: `python -m hitab_machines.machine_main`, under its supervisor."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from hitab_bringup import read_swarm
from hitab_client import RunFolder, SwarmError
from hitab_client.runs.run_folder import MARK
from hitab_machines.node.machine_node import MachineNode
from hitab_ros import Spinner, run
from hitab_ros.timing import FOUND_S


def start(spinning: Spinner) -> None:
    """Create the node, once the supervisor's starter has written the record of the run."""
    folder = RunFolder(Path(os.environ.get(MARK, "")))
    spinning.spin_until(lambda: folder.read() is not None, FOUND_S)
    record = folder.read()
    if record is None or not record.machine:
        raise SwarmError(
            f"{folder.path} has no swarm with machines; `hitab up FILE --machine NAME` starts one"
        )
    swarm = read_swarm(Path(record.description))
    spinning.executor.add_node(MachineNode(folder, record, swarm))


def main() -> None:
    """Run until stopped."""
    sys.exit(run(start))


if __name__ == "__main__":
    main()
