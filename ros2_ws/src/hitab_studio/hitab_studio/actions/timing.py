"""For when commands count: the person's reaction time, and commands that were due earlier."""

from __future__ import annotations

from hitab_client import SwarmError, reaction_time
from hitab_client.demonstrating import put_earlier
from hitab_studio.actions.registry import Data, action
from hitab_studio.people import LONGEST_NAME, checked
from hitab_studio.session import Session
from hitab_studio.swarm_link import Connected


@action("reaction-who", repeats=True)
async def reaction_who(session: Session, data: Data) -> None:
    """Show the reaction time that is kept for a name."""
    if session.dialog.get("kind") == "reaction":
        session.dialog["demonstrator"] = str(data["value"]).strip()[:LONGEST_NAME]


def _become(session: Session, values: Data) -> None:
    """Have the page be used by whom its person says; the browser keeps the name."""
    session.become(checked(str(values.get("demonstrator", ""))))
    session.send({"t": "demonstrator", "name": session.demonstrator})


@action("reaction-set")
async def reaction_set(session: Session, data: Data) -> None:
    """Keep a reaction time."""
    values = data["values"]
    text = str(values.get("seconds", "")).strip()
    try:
        seconds = reaction_time.check(float(text)) if text else None
    except ValueError:
        raise SwarmError(f'"{text}" is not a number of seconds, such as 0.3.') from None
    _become(session, values)
    reaction_time.keep(session.demonstrator, seconds)
    session.close_dialog()
    session.tell(_told(seconds or 0.0))


@action("reaction-game")
async def reaction_game(session: Session, data: Data) -> None:
    """Begin the game that measures the reaction time; the page plays it."""
    _become(session, data["values"])
    session.close_dialog()
    session.send(
        {
            "t": "reaction-game",
            "rounds": reaction_time.ROUNDS,
            "longest": reaction_time.LONGEST,
        }
    )


@action("reaction-measured")
async def reaction_measured(session: Session, data: Data) -> None:
    """Keep the reaction time that the game has measured."""
    seconds = reaction_time.check(round(float(data["seconds"]), 2))
    reaction_time.keep(session.demonstrator, seconds)
    session.tell(f"Measured {seconds:g} s: {_told(seconds)}")


def _told(seconds: float) -> str:
    if seconds:
        return (
            f"from now on your commands count for what the field showed {seconds:g} s before you "
            "pressed the key"
        )
    return "from now on your commands count for what the field shows when you press the key"


@action("earlier", repeats=True)
async def due_earlier(session: Session, data: Data) -> None:
    """Have the last command be due a little earlier than it is at present."""
    session.unseen.check(session.agent, "earlier")

    def job(swarm: Connected, agent: str) -> str:
        return put_earlier(swarm.agents, swarm.world, agent)

    session.tell(await session.ask_agent(job))


@action("retime", repeats=True)
async def retime(session: Session, data: Data) -> None:
    """Have a command be due at another time before it was given."""
    number, text = int(data["number"]), str(data["value"]).strip()
    try:
        ago = float(text)
    except ValueError:
        raise SwarmError(f'"{text}" is not a number of seconds, such as 0.3.') from None

    def job(swarm: Connected, agent: str) -> float:
        swarm.agents.retime(agent, [number], ago)
        examples = swarm.agents.training(agent).examples
        return next((e.ago for e in examples if e.number == number), ago)  # that of a cycle

    session.tell(f"Example {number}: {await session.ask_agent(job):.2f} s ago")
