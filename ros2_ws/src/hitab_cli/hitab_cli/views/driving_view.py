"""View of `hitab drive`: the agent's status, the outcome of the last key, and the keys."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from hitab_client import console
from hitab_client.terminal.cli_remedies import as_command
from hitab_core import START, Fix, quantity

if TYPE_CHECKING:
    from hitab_msgs.msg import AgentStatus
    from rich.text import Text

    from hitab_client.demonstrating import Demonstrator

SHOWN_FAULTS_MAX = 3
SPACE = "Space"


def lines(
    demonstrator: Demonstrator, silent: Mapping[str, float], *, help_wanted: bool
) -> Iterator[Text]:
    """Yield the lines of the view.

    Args:
        demonstrator: the person.
        silent: time since the last sign of life of each silent agent, s, by name.
        help_wanted: whether to explain all keys.
    """
    status, agent = demonstrator.status, demonstrator.agent
    if status is None:
        yield console.line(f"{agent}  has not answered yet", "yellow")
    else:
        yield console.line(f"{agent}  {_doing(status, demonstrator.words.training)}", "bold")
        for fault in status.faults[:SHOWN_FAULTS_MAX]:
            yield console.line(f"  {fault}", "yellow")
    if agent in silent:
        logs = as_command(Fix.LOGS(node=agent))
        yield console.line(f"  it has been silent for {silent[agent]:.0f} s; {logs}", "yellow")
    if who := demonstrator.switch.known.who:
        yield console.line(f"EMERGENCY STOP by {who}: G releases the robots", "bold red")
    if any(demonstrator.steering.velocity):
        ahead, left, turn = demonstrator.steering.velocity
        yield console.line(
            f"driven by hand: {ahead:+.2f} m/s ahead, {left:+.2f} m/s to the left, "
            f"{turn:+.2f} rad/s",
            "cyan",
        )
    yield console.line(
        f"error: {demonstrator.said}" if demonstrator.failed else demonstrator.said or " ",
        "red" if demonstrator.failed else "green",
    )
    yield from _asking(demonstrator) if demonstrator.prompt is not None else _keys(demonstrator)
    if help_wanted:
        yield from _help()
    else:
        yield console.line(
            f"{SPACE} EMERGENCY STOP · arrows drive · ? all keys · Ctrl-C ends", "dim"
        )


def _doing(status: AgentStatus, training: str) -> str:
    path = " > ".join(status.active_path)
    if status.mode in (status.TRAINING, status.TESTING):
        trained = status.training
        examples = quantity(trained.examples, "example")
        asks = f", {quantity(trained.questions, 'question')}" if trained.questions else ""
        text = (
            f'{status.mode} "{status.behavior}": {examples} ({trained.default_examples} default)'
        )
        done = "performs nothing yet" if path in ("", START) else f"performs {path}"
        return f"{text}{asks}; {done}"
    done = path or status.behavior
    doing = f"{status.mode}: {done}" if done else str(status.mode)
    if not status.training.examples:
        return doing
    name = f' of "{training}"' if training else ""
    return (
        f"{doing}; the training{name} ({quantity(status.training.examples, 'example')}) is kept: "
        "t continues it"
    )


def _keys(demonstrator: Demonstrator) -> Iterator[Text]:
    words, status = demonstrator.words, demonstrator.status
    active = status.active_path[0] if status is not None and status.active_path else ""
    text = console.line("")
    for key, behavior in words.keys:
        text.append(f"{key} ", "bold")
        text.append(behavior, "reverse" if behavior == active else "")
        text.append("   ")
    yield text


def _asking(demonstrator: Demonstrator) -> Iterator[Text]:
    prompt = demonstrator.prompt
    assert prompt is not None
    if prompt.number is not None:
        yield console.line(
            f"{prompt.term}: {prompt.number}?  {prompt.typed}_   Enter, Esc none", "bold"
        )
        return
    parameter = prompt.term.arguments[prompt.place]
    numbered = enumerate(prompt.targets[:9], 1)
    targets = "   ".join(f"{number} {target}" for number, target in numbered)
    yield console.line(
        f"{prompt.term}: which target is {parameter}?  {targets}   Esc none", "bold"
    )


def _help() -> Iterator[Text]:
    from hitab_client.demonstrating import KEY_ACTIONS, keyboard

    yield console.line("digits, letters  command a behavior (in training), or have it performed")
    for key, action in keyboard.ACTION_KEYS.items():
        yield console.line(f"{SPACE if key == ' ' else key:<16} {KEY_ACTIONS[action]}")
    yield console.line("arrows           drive by hand while held; with Shift to the sides")
    yield console.line("?                hide this help")
    yield console.line("Ctrl-C           end; the agents go on")
