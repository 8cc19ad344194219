"""The verb `hitab joystick`, with which a person trains by gamepad."""

from __future__ import annotations

import typer

from hitab_cli import FirstAgent, carry_out, connection, demonstrator_of
from hitab_client import console
from hitab_client.terminal.cli_options import SwarmName


def register(app: typer.Typer) -> None:
    """Add `hitab joystick`."""
    app.command(rich_help_panel="Train")(joystick)


def joystick(
    agent: FirstAgent = "",
    mapping: str = "xbox",
    topic: str = "joy",
    swarm: SwarmName = None,
) -> None:
    """Train with a gamepad, and drive robots by hand with its sticks.

    A node such as joy_node publishes the state of the gamepad. Nothing but the emergency stop
    counts unless the dead-man's switch is held: with the shipped mappings the left shoulder button
    (LB). Letting it go, or losing the gamepad, stops a robot that is driven by hand.

    The mapping xbox is for joy_node with an Xbox gamepad, the mapping gamepad for
    game_controller_node with any. It runs until Ctrl-C, and prints what comes of each button.

    Args:
        mapping: What its buttons do: xbox, gamepad, or a file of your own.
        topic: Where its messages, sensor_msgs/Joy, come.

    Examples:
      hitab joystick robot_1
      hitab joystick robot_1 --mapping my_gamepad.yaml --topic /robot_1/joy
    """
    from hitab_gamepad.joystick import JoystickInput
    from hitab_gamepad.joystick_mapping import read_mapping

    read = read_mapping(mapping)
    with connection(swarm) as swarm_up:
        demonstrator = demonstrator_of(swarm_up, agent, asks=False)
        JoystickInput(swarm_up.link, demonstrator, read, topic)
        console.say(f"{demonstrator.agent} obeys the joystick on {topic} (mapping {mapping})")
        told = demonstrator.told

        def tick() -> None:
            nonlocal told
            if demonstrator.told == told:
                return
            told = demonstrator.told
            if demonstrator.said:
                (console.error if demonstrator.failed else console.say)(demonstrator.said)

        carry_out(swarm_up, demonstrator, tick, lambda: False)
