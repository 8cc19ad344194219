"""The ROS node of one commander: an agent whose body is its group of subordinates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hitab_agent import AgentNode
from hitab_commander.commander_domain import commander_domain
from hitab_commander.commander_link import CommanderLink
from hitab_commander.kinds.kind_reader import read_kind
from hitab_core import Domain, HitabError, Mode, some
from hitab_ros.nodes.diagnostics import Level

NAMED_MAX = 10  # maximum number of subordinates that a diagnosis names


class CommanderNode(AgentNode):
    """One commander, in the namespace of its name.

    A commander has all topics, services and parameters of an agent. Its parameter ``domain`` is
    the path of the file that describes its kind (see `hitab_commander.kinds.kind_reader`).
    """

    has_robot = False
    _link: CommanderLink | None

    def __init__(self, node_name: str = "commander", **options: Any) -> None:
        super().__init__(node_name, **options)

    def resumed(self) -> dict[str, Any]:
        """Return what is stored for a restart: the behavior and the order to resume."""
        order = self.agent.body.order
        # Until the link has resumed the previous process's order, keep the stored one.
        in_force = {"epoch": order.epoch, "order": order.name} if order.epoch else {}
        return super().resumed() | in_force

    def load_domain(self, name: str) -> Domain:
        """Return the domain of the kind of commander in the file ``name``."""
        if not name:
            raise HitabError(
                f"the commander {self.agent_name} has no domain; "
                "give it -p domain:=captain.yaml, a file that describes its kind"
            )
        domains = self.shared.domains
        if name not in domains:
            domains[name] = commander_domain(read_kind(Path(name)))
        return domains[name]

    def ordered(self) -> None:
        """Decide at once what the subordinates should do for an order to this commander."""
        super().ordered()
        self._decide()

    def settle(self) -> None:
        """Retry a waiting order after a person's request, and decide at once."""
        super().settle()
        self._decide()

    def faults_changed(self) -> None:
        """Publish a status soon, and decide again."""
        super().faults_changed()
        if self._link is not None:
            self._link.calm = False

    def troubles(self) -> list[tuple[Level, str]]:
        """Return which subordinates are silent."""
        body = self.agent.body
        silent = [name for name in body.members if body.is_silent(name)]
        if not silent:
            return []
        level = Level.STALE if len(silent) == len(body.members) else Level.WARN
        return [(level, f"silent subordinates: {some(silent, NAMED_MAX)}")]

    def _decide(self) -> None:
        if self._link is None:
            return
        self._link.calm = False
        if self.agent.mode in (Mode.PERFORMING, Mode.TESTING):
            self._link.decide()
        else:
            self.remember()


def link(node: CommanderNode, world: str, on_percept: Any) -> CommanderLink:
    """Return the link of a commander to its group, in the place of a robot's link.

    The link ignores worlds, and decides itself when to perceive and when to act.
    """
    return CommanderLink(node)
