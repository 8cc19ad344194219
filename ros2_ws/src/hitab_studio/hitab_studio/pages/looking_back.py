"""Looking back: the moment of the last minute that a page shows, and commands for it."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hitab_msgs.msg import WorldState

from hitab_client import SwarmError
from hitab_core import PAST_SECONDS
from hitab_ros.answering import what_went_wrong
from hitab_ros.timing import HEARTBEAT_S
from hitab_studio.field.last_minute import Glimpse, glimpse_at, marks, preview_in
from hitab_studio.field.scene import frame, roster

Page = Any
"""A page, whose module imports this one."""

PAUSED = WorldState.PAUSED

ROWS_MAX = 8
"""Maximum number of agents on the strip."""

Readings = Mapping[tuple[str, str], tuple[float, ...]]
SURE = 0.75
"""Probability from which on a preview counts as full."""


@dataclass
class PastMoment:
    """An earlier moment that a page shows instead of the present.

    Attributes:
        at: the moment, see `RememberedMinute`.
        frame, roster: the field then, encoded.
        agent: the agent that was asked for its percept then; "" if none.
        cycle: the cycle of the agent then.
        path: active states of the agent then.
        readings: its features then, by automaton and feature.
        preview: what it would have done; None until it has answered.
        why: why the agent cannot tell; "" if it can.
        asking: the request to the agent.
    """

    at: float
    frame: bytes
    roster: str
    agent: str = ""
    cycle: int = 0
    path: Sequence[str] = ()
    readings: Readings = field(default_factory=dict)
    preview: Any = None
    why: str = ""
    asking: asyncio.Task[None] | None = None


class PageTime:
    """What a page shows of the time, and what the person has chosen about it.

    Attributes:
        past: the moment that is shown; None for the present.
        freezes: whether the first key of a behavior pauses the world, and the second one chooses.
        frozen: the world's cycle in which the first one was pressed; None if it was not.
    """

    def __init__(self) -> None:
        self.past: PastMoment | None = None
        self.freezes = False
        self.frozen: int | None = None
        self._sent: tuple[Any, ...] = ()
        self._next_strip = 0.0

    def new_strip(self, page: Page) -> str:
        """Return the message with the strip; "" if nothing has changed or it was sent just now."""
        names = rows_shown(page)
        begin, now, rate, lines = _lines(page, names)
        left = begin if page.player is not None else now - PAST_SECONDS * rate
        shown = previews(page, names)
        at = page.player.at if page.player is not None else self.past.at if self.past else None
        key = (at, *names, *(line[-1] if line else None for line in lines), json.dumps(shown))
        is_due = time.monotonic() >= self._next_strip
        if (key, now) == self._sent or (self._sent and key == self._sent[0] and not is_due):
            return ""
        self._sent, self._next_strip = (key, now), time.monotonic() + HEARTBEAT_S
        color = page.studio.palette.index
        rows = [
            {
                "name": name,
                "spans": [
                    [max(g.at, begin), color(g.state), bool(g.unsure), " → ".join(g.path)]
                    for g in line
                ],
                "marks": [[*mark] for mark in marks(line) if mark.at >= begin],
            }
            for name, line in zip(names, lines, strict=True)
        ]
        episodes = () if page.player is not None else page.studio.link.minute.episodes
        return json.dumps(
            {"t": "minute", "left": left, "right": left + PAST_SECONDS * rate, "now": now}
            | {"rate": rate, "past": at, "rows": rows, "previews": shown}
            | {"cycles": page.player is None and page.studio.known.robots is None}
            | {"episodes": [e for e in episodes if e > begin]}
        )


def _lines(page: Page, names: Sequence[str]) -> tuple[float, float, float, list[list[Glimpse]]]:
    """Return begin, end and rate of the strip, and the agents' glimpses in it."""
    if page.player is not None:
        recording, at = page.player.recording, page.player.at
        begin = at - at % PAST_SECONDS
        end = min(begin + PAST_SECONDS, recording.seconds)
        return begin, end, 1.0, [recording.glimpses(name, begin, end) for name in names]
    minute = page.studio.link.minute
    begin, lines = minute.begin, [list(minute.glimpses(name)) for name in names]
    for line in lines:  # the one before the beginning still holds there
        del line[: max(0, sum(g.at <= begin for g in line) - 1)]
    return begin, minute.now, minute.rate, lines


