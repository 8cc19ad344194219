"""Bodies that no world moves: they perceive numbers and note what they were made to do."""

from collections.abc import Callable, Sequence
from typing import Any

from hitab_core.domain import BasicBehavior


class Body:
    """A body that does nothing but note what its behaviors did since it last acted.

    Attributes:
        values: that it perceived last.
        action: that it sends.
        did: what its behaviors did; it says so.
    """

    values: Any = (0.0, 0.0)
    action: Sequence[float] = ()

    def __init__(self, name: str = "") -> None:
        self.did: list[str] = []

    @property
    def x(self) -> float:
        """The first value."""
        return float(self.values[0])

    def sense(self, values: Any, heard: Any) -> None:
        self.values = values

    def act(self) -> tuple[Sequence[float], str]:
        did, self.did = self.did, []
        return self.action, " ".join(did)


class UnseeingBody(Body):
    """A body that has perceived nothing yet."""

    values: Any = ()


def noting(what: str) -> Callable[..., None]:
    """Return what a behavior does that only notes it, with its targets."""
    return lambda body, *targets: body.did.append(" ".join((what, *targets)))


def pulsed(*names: str) -> list[BasicBehavior]:
    """Return behaviors that note each of their timesteps."""
    return [BasicBehavior(name, noting(name)) for name in names]
