"""Runs one agent as a process of its own.

For example::

    python -m hitab_agent.agent_main --ros-args -r __ns:=/keeper_1 -p domain:=keepaway
"""

from __future__ import annotations

import sys

from hitab_msgs.msg import AgentStatus

from hitab_agent.agent_node import AgentNode
from hitab_ros.name_guard import refuse_second_of_name
from hitab_ros.spinning import Spinner, run


def start(spinning: Spinner) -> None:
    """Make the agent that the command line describes."""
    node = AgentNode()
    spinning.executor.add_node(node)
    refuse_second_of_name(spinning, [node], AgentStatus)
    node.join()


def main() -> None:
    """Run until told to stop."""
    sys.exit(run(start))


if __name__ == "__main__":
    main()
