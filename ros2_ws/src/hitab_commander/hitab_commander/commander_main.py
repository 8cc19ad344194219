"""Runs one commander as a process of its own.

For example::

    python -m hitab_commander.commander_main --ros-args -r __ns:=/captain \
        -p domain:=captain.yaml -p subordinates:="[keeper_1, keeper_2, keeper_3]"
"""

from __future__ import annotations

import sys

from hitab_msgs.msg import AgentStatus

from hitab_commander.commander_node import CommanderNode
from hitab_ros.name_guard import refuse_second_of_name
from hitab_ros.spinning import Spinner, run


def start(spinning: Spinner) -> None:
    """Make the commander that the command line describes."""
    node = CommanderNode()
    spinning.executor.add_node(node)
    refuse_second_of_name(spinning, [node], AgentStatus)
    node.join()


def main() -> None:
    """Run until told to stop."""
    sys.exit(run(start))


if __name__ == "__main__":
    main()
