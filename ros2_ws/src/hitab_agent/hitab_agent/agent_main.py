"""Runs one agent as a process of its own.

For example::

    python -m hitab_agent.agent_main --ros-args -r __ns:=/keeper_1 -p domain:=keepaway
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from hitab_msgs.msg import AgentStatus

from hitab_agent.node.agent_node import AgentNode
from hitab_ros import Spinner, check_name_is_free, give_signs_of_life, run


def run_agent(make: Callable[[], AgentNode]) -> int:
    """Run one agent of any kind as a process; the body of its main function.

    Args:
        make: the class of its node; the node reads its parameters from the command line.

    Returns:
        The exit code.
    """

    def start(spinning: Spinner) -> None:
        node = make()
        spinning.executor.add_node(node)
        check_name_is_free(spinning, [node], AgentStatus)
        node.join()
        give_signs_of_life(node, node.settings.swarm, node.shared.signs.fill)

    return run(start)


def main() -> None:
    """Run until stopped."""
    sys.exit(run_agent(AgentNode))


if __name__ == "__main__":
    main()
