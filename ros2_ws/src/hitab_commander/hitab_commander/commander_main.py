"""Runs one commander as a process of its own.

For example::

    python -m hitab_commander.commander_main --ros-args -r __ns:=/captain \
        -p domain:=captain.yaml -p subordinates:="[keeper_1, keeper_2, keeper_3]"
"""

from __future__ import annotations

import sys

from hitab_agent import run_agent
from hitab_commander.commander_node import CommanderNode


def main() -> None:
    """Run until stopped."""
    sys.exit(run_agent(CommanderNode))


if __name__ == "__main__":
    main()
