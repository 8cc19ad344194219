"""The interface of an agent's node, as its parts use it."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from hitab_msgs import msg

from hitab_agent.links.robot_link import RobotStop
from hitab_agent.node.guarded_tick import Action
from hitab_agent.node.settings import AgentParameters
from hitab_core import Agent, Mode
from hitab_core.training.operation import Operation, Outcome
from hitab_ros import GuardedNode
from hitab_ros.nodes.diagnostics import Diagnosis, Level


class AgentBase(GuardedNode):
    """The interface of an agent's node, which `hitab_agent.node.agent_node.AgentNode` implements.

    Attributes:
        agent: the engine's agent.
        agent_name: name of the agent.
        settings: parameters of the agent.
        shared: the `HostResources` of its process.
        status: the agent's `StatusPublisher`.
        percept_log: publishes its percepts for recorders, a `PerceptLog`.
        transition_log: publishes its state changes, a `TransitionLog`.
        training: publishes what it is being trained, a `TrainingTopic`.
        endpoints: its other topics and its services, an `AgentEndpoints`.
        stop: the stop of the agent's robot; None if it has none.
        hold: why the world should hold, since the agent has not acted; empty if it need not.
        unreached: who is out of reach, and since when, so that it halts; empty if nobody is.
        has_robot: whether it perceives and acts, in a world or by the link of its domain; a
            commander does not.
    """

    agent: Agent
    agent_name: str
    settings: AgentParameters
    shared: Any
    status: Any
    percept_log: Any
    transition_log: Any
    training: Any
    endpoints: Any
    stop: RobotStop | None = None
    hold = unreached = ""
    has_robot = True

    def take_in(self, percept: msg.Percept, seconds: float) -> None:
        """Take in a percept.

        Args:
            percept: the percept. It may be reused, so copy the values that are kept.
            seconds: the agent's time, s: that of the world, the robot or the subordinates.
        """

    def answer(self, percept: msg.Percept) -> Action:
        """Act on the last percept, unless it is for inspection only."""
        raise NotImplementedError

    @property
    def taught(self) -> bool:
        """Whether a demonstrator is in control, so that the world slows down."""
        return self.agent.mode is Mode.TRAINING

    def awaited_orders(self) -> Collection[str]:
        """Return the commanders whose orders a lockstep round waits for."""
        raise NotImplementedError

    def ordered(self) -> None:
        """Publish the outcome of an order: obeyed, or waiting with the reason."""

    def settle(self) -> None:
        """Retry a waiting order after a demonstrator has changed something."""

    def do(self, operation: Operation) -> Outcome:
        """Carry out an operation, and publish what became of it.

        Raises:
            HitabError: if it is refused.
        """
        raise NotImplementedError

    def answered(self, error: Exception | None) -> None:
        """Settle after an operation, and show in the status what went wrong."""

    def diagnose(self) -> Diagnosis:
        """Return the faults of the agent."""
        raise NotImplementedError

    def troubles(self) -> list[tuple[Level, str]]:
        """Return further faults, for a kind of agent that has more than one body."""
        return []
