"""Ends the part of a swarm in a run folder: `python -m hitab_machines.take_down_main FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path

from hitab_bringup.processes import supervision
from hitab_client import RunFolder
from hitab_client.runs.run_folder import registry_held


def main() -> None:
    """End all processes of a run folder."""
    with registry_held():
        supervision.stop(RunFolder(Path(sys.argv[1])))


if __name__ == "__main__":
    main()
