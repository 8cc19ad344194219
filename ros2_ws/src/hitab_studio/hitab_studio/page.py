"""The state of a page in a browser."""

from __future__ import annotations

import asyncio
import json
import logging
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from hitab_client import Learned, SwarmError, Training, WorldClient
from hitab_client.demonstrating import UnseenOutcomes, behavior_keys
from hitab_ros import names
from hitab_ros.answering import what_went_wrong
from hitab_ros.call import Turns, blocking
from hitab_studio.absence import absence
from hitab_studio.agent_watch import AgentState
from hitab_studio.field_frame import EMPTY, FieldFrame
from hitab_studio.launching import NONE, Launcher
from hitab_studio.notices import Notices
from hitab_studio.page_parts import ExamplesTable, Making, MissingTargets, ShownNumbers
from hitab_studio.people import told_apart
from hitab_studio.replay import ReplayPlayer
from hitab_studio.scene import Palette, frame, roster, said_message
from hitab_studio.swarm_link import Connected, SwarmLink
from hitab_studio.swarm_state import SwarmState
from hitab_studio.unanswered_command import UnansweredCommand

T = TypeVar("T")

NO_AGENT = AgentState()
RECORDING = "This is a recording: close it first (Esc) to act on the swarm."
CHOOSE_FIRST = "Choose an agent first, in the list or in the field."
REAL = "These are real robots: they cannot be paused, put elsewhere or set back."


class StudioState:
    """The state that all pages share.

    Attributes:
        link: to the swarm.
        known: the state of the swarm.
        version: raised with each change that pages show.
        palette: the colors of states.
        placements: where things were before they were placed, newest last, for undo.
        snapshots: names of the world's snapshots.
        held: by agent, the page that holds it: no other page may command it.
        pages: those that are open, by their ids.
        keys: which key commands which behavior.
        present: the field as it is now.
        launcher: starts and stops swarms.
        making: the generation that is being made, or was made last.
    """

    def __init__(self, link: SwarmLink, startable: Mapping[str, str] = NONE) -> None:
        self.link = link
        self.known, self.version = SwarmState(), 0
        self.palette = Palette()
        self.placements: list[dict[str, dict[str, float]]] = []
        self.snapshots: tuple[str, ...] = ()
        self.held: dict[str, Page] = {}
        self.pages: dict[str, Page] = {}
        link.colors, link.pages = self.palette.given, self.pages
        self.keys = behavior_keys.Keys(behavior_keys.file())
        self.present = FieldFrame(self.palette)
        self.launcher = Launcher(startable, self.touch)
        self.making: Making | None = None

    @property
    def why_busy(self) -> str:
        """Why nothing else is to be done with the swarm at present; "" if it may be."""
        made = self.making
        if made is None or not made.doing:
            return ""
        return f"{made.agent} makes a generation of {made.behavior}: wait for that, or stop it."

    def touch(self) -> None:
        """Say that something has changed."""
        self.version += 1


