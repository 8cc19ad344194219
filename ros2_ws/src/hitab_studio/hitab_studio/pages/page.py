"""The state of a page in a browser."""

from __future__ import annotations

import asyncio
import json
import logging
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from hitab_client import Learned, SwarmError, Training, WorldClient
from hitab_client.attention import Item
from hitab_core.training.operation import Operation
from hitab_ros import names
from hitab_ros.answering import what_went_wrong
from hitab_ros.call import Turns
from hitab_studio.field.field_frame import EMPTY
from hitab_studio.field.scene import frame, roster, said_message
from hitab_studio.pages.looking_back import PageTime, look_back, to_present
from hitab_studio.pages.notices import Notices
from hitab_studio.pages.page_parts import (
    ExamplesTable,
    LostCommand,
    MissingTargets,
    ShownNumbers,
    TutorialProgress,
)
from hitab_studio.pages.person_names import distinct
from hitab_studio.pages.studio_state import StudioState
from hitab_studio.robots.robot_messages import NO_SCANS
from hitab_studio.swarm.absence import absence
from hitab_studio.swarm.agent_watch import AgentState
from hitab_studio.swarm.replay import ReplayPlayer
from hitab_studio.swarm.swarm_link import Connected
from hitab_studio.swarm.swarm_state import SwarmState

T = TypeVar("T")

NO_AGENT = AgentState()
RECORDING = "This is a recording: close it first (Esc) to act on the swarm."
CHOOSE_FIRST = "Choose an agent first, in the list or in the field."
REAL = "These are real robots: they cannot be paused, moved by dragging or reset."


