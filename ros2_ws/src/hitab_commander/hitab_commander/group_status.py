"""The status of a commander's group: the order in force, and who performs it."""

from __future__ import annotations

from hitab_msgs import msg

from hitab_agent import AgentNode, PublishedTopic
from hitab_commander.commander_body import CommanderBody
from hitab_ros import names, qos


class GroupStatus:
    """Publishes the status of a commander's group when it has changed.

    Attributes:
        topic: the commander's own topic of it.
        changed: whether the group has changed since its status was last published.
    """

    def __init__(self, node: AgentNode) -> None:
        """Prepare to publish."""
        self.changed = True
        self._node = node
        self._published: tuple[object, ...] = ()
        self.topic = PublishedTopic(
            node,
            msg.CommanderStatus,
            names.GROUP,
            qos.LATCHED,
            latched=lambda: self.topic.publish(self.message()),
        )
        if node.shared.batches is not None:
            node.shared.batches.groups.append(self)

    def publish_if_changed(self) -> None:
        """Publish the status, if anything has changed."""
        agent = self._node.agent
        silent, faults = self._silent(), self._node.status.faults
        activity = (agent.mode, agent.behavior, agent.active_path, silent, faults)
        if not self.changed and activity == self._published:
            return
        self.changed = False
        self._published = activity
        if self.topic.end is not None:
            self.topic.publish(self.message())
        if self._node.shared.batches is not None:
            self._node.shared.batches.tell_group(self)

    def _silent(self) -> list[bool]:
        # A member that has not yet reported under this epoch counts as silent, not as disobeying.
        body: CommanderBody = self._node.agent.body
        return [not body.knows_of(name) for name in body.members]

    def message(self) -> msg.CommanderStatus:
        """Return the group's status now."""
        agent, settings = self._node.agent, self._node.settings
        body: CommanderBody = agent.body
        subordinates = [
            msg.Subordinate(
                name=name,
                behavior=last.path[0] if (last := member.latest) is not None and last.path else "",
                obeys=body.obeys(name) and not quiet,
                silent=quiet,
                stopped=last is not None and last.stopped,
            )
            for (name, member), quiet in zip(body.members.items(), self._silent(), strict=True)
        ]
        return msg.CommanderStatus(
            commander=agent.name,
            kind=body.kind.name,
            superior=settings.commander,
            mode=agent.mode.value,
            behavior=agent.behavior,
            active_path=agent.active_path,
            order=body.given,
            epoch=body.order.epoch,
            sequence=body.order.sequence,
            subordinates=subordinates,
            faults=self._node.status.faults,
            swarm=settings.swarm,
        )
