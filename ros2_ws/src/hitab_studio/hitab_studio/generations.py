"""Generations of what a team performs: made, and brought back, while the pages go on.

A page asks for one; it takes up to minutes, since the team plays episodes for a score. Meanwhile
nothing else is done with the swarm, all pages see how far it is, and any of them may stop it.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from hitab_client import SwarmError
from hitab_client.bootstrapping import (
    Bootstrapping,
    Generation,
    Generations,
    behaviors_in,
    folder_of,
    read_generations,
)
from hitab_client.run_folder import state_home
from hitab_ros.answering import what_went_wrong
from hitab_studio.swarm_finder import SwarmTarget
from hitab_studio.swarm_link import Connected, SwarmLink
from hitab_studio.swarm_state import SwarmState

Step = Callable[[Bootstrapping], Generation]

BUSY = "{} is at work on a generation of {}: wait until that is done, or stop it."


@dataclass
class Making:
    """A generation that is being made or brought back, or was.

    Attributes:
        agent: that is trained.
        behavior: that is trained.
        doing: what goes on at present, for people.
        done, total: how much of it; total 0: unknown.
        said: what was done so far.
        has_ended: whether nothing goes on any more.
        problem: what went wrong; "" if nothing.
    """

    agent: str
    behavior: str
    doing: str = "beginning"
    done: int = 0
    total: int = 0
    said: list[str] = field(default_factory=list)
    has_ended: bool = False
    problem: str = ""


class GenerationMaker:
    """Makes generations for all pages, one at a time.

    Args:
        link: to the swarm.
        changed: called when something new is to be shown.

    Attributes:
        making: the present one, or the last one.
    """

    def __init__(self, link: SwarmLink, changed: Callable[[], None]) -> None:
        self.making: Making | None = None
        self._link = link
        self._changed = changed
        self._stopping = threading.Event()
        self._task: asyncio.Task[None] | None = None

    @property
    def why_busy(self) -> str:
        """Why nothing else is to be done with the swarm at present; "" if it may be."""
        making = self.making
        if making is None or making.has_ended:
            return ""
        return BUSY.format(making.agent, making.behavior)

    def begin(self, making: Making, step: Step, known: SwarmState, who: str) -> None:
        """Have a step of bootstrapping done; pages see how far it is.

        Args:
            making: what to show of it.
            step: what to do.
            known: of the swarm, whose run folder keeps the generations.
            who: the demonstrator.

        Raises:
            SwarmError: if another one is under way.
        """
        if self.why_busy:
            raise SwarmError(self.why_busy)
        self.making = making
        self._stopping.clear()
        self._changed()
        self._task = asyncio.create_task(self._follow(making, step, known, who))

    def stop(self) -> None:
        """End what is under way at the next episode; the training goes on."""
        self._stopping.set()

    def dismiss(self) -> None:
        """Forget the last one."""
        if not self.why_busy:
            self.making = None
            self._changed()

    async def _follow(self, making: Making, step: Step, known: SwarmState, who: str) -> None:
        loop, stopping = asyncio.get_running_loop(), self._stopping

        def show(done: int, total: int, doing: str) -> None:
            making.done, making.total, making.doing = done, total, doing
            self._changed()

        def say(text: str) -> None:
            making.said.append(text)
            show(0, 0, text)

        def job(swarm: Connected) -> Generation:  # in a thread
            def progress(done: int, total: int, doing: str) -> None:
                if stopping.is_set():
                    raise SwarmError(f"It was stopped; {steps.left or 'nothing has changed'}.")
                loop.call_soon_threadsafe(show, done, total, doing)

            def told(text: str) -> None:
                loop.call_soon_threadsafe(say, text)

            steps = Bootstrapping(
                swarm.agents,
                swarm.world if known.world is not None else None,
                kept_in(known.target),
                who=who,
                say=told,
                progress=progress,
            )
            return step(steps)

        try:
            # It needs nobody in the link's sense: a step that is ended at the first silence of its
            # agent could not resume the training, and says by itself who does not answer.
            await self._link.do(job, making.agent)
        except SwarmError as error:
            making.problem = str(error)
        except Exception as error:
            logging.getLogger(__name__).exception("a generation of %s", making.behavior)
            making.problem = what_went_wrong(error)
        making.has_ended = True
        self._changed()


def kept_in(target: SwarmTarget | None) -> Path:
    """Return the folder that keeps a swarm's generations; one for robots started by hand."""
    return Path(target.folder) if target is not None and target.folder else state_home()


def known_generations(target: SwarmTarget | None, agent: str, behavior: str) -> Generations:
    """Return the generations of a behavior; none if there are none yet.

    Raises:
        SwarmError: naming all that is wrong with the file.
    """
    folder = folder_of(kept_in(target), agent)
    try:
        written = (folder / f"{behavior}.yaml").stat().st_mtime_ns
    except OSError:
        written = 0
    return _read(folder, agent, behavior, written)


def have_generations(target: SwarmTarget | None, agent: str) -> list[str]:
    """Return the behaviors of an agent that have generations."""
    return behaviors_in(folder_of(kept_in(target), agent))


@lru_cache(maxsize=32)
def _read(folder: Path, agent: str, behavior: str, written: int) -> Generations:
    """Read a file again only if it was written since."""
    return read_generations(folder, agent, behavior)