class Page:
    """The state of one page in one browser.

    Attributes:
        studio: the state of all pages.
        browser: identity of the browser, whose pages are the same person's; at first the page's.
        demonstrator: name of the person who commands; the reaction time is kept under it.
        name: the same, told apart from people of this name at other pages.
        chosen: names of the things selected in the field.
        agent: the one among them, or in the list, that is viewed and commanded.
        level: the viewed automaton, if not the outermost one.
        state: the state whose tree is viewed, if not the active one.
        to_start: the swarm that is chosen to be started; empty if none was chosen yet.
        folds: opened (true) and closed commanders in the list of agents, by name.
        shown_numbers: the behavior whose form of numbers is open, if one is.
        missing_targets: the commanded behavior that still needs targets, if one does.
        lost: the last command, if the agent has not acknowledged it.
        unseen: outcomes of commands that the page has not shown yet.
        dialog: the open dialog, with the values of its template.
        player: the open recording, if there is one.
        messages: notices of successes and failures.
        connected: whether the browser is connected.
        leave: closes the page after the present request.
        sent: the browser's present frame.
    """

    def __init__(self, studio: StudioState, key: str, demonstrator: str) -> None:
        self.studio = studio
        self.id = self.browser = key
        self.demonstrator = self.name = ""
        self.chosen: list[str] = []
        self.agent = ""
        self.tab = "teach"
        self.level = ""
        self.state = ""
        self.filter = ""
        self.to_start = ""
        self.folds: dict[str, bool] = {}
        self.missing_targets: MissingTargets | None = None
        self.shown_numbers: ShownNumbers | None = None
        self.lost: UnansweredCommand | None = None
        self.unseen = UnseenOutcomes()
        self.table = ExamplesTable()
        self.dialog: dict[str, Any] = {}
        self.behavior = ""
        self.compare: tuple[str, Learned] | None = None
        self.player: ReplayPlayer | None = None
        self.connected = False
        self.leave: Callable[[], None] = lambda: None
        self.sent = b""
        self.messages = Notices()
        self.version = 0
        self.busy = 0
        self.outgoing: deque[str] = deque(maxlen=50)
        self.news = asyncio.Event()
        self.become(demonstrator)

    def become(self, demonstrator: str) -> None:
        """Be used by the person of this name."""
        if demonstrator != self.demonstrator:
            self.demonstrator = demonstrator
            self.belong(self.browser)

    def belong(self, browser: str) -> None:
        """Be a page of this browser; its pages hold agents together, under one name."""
        self.browser = browser
        others = {page.name for page in self.studio.pages.values() if not self.is_same(page)}
        self.name = told_apart(self.demonstrator, others)
        self.studio.touch()

    def is_same(self, page: Page) -> bool:
        """Whether another page is the same person's."""
        return page.browser == self.browser

    # -- selection --------------------------------------------------------------------------

    @property
    def moment(self) -> SwarmState:
        """What is shown of the swarm: its state now, or at the moment of a recording."""
        return self.studio.known if self.player is None else self.player.state

    @property
    def status(self) -> Any:
        """The last status of the agent; in a replay, of that moment."""
        return self.moment.statuses.get(self.agent)

    @property
    def watched(self) -> AgentState:
        """The details of the viewed agent."""
        return self.studio.known.watched.get(self.agent, NO_AGENT)

    @property
    def training(self) -> Training | None:
        """The viewed agent's training, as published last."""
        return self.studio.link.training(self.agent)

    @property
    def agents(self) -> Sequence[str]:
        """The page's agents: of the swarm, or of a recording."""
        return self.moment.agents

    @property
    def is_training(self) -> bool:
        """Whether the agent is being trained or tested."""
        return self.status is not None and self.status.mode in ("training", "testing")

    @property
    def locked(self) -> bool:
        """Whether another demonstrator holds the agent."""
        return bool(self._held_by_others(self.agent))

    def open_dialog(self, kind: str, **values: Any) -> None:
        """Open a dialog about the agent, with the values of its template."""
        self.dialog = {"kind": kind, "agent": self.agent, **values}

    def close_dialog(self) -> None:
        """Close the dialog, if one is open."""
        if self.dialog.get("kind") in ("new", "features"):
            self.studio.link.probe(self.dialog["agent"], on=False)
        self.dialog = {}

    def look_at(self, agent: str) -> None:
        """View an agent; none if empty."""
        if agent != self.agent:
            self.agent = agent
            self.level = self.state = self.behavior = ""
            self.missing_targets = self.shown_numbers = None
            self.compare = None
            self.table = ExamplesTable()
        self.touch()

    def choose(self, names: list[str]) -> None:
        """Select things in the field; the first agent among them is viewed."""
        self.chosen = names
        self.send({"t": "chosen", "names": names})
        self.touch()

    def forget_agents(self) -> None:
        """View nothing: the agents were of another swarm."""
        self.close_dialog()
        self.lost = None
        self.folds.clear()
        self.look_at("")
        if self.player is None:
            self.choose([])

    # -- what the field shows ---------------------------------------------------------------

    def frame(self) -> bytes:
        """Return the frame that the page should show now."""
        if self.player is None:
            return self.studio.present.frame
        state = self.player.state
        assert state.scene is not None  # a recording has one at each moment
        return frame(state.scene, state.doing(), self.studio.palette)

    def layers(self) -> dict[str, bytes]:
        """Return the layers of real robots that the page should show now."""
        robots = self.studio.known.robots
        if robots is None or self.player is not None:
            return {}
        shown = ("map", "scans", f"camera {self.agent}")
        return {name: data for name, data in robots.layers.items() if name in shown}

    def show_again(self) -> None:
        """Show the present moment: of the recording that is open, else of the swarm.

        It is sent even if the page had it before: the page may show something else by now.
        """
        self.sent = b""
        self.send({"t": "replay", "on": self.player is not None})
        if self.player is not None:
            self.show_moment()
        else:
            self.outgoing.append(self.studio.present.roster or EMPTY)
        self.news.set()

    def show_moment(self) -> None:
        """Show the moment of the recording at which the page is."""
        scene = self.moment.scene
        if self.player is None or scene is None:
            return
        self.outgoing.append(roster(scene, self.studio.palette))
        if scene.said:
            self.outgoing.append(said_message(scene))
        self.news.set()
        self.touch()

    def stop_replay(self, error: Exception) -> None:
        """Close a recording that cannot be shown, and say why."""
        logging.getLogger(__name__).error("a recording", exc_info=error)
        self.player = None
        self.tell(f"This recording cannot be shown further: {what_went_wrong(error)}", "bad")
        self.show_again()

    # -- doing ------------------------------------------------------------------------------

    async def ask(self, what: Callable[[Connected], Turns[T]], needs: str = "") -> T:
        """Ask something of the swarm; the page is marked busy until the end.

        Args:
            what: returns the coroutine that asks.
            needs: an agent or the world without which it cannot be done.

        Raises:
            SwarmError: if it cannot be done.
        """
        if self.player is not None:
            raise SwarmError(RECORDING)
        self.busy += 1
        try:
            return await self.studio.link.ask(what, needs)
        finally:
            self.busy -= 1
            self.touch()

    @property
    def world_off(self) -> str:
        """Why nothing may be asked of the world; "" if it may be."""
        known = self.studio.known
        if self.player is not None:
            return RECORDING
        if known.robots is not None:
            return REAL
        if known.world and (absent := absence(known, names.WORLD)):
            return f"The world {absent.what}."
        return self.studio.why_busy

    @property
    def agent_off(self) -> str:
        """Why nothing may be asked of the agent; "" if it may be."""
        if self.player is not None:
            return RECORDING
        if not self.agent:
            return CHOOSE_FIRST
        if absent := absence(self.studio.known, self.agent):
            return f"{self.agent} {absent.what}."
        return self._held_by_others(self.agent) or self.studio.why_busy

    async def ask_world(self, what: Callable[[WorldClient], Turns[T]]) -> T:
        """Ask something of the world.

        Raises:
            SwarmError: if it does not answer, or refuses.
        """
        if self.world_off:
            raise SwarmError(self.world_off)
        return await self.ask(lambda swarm: what(swarm.world), names.WORLD)

    async def ask_agent(self, what: Callable[[Connected, str], Turns[T]]) -> T:
        """Ask something of the agent, which this page holds from then on.

        Raises:
            SwarmError: if there is none, it does not answer, or another demonstrator holds it.
        """
        agent = self.take_agent()
        return await self.ask(lambda swarm: what(swarm, agent), agent)

    def take_agent(self) -> str:
        """Hold the agent, to ask something of it; return its name.

        Raises:
            SwarmError: if there is none, it does not answer, or another demonstrator holds it.
        """
        if self.agent_off:
            raise SwarmError(self.agent_off)
        self.hold(self.agent)
        return self.agent

    async def request(self, verb: blocking[Any, ..., T], *given: Any, **fields: Any) -> T:
        """Have a verb of the swarm's client done with the agent; see `ask_agent`."""
        return await self.ask_agent(
            lambda swarm, agent: verb.coroutine(swarm.agents, agent, *given, **fields)
        )

    def hold(self, agent: str) -> None:
        """Hold an agent, or keep holding it.

        Raises:
            SwarmError: if another demonstrator holds it.
        """
        if why := self._held_by_others(agent):
            raise SwarmError(why)
        self.studio.held.setdefault(agent, self)

    def _held_by_others(self, agent: str) -> str:
        holder = self.studio.held.get(agent, self)
        if self.is_same(holder):
            return ""
        return f"{agent} is being trained by {holder.name}; press Take over this agent first"

    # -- telling ----------------------------------------------------------------------------

    def touch(self) -> None:
        """Say that what the page shows has changed."""
        self.version += 1

    def tell(self, text: str, kind: str = "good") -> None:
        """Show a short message."""
        self.messages.say(text, kind)
        self.touch()

    def refuse(self, why: str, kind: str = "bad") -> None:
        """Say why something was not done: in the dialog that asks for it, else as a message."""
        if self.dialog:
            self.dialog["refused"] = why
        else:
            self.tell(why, kind)

    def settle(self) -> None:
        """Withdraw the offer to send a lost command again once the agent has taken it."""
        lost = self.lost
        if lost is not None and lost.is_taken(self.studio.known):
            self.lost = None
            self.tell(f"{lost.agent} has taken {lost.behavior} after all")

    def drop_old_messages(self) -> None:
        """Remove expired messages."""
        if self.messages.drop_old():
            self.touch()

    def send(self, message: dict[str, Any]) -> None:
        """Send a message to the field."""
        self.outgoing.append(json.dumps(message))
        self.news.set()
