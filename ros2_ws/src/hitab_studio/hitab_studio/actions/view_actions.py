"""Actions that select, filter, and open and close parts of the page."""

from __future__ import annotations

from hitab_studio.actions.registry import Data, action
from hitab_studio.actions.teaching_actions import discard, give_target, targets_meant
from hitab_studio.actions.time_actions import thaw
from hitab_studio.pages.looking_back import is_frozen, to_present
from hitab_studio.pages.page import Page

REASON_LENGTH_MAX = 300
"""Maximum length of a shown reason, characters."""

DIALOGS = frozenset(
    {"help", "name", "stop", "caution", "distribute"}
    | {f"{verb}-{what}" for verb in ("rename", "delete") for what in ("recording", "behavior")}
)
"""Kinds of dialogs opened by `ask`."""


@action("choose", repeats=True)
async def choose(page: Page, data: Data) -> None:
    """Select a thing in the field: an agent to view, or a missing target."""
    name = str(data["name"])
    if page.missing_targets is not None:
        meant = targets_meant(page, name)
        if len(meant) == 1:
            await give_target(page, meant[0])
        elif meant:
            page.tell(f"{name} may be {' or '.join(meant)}: choose below", "note")
        else:
            page.tell(f"{name} is not a target that {page.agent} knows", "bad")
        return
    if data.get("more"):
        names = [n for n in page.chosen if n != name]
        names += [] if name in page.chosen else [name]
        page.choose(names)
    else:
        page.choose([name])
    if name in page.agents:
        page.look_at(name)


@action("agent", repeats=True)
async def agent(page: Page, data: Data) -> None:
    """View an agent in the list."""
    name = str(data["name"])
    page.choose([name])
    page.look_at(name)


@action("neighbor", repeats=True)
async def neighbor(page: Page, data: Data) -> None:
    """View the next or the previous agent in the list."""
    agents = page.agents
    if agents:
        step = int(data["step"])
        here = agents.index(page.agent) if page.agent in agents else (-1 if step > 0 else 0)
        await agent(page, {"name": agents[(here + step) % len(agents)]})


@action("deselect", repeats=True)
async def deselect(page: Page, data: Data) -> None:
    """Deselect all things in the field except the viewed agent."""
    if page.missing_targets is None:
        page.choose([page.agent] if page.agent else [])


@action("filter", repeats=True)
async def filter_agents(page: Page, data: Data) -> None:
    """Show only agents whose names or states contain a text."""
    page.filter = str(data["value"])


@action("fold", repeats=True)
async def fold(page: Page, data: Data) -> None:
    """Fold or unfold a commander in the list of agents."""
    page.folds[str(data["name"])] = data.get("open") == "yes"


@action("tab", repeats=True)
async def tab(page: Page, data: Data) -> None:
    """Show a tab."""
    page.tab = str(data["name"])


@action("level", repeats=True)
async def level(page: Page, data: Data) -> None:
    """View an automaton of the hierarchy."""
    page.level, page.state = str(data.get("name", "")), ""


@action("state")
async def state(page: Page, data: Data) -> None:
    """View the tree of a state, or of the active state if the former is already shown."""
    name = str(data.get("name", ""))
    page.state = "" if page.state == name else name


@action("ask")
async def ask(page: Page, data: Data) -> None:
    """Open one of `DIALOGS`, which need nothing but a name."""
    kind, name = str(data["kind"]), str(data.get("name", ""))
    if kind in DIALOGS:
        page.open_dialog(kind, name=name)


@action("close", repeats=True)
async def close(page: Page, data: Data) -> None:
    """Close the dialog."""
    page.close_dialog()


@action("message-close", repeats=True)
async def message_close(page: Page, data: Data) -> None:
    """Close a message."""
    page.messages.close(int(data["number"]))


@action("why", repeats=True)
async def why(page: Page, data: Data) -> None:
    """Show the reason for which a button is unavailable."""
    page.refuse(str(data["reason"])[:REASON_LENGTH_MAX], "note")


@action("escape", repeats=True)
async def escape(page: Page, data: Data) -> None:
    """Close the frontmost part of the page."""
    if page.dialog:
        page.close_dialog()
    elif page.missing_targets is not None:
        page.missing_targets = None
    elif page.shown_numbers is not None:
        page.shown_numbers = None
    elif page.time.past is not None:
        to_present(page)
    elif is_frozen(page):
        await thaw(page)
    elif page.player is not None:
        page.player = None
        page.show_again()
    elif page.lost is not None:
        page.lost = None
    elif page.table.marked:
        page.table.marked.clear()
    elif page.is_training and not page.agent_off:
        await discard(page, data)
