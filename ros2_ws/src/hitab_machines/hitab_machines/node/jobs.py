"""Coroutines of a node, which go on between its other events."""

from __future__ import annotations

import time

from hitab_core import HitabError
from hitab_ros import GuardedNode
from hitab_ros.call import Caller, Turns
from hitab_ros.timing import AT_ONCE_S


class Jobs(Caller):
    """Calls of a node that never block it: coroutines by name, each at most once at a time.

    A job that fails is a fault of the node, until it succeeds.

    Args:
        node: the node, whose timer drives the coroutines.
    """

    def __init__(self, node: GuardedNode) -> None:
        super().__init__(node)
        self._running: dict[str, tuple[float, Turns[None]]] = {}
        node.create_timer(AT_ONCE_S, self._go_on)

    def is_running(self, name: str) -> bool:
        """Whether a job of this name is under way."""
        return name in self._running

    def start(self, name: str, job: Turns[None]) -> None:
        """Begin a job, unless one of its name is under way."""
        if name in self._running:
            job.close()
        else:
            self._running[name] = (0.0, job)

    def _go_on(self) -> None:
        for name, (due, job) in list(self._running.items()):
            if time.monotonic() < due:
                continue
            try:
                self._running[name] = (time.monotonic() + job.send(None), job)
            except StopIteration:
                del self._running[name]
                self.node.guard.faults.clear(name)
            except Exception as error:
                del self._running[name]
                if isinstance(error, HitabError):
                    self.node.guard.faults.set(name, error.problem)
                else:
                    self.node.guard.failed(name, error)
