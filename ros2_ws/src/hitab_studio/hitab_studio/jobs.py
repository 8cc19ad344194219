"""Jobs: requests of pages to the swarm, which wait without blocking each other.

A job is ordinary code that waits by spinning the link. Each has its own thread, which only runs
when the link's thread lets it, from one wait to the next. So only one thread at a time uses the
node, the clients and their data, and none of them needs a lock; while a job waits, the link's
thread spins the node for all.

The rule for jobs: wait by the link (`spin`, `spin_until`, `call`), never by sleeping.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from hitab_client import RosLink, SwarmClient, SwarmError, WorldClient
from hitab_core import HitabError

STUBBORN = 100
"""Waits after which a job that keeps waiting although it was ended is abandoned."""

_here = threading.local()


class JobError(RuntimeError):
    """A bug in a job, in a form that a future can carry."""


class Job:
    """One request of a page.

    Args:
        work: does it, and returns the answer.
        lines: jobs that share a line are done one after the other.
        needs: an agent, or the world, without which it cannot end; "" if none.

    Attributes:
        answer: for the caller.
    """

    def __init__(
        self, work: Callable[[], Any], lines: Iterable[str] = (), needs: str = ""
    ) -> None:
        self.lines = frozenset(lines)
        self.needs = needs
        self.answer: Future[Any] = Future()
        self._work = work
        self._thread: threading.Thread | None = None
        self._turn, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._why = ""
        self._result: Any = None
        self._error: Exception | None = None
        self._has_ended = False

    def go_on(self) -> bool:
        """Run it until it waits; return whether it has ended. For the link's thread."""
        if self._has_ended:
            return True
        if self._thread is not None:
            self._turn.release()
        elif self.answer.set_running_or_notify_cancel():
            self._thread = threading.Thread(target=self._run, name="studio job", daemon=True)
            self._thread.start()
        else:
            self._has_ended = True
            return True
        self._back.acquire()
        return self._has_ended

    def end(self, why: str) -> None:
        """End it with an error, wherever it waits. For the link's thread."""
        self._why = why
        if self._thread is None:
            self._error, self._has_ended = SwarmError(why), True
            self.answer.set_running_or_notify_cancel()
        for _ in range(STUBBORN):
            if self.go_on():
                return
        self._error = SwarmError(why)

    def reply(self) -> None:
        """Give the answer to the caller."""
        if self.answer.cancelled():
            return
        if self._error is not None:
            self.answer.set_exception(self._error)
        else:
            self.answer.set_result(self._result)

    def wait(self) -> None:
        """Wait for the next turn. For the job's own thread.

        Raises:
            SwarmError: if the job should end.
        """
        self._back.release()
        self._turn.acquire()
        if self._why:
            raise SwarmError(self._why)

    def _run(self) -> None:
        _here.job = self
        try:
            self._result = self._work()
        except HitabError as error:
            self._error = error
        except BaseException as error:
            # A future cannot carry every exception, and some would end the server's loop.
            self._error = JobError(f"{type(error).__name__}: {error}")
            self._error.__cause__ = error
        self._has_ended = True
        self._back.release()


class Jobs:
    """The jobs that have not ended, in the order of their requests."""

    def __init__(self) -> None:
        self._jobs: list[Job] = []

    def add(self, job: Job) -> None:
        """Add a job."""
        self._jobs.append(job)

    def go_on(self) -> list[Job]:
        """Run each job that need not wait for another one; return those that ended."""
        ended: list[Job] = []
        taken: set[str] = set()
        for job in self._jobs:
            if taken.isdisjoint(job.lines) and job.go_on():
                ended.append(job)
            else:
                taken |= job.lines
        self._jobs = [job for job in self._jobs if job not in ended]
        return ended

    def end_those_that_need(self, name: str, why: str) -> list[Job]:
        """End the jobs that need an agent or the world; return them."""
        ended = [job for job in self._jobs if job.needs == name]
        self._jobs = [job for job in self._jobs if job.needs != name]
        for job in ended:
            job.end(why)
        return ended

    def end(self, why: str) -> list[Job]:
        """End all jobs with an error; return them."""
        ended, self._jobs = self._jobs, []
        for job in ended:
            job.end(why)
        return ended


class SharedLink(RosLink):
    """A link that jobs can use besides its own thread: they wait for their next turn."""

    def spin(self, seconds: float = 0.1) -> None:
        """Handle events; in a job, have the link's thread do that."""
        job: Job | None = getattr(_here, "job", None)
        if job is None:
            super().spin(seconds)
        else:
            job.wait()


@dataclass
class Connected:
    """The swarm, as seen over ROS."""

    link: SharedLink
    agents: SwarmClient
    world: WorldClient
