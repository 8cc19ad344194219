"""The situation in which a training goes on: named by a person, brought about by itself.

    format: 1
    snapshot: corner              # of the world, by name
    place:                        # or where things are put; headings in degrees, as in lessons
      keeper_1: {x: 8, y: 8, heading: 180}
      ball: {x: -6, y: 6, vx: 0, vy: 0}
    new_episode: true             # with `place`: begin a new episode from there
    wait: {said: keeper_2}        # then let the agents act until this holds, as in lessons
    within: 20                    # at most so long, s; without it, for any time

Every key is optional. Where nothing can be placed, as with robots, only `wait` is possible.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

from hitab_msgs.msg import AgentStatus
from hitab_msgs.srv import Snapshot
from pydantic import Field, model_validator

from hitab_client.errors import LessonError, SwarmError
from hitab_client.interruptions import not_interrupted
from hitab_client.lessons.condition_watch import ConditionWatch
from hitab_client.lessons.conditions import Condition
from hitab_client.lessons.lesson import Things, placed
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core import Fix, has, some
from hitab_core.library.yaml_models import Format, Record, open_record
from hitab_core.library.yaml_places import open_yaml, read_yaml

FORMAT = 1
"""The newest format version of a file that is read."""

Seen = Callable[[str], None]
"""Called with what is awaited, with its present value."""


class Configuration(Record):
    """What the world is like when a training goes on; empty: as it was.

    Attributes:
        snapshot: of the world, which is restored.
        place: where things are put; headings in degrees.
        new_episode: whether a new episode begins there.
        wait: the condition that is awaited then; None: none.
        within: seconds until waiting is given up; None: never.
    """

    format: Format = Field(default=1, exclude=True)
    snapshot: str = ""
    place: Things = Field(default_factory=dict)
    new_episode: bool = False
    wait: Condition | None = None
    within: float | None = Field(default=None, gt=0.0)

    @model_validator(mode="after")
    def _begins_in_one_way(self) -> Self:
        if self.snapshot and self.place:
            raise ValueError("has `snapshot:` and `place:`; give one of them")
        return self

    def __bool__(self) -> bool:
        return bool(self.snapshot or self.place or self.wait)

    @property
    def places(self) -> bool:
        """Whether it puts a world into a state."""
        return bool(self.snapshot or self.place)

    def record(self) -> dict[str, Any]:
        """Return it as plain data, as in a file; without what says nothing."""
        parts = self.model_dump(mode="json", by_alias=True, exclude_unset=True)
        return {key: value for key, value in parts.items() if value}

    def __str__(self) -> str:
        parts = [f"snapshot {self.snapshot}"] if self.snapshot else []
        parts += [f"{some(list(self.place), most=3)} placed"] if self.place else []
        parts += [f"when {self.wait.describe()}"] if self.wait else []
        return ", ".join(parts)

    def about(self, agent: str) -> Configuration:
        """Return the same; its condition is about this agent where it names none."""
        return self.but(wait=self.wait.about(agent)) if self.wait else self

    # -- bringing it about ------------------------------------------------------------------

    def check(self, world: WorldClient | None) -> None:
        """Raise if it cannot be brought about; nothing has changed then.

        Raises:
            SwarmError: naming what there is instead.
        """
        if not self.places:
            return
        if world is None:
            raise SwarmError(
                "there is no world into which anything could be placed; have the training go on "
                "when the situation comes about (wait)"
            )
        if self.snapshot:
            names = list(world.snapshot(Snapshot.Request.LIST).names)
            if self.snapshot not in names:
                raise SwarmError(
                    f'the world has no snapshot "{self.snapshot}" {has(names, self.snapshot)}',
                    Fix.SAVE_SNAPSHOT(snapshot=self.snapshot),
                )

    def put(self, world: WorldClient) -> None:
        """Put a paused world into the state.

        Raises:
            SwarmError: if it refuses.
        """
        if self.snapshot:
            world.shown(world.snapshot(Snapshot.Request.RESTORE, self.snapshot))
        elif self.place:
            world.shown(world.place(placed(self.place), new_episode=self.new_episode))

    def await_(
        self, swarm: SwarmClient, world: WorldClient | None, agent: str, factor: float, seen: Seen
    ) -> None:
        """Have an agent act as it has learned until the situation comes about, then take over.

        However this ends, the agent is in training mode then: the demonstrator is in control.

        Args:
            swarm: the agents.
            world: theirs, paused; None: they have none.
            agent: that is trained.
            factor: multiple of real time, for people who look on; 0: as fast as possible.
            seen: called with what is awaited.

        Raises:
            SwarmError: if it does not come about in time, or nobody can tell whether it has.
        """
        condition = self.wait
        if condition is None:
            return
        within = self.within if self.within is not None else float("inf")
        try:
            swarm.set_mode(agent, AgentStatus.TESTING, restart=True)
            with ConditionWatch(swarm, world, factor=factor) as watching:
                came = watching.until(
                    condition, within, lambda view: seen(condition.describe(view))
                )
                last = condition.describe(watching.view())
        except LessonError as error:
            raise SwarmError(f"what is awaited cannot come about: {error}") from None
        finally:
            with not_interrupted():
                swarm.set_mode(agent, AgentStatus.TRAINING)
        if not came:
            raise SwarmError(
                f"waited {within:g} s in vain until {last}; {agent} is in training mode, where it "
                "is now; bring the situation about by hand",
                Fix.TEST(agent=agent),
            )


def read_configuration(path: Path, agent: str) -> Configuration:
    """Read one from a file.

    Raises:
        SwarmError: naming everything that is wrong, by file and line.
    """
    document = open_yaml(path, error=SwarmError)
    return open_record(Configuration, document, FORMAT).about(agent)


def with_condition(configuration: Configuration, text: str, agent: str) -> Configuration:
    """Return a configuration that then awaits a condition, given as in a lesson.

    Args:
        configuration: to add it to.
        text: such as ``{said: keeper_2}``.
        agent: meant where the condition names none.

    Raises:
        SwarmError: naming what is wrong with it.
    """
    flow = text if text.lstrip().startswith("{") else f"{{{text}}}"
    document = read_yaml(f"wait: {flow}", "--wait", error=SwarmError)
    read = open_record(Configuration, document, FORMAT).about(agent)
    return configuration.but(wait=read.wait)
