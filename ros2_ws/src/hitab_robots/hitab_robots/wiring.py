"""Checks of the wiring between an agent and its robot, by the ROS graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSCompatibility, qos_check_compatible

from hitab_agent import AgentNode
from hitab_core import some
from hitab_robots.bases import name_of
from hitab_robots.settings import AGENT_VELOCITY_TOPIC, BASE_TOPIC
from hitab_robots.standard_domain import ValueOf
from hitab_ros import fault_texts, names

Reach = Mapping[str, float]
"""The largest ranges of the sensors, as in their messages, m, by name."""

Check = Callable[[AgentNode, Reach], str]
"""A check returns a fault and the way out; an empty text if there is none."""


def stopped_clock(node: AgentNode, reach: Reach) -> str:
    """Report simulated time without a publisher of the clock."""
    topic = node.resolve_topic_name(names.CLOCK)
    if not node.get_parameter("use_sim_time").value or node.count_publishers(topic):
        return ""
    return (
        f"use_sim_time is true and no node publishes {topic}, so the agent never decides; start "
        "the simulation that publishes it, or set use_sim_time to false"
    )


def deaf_base(node: AgentNode, reach: Reach) -> str:
    """Report a base that is missing, or takes another type or QoS than the relay sends."""
    topic = node.resolve_topic_name(BASE_TOPIC)
    publishers = node.get_publishers_info_by_topic(topic)
    own = [info for info in publishers if _is_own(node, info)]
    sent = {info.topic_type for info in own}
    if not sent:
        return ""  # a missing relay is another fault
    takers = node.get_subscriptions_info_by_topic(topic)
    if not takers:
        return (
            f"no node subscribes to {topic}, so the robot cannot move; start the driver of its "
            f"base, or remap {BASE_TOPIC} to the driver's topic"
        )
    for taker in takers:
        fits, why = qos_check_compatible(own[0].qos_profile, taker.qos_profile)
        if fits == QoSCompatibility.ERROR:
            return (
                f"{name_of(taker)} gets nothing of {topic}, since its QoS does not fit: "
                f"{why.strip(';')}; have it subscribe as volatile, with QoSProfile(depth=10)"
            )
    deaf = [info for info in takers if info.topic_type not in sent]
    if not deaf:
        return ""
    taken = sorted({f"{name_of(info)} takes {info.topic_type}" for info in deaf})
    other = "false" if any(kind.endswith("Stamped") for kind in sent) else "true"
    return (
        f"{topic} is sent as {some(sorted(sent))}, but {some(taken)}; set the parameter "
        f"enable_stamped_cmd_vel to {other}"
    )


def second_driver(node: AgentNode, reach: Reach) -> str:
    """Report nodes that send velocities to the base past the relay."""
    topic = node.resolve_topic_name(BASE_TOPIC)
    publishers = node.get_publishers_info_by_topic(topic)
    others = sorted({name_of(info) for info in publishers if not _is_own(node, info)} - {""})
    if not others:
        return ""
    return (
        f"{some(others)} publishes {topic}, past the {names.VELOCITY_RELAY}: neither the relay's "
        f"limits nor the emergency stop apply to it; remap it to "
        f"{node.resolve_topic_name(AGENT_VELOCITY_TOPIC)}, as TwistStamped"
    )


def far_threshold(node: AgentNode, reach: Reach) -> str:
    """Report trained behaviors that decide by a range that the sensor never measures."""
    repertoire, far = node.agent.repertoire, set()
    for automaton in repertoire.automata.values():
        for function in automaton.transitions.values():
            for place, threshold in getattr(function, "thresholds", ()):
                feature = automaton.features[place]
                read = repertoire.domain.feature(feature.name).read
                value = read.name if isinstance(read, ValueOf) else ""
                sensor = value.partition(".")[0]
                if value.endswith(".range") and threshold > reach.get(sensor, threshold):
                    far.add(
                        f'"{automaton.name}" decides by whether {feature} is above '
                        f"{threshold:.4g} m, but sensor {sensor} measures up to "
                        f"{reach[sensor]:.4g} m"
                    )
    return f"{'; '.join(sorted(far))}; train it with this sensor" if far else ""


CHECKS: tuple[Check, ...] = (stopped_clock, deaf_base, second_driver, far_threshold)


def unheard(node: Node, topic: str, message: str) -> str:
    """Return why no message of this type comes on a topic, given by its remapped name."""
    types = {info.topic_type for info in node.get_publishers_info_by_topic(topic)}
    if message in types:
        return fault_texts.SILENT
    if types:
        return (
            f"published as {some(sorted(types))} and not as {message}; remap {topic} to the topic "
            "of that type, or declare the sensor that reads this one"
        )
    number = node.context.get_domain_id()
    return (
        f"{fault_texts.NOT_PUBLISHED} in ROS domain {number}; start the robot's driver there "
        f"(ROS_DOMAIN_ID={number}), or remap the topic; let ROS_AUTOMATIC_DISCOVERY_RANGE reach "
        "the driver if it is on another computer"
    )


def _is_own(node: Node, info: Any) -> bool:
    """Return whether a publisher belongs to the relay or to the agent's own node."""
    own = (names.VELOCITY_RELAY, node.get_name())
    return info.node_namespace == node.get_namespace() and info.node_name in own