def rows_shown(page: Page) -> list[str]:
    """Return the agents on the strip: the viewed one, then the chosen ones, then others.

    Of many agents, the others are those to which something happened last.
    """
    agents = page.agents
    others = agents if len(agents) <= ROWS_MAX else [*reversed(page.studio.link.minute.eventful)]
    wanted = dict.fromkeys([page.agent, *page.chosen[:ROWS_MAX], *others])
    rows = [name for name in wanted if name in page.moment.statuses][:ROWS_MAX]
    return sorted(rows, key=list(agents).index) if others is agents else rows


def preview_of(page: Page) -> Any:
    """Return the `Preview` of the viewed agent at the shown moment; None if unknown."""
    past = page.time.past
    if past is not None:
        return past.preview
    return preview_in(page.status) if page.status is not None else None


def path_of(page: Page) -> Sequence[str]:
    """Return the active states of the viewed agent at the shown moment, outermost first."""
    if page.time.past is not None:
        return page.time.past.path
    return page.status.active_path if page.status is not None else ()


def readings_of(page: Page) -> Readings:
    """Return the values of features of the viewed agent, up to the shown moment."""
    return page.watched.readings if page.time.past is None else page.time.past.readings


def previews(page: Page, names: Sequence[str]) -> dict[str, list[Any]]:
    """Return what agents would do next: the state, how sure, and why unsure, by name."""
    past = page.time.past
    if past is None:
        found = {name: preview_in(page.moment.statuses[name]) for name in names}
    else:
        found = {past.agent: past.preview} if past.preview is not None else {}
    return {
        name: [p.state, p.probability >= SURE, p.unsure] for name, p in found.items() if p.state
    }


def is_frozen(page: Page) -> bool:
    """Whether the world rests in the cycle in which a first key has paused it."""
    world = page.studio.known.world
    return world is not None and (world.mode, world.cycle) == (PAUSED, page.time.frozen)


def look_back(page: Page, at: float, step: int = 0) -> None:
    """Show a moment of the last minute, or one some cycles after it; the newest is the present.

    Raises:
        SwarmError: if nothing of it is remembered.
    """
    minute, real = page.studio.link.minute, page.studio.known.robots is not None
    moment = at if real else float(round(at) + step)
    found = minute.scenes.at(max(moment, minute.begin), step if real else 0)
    if found is None:
        raise SwarmError("Nothing of the last minute is remembered yet.")
    scene = found[1]
    moment = found[0] if real else max(moment, minute.begin)  # some cycles were not received
    if moment >= minute.now:
        to_present(page)
        return
    before, palette = page.time.past, page.studio.palette
    drawn = frame(scene, minute.doing(moment), palette)
    past = PastMoment(moment, drawn, roster(scene, palette), page.agent)
    if (glimpse := glimpse_at(minute.glimpses(page.agent), moment)) is not None:
        past.path = glimpse.path
    past.cycle = minute.cycle(page.agent, moment, real=scene.real)
    page.time.past = past
    if before is not None and before.asking is not None:
        before.asking.cancel()
    page.outgoing.append(past.roster)
    page.news.set()
    page.touch()
    if page.agent:
        past.asking = asyncio.create_task(_ask(page, past))


async def _ask(page: Page, past: PastMoment) -> None:
    """Ask the agent what it perceived at a moment, and what it would have done."""
    try:
        if not past.cycle:
            raise SwarmError(f"It is not known which cycle of {past.agent} that was.")
        answer = await page.ask(
            lambda swarm: swarm.agents.read_features.coroutine(past.agent, cycle=past.cycle),
            past.agent,
        )
        past.readings = {(r.automaton, r.feature): (r.value,) for r in answer.readings}
        past.path, past.preview = list(answer.active_path) or past.path, answer.preview
    except Exception as error:
        past.why = what_went_wrong(error)
    page.news.set()
    page.touch()


def to_present(page: Page) -> None:
    """Show the present again."""
    if page.time.past is not None:
        page.time.past = None
        page.show_again()
        page.touch()


def seconds_ago(page: Page) -> float:
    """Return how long ago the shown moment was, s."""
    past, minute = page.time.past, page.studio.link.minute
    return (minute.now - past.at) / minute.rate if past is not None else 0.0