class Page:
    """The state of one page in one browser.

    Attributes:
        studio: the state of all pages.
        browser: identity of the browser, shared by all pages of a person; initially the page's id.
        demonstrator: name of the person, which commands carry and the reaction time is kept under.
        name: the demonstrator's name, with a number if another person has the same name.
        chosen: names of the things selected in the field.
        agent: the viewed and commanded agent; "" if none.
        level: the viewed automaton; "" for the outermost one.
        state: the state whose tree is viewed; "" for the active one.
        to_start: the swarm chosen to be started; "" before a choice.
        folds: opened (true) and closed commanders in the list of agents, by name.
        shown_numbers: the behavior whose form of numbers is open; None if none.
        missing_targets: the commanded behavior that still needs targets; None if none.
        lost: the last command, if the agent has not answered it; None otherwise.
        item: the item that the person went to last; None if none.
        not_taken: behaviors of commands that were not taken, by agent, until the page can show it.
        dialog: the open dialog, with the values of its template; {} if none.
        player: the player of the open recording; None if none.
        time: the earlier moment that it shows, if any, and the person's choices about time.
        messages: notices of successes and failures.
        tutorial: progress in the tutorial.
        connected: whether the browser is connected.
        leave: closes the page after the current request.
        sent: the frame that the browser received last.
    """

    def __init__(self, studio: StudioState, key: str, demonstrator: str) -> None:
        self.studio = studio
        self.id = self.browser = key
        self.demonstrator = self.name = ""
        self.chosen: list[str] = []
        self.agent = ""
        self.tab = "teach"
        self.level = self.state = self.filter = self.behavior = self.to_start = ""
        self.folds: dict[str, bool] = {}
        self.missing_targets: MissingTargets | None = None
        self.shown_numbers: ShownNumbers | None = None
        self.lost: LostCommand | None = None
        self.item: Item | None = None
        self.not_taken: dict[str, str] = {}
        self.table = ExamplesTable()
        self.dialog: dict[str, Any] = {}
        self.compare: tuple[str, Learned] | None = None
        self.player: ReplayPlayer | None = None
        self.time = PageTime()
        self.connected = False
        self.leave: Callable[[], None] = lambda: None
        self.sent = b""
        self.messages = Notices()
        self.tutorial = TutorialProgress()
        self.version = self.busy = 0
        self.outgoing: deque[str] = deque(maxlen=50)
        self.news = asyncio.Event()
        self.set_demonstrator(demonstrator)

    def set_demonstrator(self, demonstrator: str) -> None:
        """Set the name of the person at the page."""
        if demonstrator != self.demonstrator:
            self.demonstrator = demonstrator
            self.assign_browser(self.browser)

    def assign_browser(self, browser: str) -> None:
        """Assign the page to a browser, whose pages hold agents together, under one name."""
        self.browser = browser
        others = {page.name for page in self.studio.pages.values() if not self.is_same(page)}
        self.name = distinct(self.demonstrator, others)
        self.studio.touch()

    def is_same(self, page: Page) -> bool:
        """Whether another page belongs to the same person."""
        return page.browser == self.browser

    # -- selection --------------------------------------------------------------------------

    @property
    def moment(self) -> SwarmState:
        """The shown state of the swarm: the present one, or a moment of the open recording."""
        return self.studio.known if self.player is None else self.player.state

    @property
    def status(self) -> Any:
        """The last status of the agent, in a replay that of the shown moment; None if unknown."""
        return self.moment.statuses.get(self.agent)

    @property
    def watched(self) -> AgentState:
        """The details of the viewed agent."""
        return self.studio.known.watched.get(self.agent, NO_AGENT)

    @property
    def training(self) -> Training | None:
        """The last published training of the viewed agent; None if not training."""
        return self.studio.link.training(self.agent)

    @property
    def agents(self) -> Sequence[str]:
        """The agents of the swarm, or of the open recording."""
        return self.moment.agents

    @property
    def is_training(self) -> bool:
        """Whether the agent is being trained or tested."""
        return self.status is not None and self.status.mode in ("training", "testing")

    def open_dialog(self, kind: str, **values: Any) -> None:
        """Open a dialog about the agent, with values for the dialog's template."""
        self.dialog = {"kind": kind, "agent": self.agent, **values}

    def close_dialog(self) -> None:
        """Close the dialog, if one is open."""
        if self.dialog.get("kind") in ("new", "features"):
            self.studio.link.probe(self.dialog["agent"], on=False)
        self.dialog = {}

    def look_at(self, agent: str) -> None:
        """View an agent; none if the name is empty."""
        if agent != self.agent:
            self.agent = agent
            self.level = self.state = self.behavior = ""
            self.missing_targets = self.shown_numbers = None
            self.compare = None
            self.table = ExamplesTable()
            if self.time.past is not None:
                look_back(self, self.time.past.at)
        self.touch()

    def choose(self, names: list[str]) -> None:
        """Select things in the field; the first agent among them is viewed."""
        self.chosen = names
        self.send({"t": "chosen", "names": names})
        self.touch()

    def forget_agents(self) -> None:
        """View no agent, after the swarm was replaced by another one."""
        self.close_dialog()
        to_present(self)
        self.lost = None
        self.folds.clear()
        self.look_at("")
        if self.player is None:
            self.choose([])

    # -- the shown field ------------------------------------------------------------------

    def frame(self) -> bytes:
        """Return the current frame of the swarm or of the open recording."""
        if self.time.past is not None:
            return self.time.past.frame
        if self.player is None:
            return self.studio.present.frame
        state = self.player.state
        assert state.scene is not None  # a recording has one at each moment
        return frame(state.scene, state.doing(), self.studio.palette)

    def layers(self) -> dict[str, bytes]:
        """Return the layers of real robots that are shown; {} in a replay or a simulated world."""
        robots = self.studio.known.robots
        if robots is None or self.player is not None:
            return {}
        if self.time.past is not None:  # scans and pictures are not remembered
            return {"scans": NO_SCANS} | {k: d for k, d in robots.layers.items() if k == "map"}
        shown = ("map", "scans", f"camera {self.agent}")
        return {name: data for name, data in robots.layers.items() if name in shown}

    def show_again(self) -> None:
        """Send the present moment of the open recording, or else of the swarm, once more."""
        self.sent = b""
        self.send({"t": "replay", "on": self.player is not None})
        if self.player is not None:
            self.show_moment()
        else:
            past = self.time.past
            self.outgoing.append(past.roster if past else self.studio.present.roster or EMPTY)
        self.news.set()

    def show_moment(self) -> None:
        """Show the current moment of the open recording."""
        scene = self.moment.scene
        if self.player is None or scene is None:
            return
        self.outgoing.append(roster(scene, self.studio.palette))
        if scene.said:
            self.outgoing.append(said_message(scene))
        self.news.set()
        self.touch()

    def stop_replay(self, error: Exception) -> None:
        """Close a recording that cannot be shown, with a message that gives the reason."""
        logging.getLogger(__name__).error("a recording", exc_info=error)
        self.player = None
        self.tell(f"This recording cannot be shown further: {what_went_wrong(error)}", "bad")
        self.show_again()

    # -- doing ------------------------------------------------------------------------------

    async def ask(self, what: Callable[[Connected], Turns[T]], needs: str = "") -> T:
        """Send a request to the swarm; the page is marked busy until the answer.

        Args:
            what: returns the coroutine of the request.
            needs: the agent or `names.WORLD` that answers; "" if none.

        Raises:
            SwarmError: if the request fails.
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
        """Reason for which requests to the world are refused; "" if allowed."""
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
        """Reason for which requests to the agent are refused; "" if allowed."""
        if self.player is not None:
            return RECORDING
        if not self.agent:
            return CHOOSE_FIRST
        if absent := absence(self.studio.known, self.agent):
            return f"{self.agent} {absent.what}."
        return self.held_by_others(self.agent) or self.studio.why_busy

    async def ask_world(self, what: Callable[[WorldClient], Turns[T]]) -> T:
        """Send a request to the world.

        Raises:
            SwarmError: if the world does not answer, or refuses.
        """
        if self.world_off:
            raise SwarmError(self.world_off)
        return await self.ask(lambda swarm: what(swarm.world), names.WORLD)

    async def ask_agent(self, what: Callable[[Connected, str], Turns[T]]) -> T:
        """Send a request to the agent, which this page holds from then on.

        Raises:
            SwarmError: as `take_agent`, or if the request fails.
        """
        agent = self.take_agent()
        return await self.ask(lambda swarm: what(swarm, agent), agent)

    def take_agent(self) -> str:
        """Hold the viewed agent for a request; return its name.

        Raises:
            SwarmError: if no agent is viewed, the agent does not answer, another demonstrator
                holds the agent, or a command before was not taken, which the person had not seen.
        """
        if self.agent_off:
            raise SwarmError(self.agent_off)
        if behavior := self.not_taken.get(self.agent):
            # An undo, for example, was meant for that command, not for the one before.
            raise SwarmError(f"Left out what was pressed after {behavior}, which was not taken.")
        self.hold(self.agent)
        return self.agent

    async def do(self, operation: Operation) -> Any:
        """Have the agent carry out an operation of the page's demonstrator; see `ask_agent`."""
        named = replace(operation, by=self.demonstrator)
        return await self.ask_agent(lambda swarm, agent: swarm.agents.do.coroutine(agent, named))

    def hold(self, agent: str) -> None:
        """Hold an agent, or keep holding it.

        Raises:
            SwarmError: if another demonstrator holds the agent.
        """
        if why := self.held_by_others(agent):
            raise SwarmError(why)
        self.studio.held.setdefault(agent, self)

    def held_by_others(self, agent: str) -> str:
        """Return why this page may not command an agent; "" unless another person holds it."""
        holder = self.studio.held.get(agent, self)
        if self.is_same(holder):
            return ""
        return f"{agent} is being trained by {holder.name}; press Take over this agent first"

    # -- telling ----------------------------------------------------------------------------

    def touch(self) -> None:
        """Have the page redrawn."""
        self.version += 1

    def tell(self, text: str, kind: str = "good") -> None:
        """Show a short message."""
        self.messages.say(text, kind)
        self.touch()

    def refuse(self, why: str, kind: str = "bad") -> None:
        """Show the reason for a refusal: in the open dialog, or else as a message."""
        if self.dialog:
            self.dialog["refused"] = why
        else:
            self.tell(why, kind)

    def send(self, message: dict[str, Any]) -> None:
        """Send a message to the field."""
        self.outgoing.append(json.dumps(message))
        self.news.set()
