"""Selecting what to view."""

from __future__ import annotations

from hitab_studio import unavailable
from hitab_studio.actions.registry import Data, action
from hitab_studio.actions.teaching import discard, give_target, targets_meant
from hitab_studio.page_state import PageState

MOST_REASON = 300
"""Characters."""

DIALOGS = frozenset(
    {"help", "name", "stop", "caution", "distribute"}
    | {f"{verb}-{what}" for verb in ("rename", "delete") for what in ("recording", "behavior")}
)
"""Dialogs that `ask` opens."""


@action("choose", repeats=True)
async def choose(session: PageState, data: Data) -> None:
    """Select something in the field: an agent to view, or a requested target."""
    name = str(data["name"])
    if session.missing_targets is not None:
        meant = targets_meant(session, name)
        if len(meant) == 1:
            await give_target(session, meant[0])
        elif meant:
            session.tell(f"{name} may be {' or '.join(meant)}: choose below", "note")
        else:
            session.tell(f"{name} is not a target that {session.agent} knows", "bad")
        return
    if data.get("more"):
        names = [n for n in session.chosen if n != name]
        names += [] if name in session.chosen else [name]
        session.choose(names)
    else:
        session.choose([name])
    if name in session.agents:
        session.look_at(name)


@action("agent", repeats=True)
async def agent(session: PageState, data: Data) -> None:
    """View an agent of the list."""
    name = str(data["name"])
    session.choose([name])
    session.look_at(name)


@action("neighbor", repeats=True)
async def neighbor(session: PageState, data: Data) -> None:
    """View the next or the previous agent of the list."""
    agents = session.agents
    if agents:
        step = int(data["step"])
        here = agents.index(session.agent) if session.agent in agents else (-1 if step > 0 else 0)
        await agent(session, {"name": agents[(here + step) % len(agents)]})


@action("deselect", repeats=True)
async def deselect(session: PageState, data: Data) -> None:
    """Deselect everything in the field; the viewed agent stays."""
    if session.missing_targets is None:
        session.choose([session.agent] if session.agent else [])


@action("filter", repeats=True)
async def filter_agents(session: PageState, data: Data) -> None:
    """Show agents with this in their names."""
    session.filter = str(data["value"])


@action("fold", repeats=True)
async def fold(session: PageState, data: Data) -> None:
    """Open or close what is below a commander or a title in the list of agents."""
    session.folds[str(data["name"])] = data.get("open") == "yes"


@action("tab", repeats=True)
async def tab(session: PageState, data: Data) -> None:
    """Show a tab."""
    session.tab = str(data["name"])


@action("level", repeats=True)
async def level(session: PageState, data: Data) -> None:
    """View an automaton of the hierarchy."""
    session.level, session.state = str(data.get("name", "")), ""


@action("state")
async def state(session: PageState, data: Data) -> None:
    """View the tree of a state; if it is shown already, that of the active one."""
    name = str(data.get("name", ""))
    session.state = "" if session.state == name else name


@action("ask")
async def ask(session: PageState, data: Data) -> None:
    """Open a dialog that needs no more than a name."""
    kind, name = str(data["kind"]), str(data.get("name", ""))
    if kind in DIALOGS:
        session.dialog = {"kind": kind, "agent": session.agent, "name": name}


@action("close", repeats=True)
async def close(session: PageState, data: Data) -> None:
    """Close the dialog."""
    session.close_dialog()


@action("message-close", repeats=True)
async def message_close(session: PageState, data: Data) -> None:
    """Close a message."""
    session.messages.close(int(data["number"]))


@action("why", repeats=True)
async def why(session: PageState, data: Data) -> None:
    """Say why something does nothing at present."""
    session.refuse(str(data["reason"])[:MOST_REASON], "note")


@action("escape", repeats=True)
async def escape(session: PageState, data: Data) -> None:
    """Close whatever is in front."""
    if session.dialog:
        session.close_dialog()
    elif session.missing_targets is not None:
        session.missing_targets = None
    elif session.shown_numbers is not None:
        session.shown_numbers = None
    elif session.player is not None:
        session.player = None
        session.show_again()
    elif session.lost is not None:
        session.lost = None
    elif session.table.marked:
        session.table.marked.clear()
    elif session.is_training and not unavailable.agent(session):
        await discard(session, data)
