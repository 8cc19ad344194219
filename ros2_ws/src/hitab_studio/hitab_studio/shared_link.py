"""A link that the server's loop spins while jobs, in threads of their own, wait by it.

A job is ordinary code that waits by spinning the link. It holds the link's monitor except while it
waits, so only one thread at a time uses the node, the clients and their data.

The rule for jobs: wait by the link (`spin`, `spin_until`, `call`), never by sleeping.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TypeVar

from hitab_client import RosLink, SwarmClient, SwarmError, WorldClient
from hitab_core import HitabError
from hitab_ros import names

T = TypeVar("T")

_needs: ContextVar[str | None] = ContextVar("needs", default=None)
"""In a job: the agent, or the world, that it needs; "" if none."""


class JobError(RuntimeError):
    """A bug in a job, in a form that a future can carry."""


class SharedLink(RosLink):
    """A link for the server's loop and for jobs.

    Attributes:
        monitor: held by whoever uses the link.
        silent: agents, and the world, that have fallen silent: what needs them ends.
        ended: why all jobs end; "" as long as they go on.
    """

    def __init__(self, domain_id: int | None, *, name: str) -> None:
        super().__init__(domain_id, name=name)
        self.monitor = threading.Condition()
        self.silent: Mapping[str, float] = {}
        self.ended = ""

    def spin(self, seconds: float = 0.1) -> None:
        """Handle events; in a job, have the server's loop do that.

        Raises:
            SwarmError: if the job should end.
        """
        needs = _needs.get()
        if needs is None:
            super().spin(seconds)
            return
        if not self.ended and needs not in self.silent:
            self.monitor.wait(seconds)
        if self.ended:
            raise SwarmError(self.ended)
        if needs in self.silent:
            who = "The world" if needs == names.WORLD else needs
            raise SwarmError(f"{who} fell silent meanwhile: look whether it was done.")

    def end(self, why: str) -> None:
        """End all jobs with an error, wherever they wait."""
        with self.monitor:
            self.ended = why
            self.monitor.notify_all()


@dataclass
class Connected:
    """The swarm, as seen over ROS."""

    link: SharedLink
    agents: SwarmClient
    world: WorldClient

    def run(self, job: Callable[[Connected], T], needs: str) -> T:
        """Do a job; for a thread of its own."""
        token = _needs.set(needs)
        try:
            with self.link.monitor:
                return job(self)
        except HitabError:
            raise
        except BaseException as error:
            # A future cannot carry every exception, and some would end the server's loop.
            raise JobError(f"{type(error).__name__}: {error}") from error
        finally:
            _needs.reset(token)
