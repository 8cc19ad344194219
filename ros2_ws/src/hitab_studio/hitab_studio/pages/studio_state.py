"""The state that all pages share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hitab_client.demonstrating import behavior_keys
from hitab_studio.field.field_frame import FieldFrame
from hitab_studio.field.scene import Palette
from hitab_studio.pages.page_parts import Making
from hitab_studio.swarm.launcher import NONE, Launcher
from hitab_studio.swarm.swarm_link import SwarmLink
from hitab_studio.swarm.swarm_state import SwarmState

Page = Any
"""A page, whose module imports this one."""


class StudioState:
    """The state that all pages share.

    Attributes:
        link: the connection to the swarm.
        known: the state of the swarm.
        version: raised with each change that pages show.
        palette: the colors of states.
        placements: positions of all things before each placement, newest last, for undo.
        snapshots: names of the world's snapshots.
        held: the page that holds an agent, by agent; other pages may not command this agent.
        pages: the open pages, by id.
        keys: the keys that command behaviors.
        present: the present field, encoded for pages.
        launcher: starts and stops swarms.
        making: the generation being made, or made last; None before the first.
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
        """Reason for refusing other requests to the swarm at present; "" if none."""
        made = self.making
        if made is None or not made.doing:
            return ""
        return f"{made.agent} is making a generation of {made.behavior}: wait for it, or stop it."

    def touch(self) -> None:
        """Have all pages redrawn."""
        self.version += 1
