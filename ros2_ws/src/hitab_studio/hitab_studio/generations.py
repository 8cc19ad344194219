"""Generations of what a team performs: made, and gone back to, while the pages go on.

A page asks for one; it takes up to minutes, since the team plays episodes for a score. Meanwhile
nothing else is done with the swarm, all pages see how far it is, and any of them may stop it.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from hitab_client import SwarmError
from hitab_client.bootstrapping import Bootstrapping, Generations, folder_of, read_generations
from hitab_client.run_folder import state_home
from hitab_ros.answering import what_went_wrong
from hitab_studio.swarm_finder import SwarmTarget
from hitab_studio.swarm_link import Connected, SwarmLink
from hitab_studio.swarm_state import SwarmState


@dataclass
class Making:
    """A generation that is being made or gone back to, or was.

    Attributes:
        agent: that is trained.
        behavior: that is trained.
        doing: what goes on at present, for people; empty: nothing any more.
        said: what was done so far.
        problem: what went wrong; "" if nothing.
        is_to_end: whether a page has asked to stop it.
    """

    agent: str
    behavior: str
    doing: str = "beginning"
    said: list[str] = field(default_factory=list)
    problem: str = ""
    is_to_end: bool = False


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
        self._task: asyncio.Task[None] | None = None

    @property
    def why_busy(self) -> str:
        """Why nothing else is to be done with the swarm at present; "" if it may be."""
        made = self.making
        if made is None or not made.doing:
            return ""
        return (
            f"{made.agent} is at work on a generation of {made.behavior}: wait until that is "
            "done, or stop it."
        )

    def begin(
        self,
        making: Making,
        step: Callable[[Bootstrapping], Any],
        known: SwarmState,
        **options: Any,
    ) -> None:
        """Have a step of bootstrapping done; pages see how far it is.

        Args:
            making: what to show of it.
            step: what to do.
            known: of the swarm, whose run folder keeps the generations.
            options: of `Bootstrapping`.

        Raises:
            SwarmError: if another one is under way.
        """
        if self.why_busy:
            raise SwarmError(self.why_busy)
        self.making = making
        self._changed()
        self._task = asyncio.create_task(self._follow(making, step, known, options))

    async def _follow(
        self,
        making: Making,
        step: Callable[[Bootstrapping], Any],
        known: SwarmState,
        options: dict[str, Any],
    ) -> None:
        loop = asyncio.get_running_loop()

        def job(swarm: Connected) -> None:  # in a thread
            def show(doing: str) -> None:
                making.doing = doing
                loop.call_soon_threadsafe(self._changed)

            def progress(done: int, total: int, doing: str) -> None:
                if making.is_to_end:
                    raise SwarmError(f"It was stopped; {steps.left or 'nothing has changed'}.")
                show(f"{doing}, {done} of {total}" if total else doing)

            def say(text: str) -> None:
                making.said.append(text)
                show(text)

            world = swarm.world if known.world is not None else None
            folder = kept_in(known.target)
            steps = Bootstrapping(
                swarm.agents, world, folder, say=say, progress=progress, **options
            )
            step(steps)

        try:
            # It needs nobody in the link's sense: a step that is ended at the first silence of its
            # agent could not resume the training, and says by itself who does not answer.
            await self._link.do(job, making.agent)
        except SwarmError as error:
            making.problem = str(error)
        except Exception as error:
            logging.getLogger(__name__).exception("a generation of %s", making.behavior)
            making.problem = what_went_wrong(error)
        making.doing = ""
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
    path = folder / f"{behavior}.yaml"
    return _read(folder, behavior, path.stat().st_mtime_ns if path.exists() else 0)


def have_generations(target: SwarmTarget | None, agent: str) -> list[str]:
    """Return the behaviors of an agent that have generations."""
    return [path.stem for path in folder_of(kept_in(target), agent).glob("*.yaml")]


@lru_cache(maxsize=32)
def _read(folder: Path, behavior: str, written: int) -> Generations:
    """Read a file again only if it was written since."""
    return read_generations(folder, behavior)
