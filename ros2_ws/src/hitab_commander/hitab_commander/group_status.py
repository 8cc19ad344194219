"""The status of a commander's group: the order in force, and who performs it."""

from __future__ import annotations

from hitab_msgs import msg

from hitab_agent import AgentNode
from hitab_commander.commander_body import CommanderBody
from hitab_ros import names, qos


class GroupStatus:
    """Publishes the status of a commander's group when it has changed.

    Attributes:
        changed: whether the group has changed since its status was last published.
    """

    def __init__(self, node: AgentNode) -> None:
        """Create the publisher."""
        self.changed = True
        self._node = node
        self._published: tuple[object, ...] = ()
        self._publisher = node.create_publisher(msg.CommanderStatus, names.GROUP, qos.LATCHED)

    def publish_if_changed(self) -> None:
        """Publish the status, if anything has changed."""
        agent, settings = self._node.agent, self._node.settings
        body: CommanderBody = agent.body
        path = agent.active_path
        # A member that has not yet reported under this epoch counts as silent, not as disobeying.
        silent = [not body.knows_of(name) for name in body.members]
        faults = self._node.status.faults
        activity = (agent.mode, agent.behavior, path, silent, faults)
        if not self.changed and activity == self._published:
            return
        self.changed = False
        self._published = activity
        subordinates = [
            msg.Subordinate(
                name=name,
                behavior=last.path[0] if (last := member.latest) is not None and last.path else "",
                obeys=body.obeys(name) and not quiet,
                silent=quiet,
                stopped=last is not None and last.stopped,
            )
            for (name, member), quiet in zip(body.members.items(), silent, strict=True)
        ]
        self._publisher.publish(
            msg.CommanderStatus(
                commander=agent.name,
                kind=body.kind.name,
                superior=settings.commander,
                mode=agent.mode.value,
                behavior=agent.behavior,
                active_path=path,
                order=body.given,
                epoch=body.order.epoch,
                sequence=body.order.sequence,
                subordinates=subordinates,
                faults=faults,
                swarm=settings.swarm,
            )
        )
