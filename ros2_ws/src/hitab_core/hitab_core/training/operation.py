"""An operation on an agent as data, and its outcome; `hitab_core.operations` has them all."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from hitab_core.term import Term
from hitab_core.texts.remedies import Remedy

if TYPE_CHECKING:
    from hitab_core.library.bundle import Bundle

OUTCOMES_MAX = 1000
"""Number of operations whose outcomes an agent or a world keeps, for those that are sent again."""


@dataclass(frozen=True)
class Outcome:
    """What an operation did; each field but the first three belongs to some operations only.

    Attributes:
        message: what was done, in words.
        remedies: possible next steps.
        examples: numbers of the recorded examples.
        left: label of the state in which a command was recorded; empty if it was not.
        path, digest: path of the saved file, and its digest or that of the library.
        replaced: the replaced version, in words; empty if there is none.
        trimmed: states and features that were left out, since nothing uses them.
        behaviors: names of the trained behaviors now loaded.
        sequence: number of a distribution.
    """

    message: str
    remedies: Sequence[Remedy] = ()
    examples: Sequence[int] = ()
    left: str = ""
    path: str = ""
    digest: str = ""
    replaced: str = ""
    trimmed: Sequence[str] = ()
    behaviors: Sequence[str] = ()
    sequence: int = 0


class Outcomes(OrderedDict[str, Any]):
    """The outcomes of the last operations, by id; those without an id are not kept."""

    def keep(self, id: str, outcome: Any) -> None:
        """Keep an outcome, and forget the oldest."""
        if id:
            self[id] = outcome
            if len(self) > OUTCOMES_MAX:
                self.popitem(last=False)


class Shipment(NamedTuple):
    """A behavior on its way to other agents.

    Attributes:
        bundle: its file and those of its parts.
        term: the behavior with the targets of its parameters.
        receivers: names of the receivers; empty for all.
        start: whether they begin to perform it.
    """

    bundle: Bundle
    term: Term
    receivers: Sequence[str]
    start: bool


@dataclass(frozen=True)
class Operation:
    """Something that is done to an agent.

    Attributes:
        id: identity, the same when the operation is sent again; empty if it is not.
        by: name of the person who does it; empty if unknown.
    """

    name: ClassVar[str] = ""

    id: str = field(default="", kw_only=True)
    by: str = field(default="", kw_only=True)

    def __init_subclass__(cls) -> None:
        cls.name = re.sub("(?<=[a-z])(?=[A-Z])", "_", cls.__name__).lower()

    @classmethod
    def own_fields(cls) -> dict[str, Field[Any]]:
        """Return the fields besides identity and person, by name."""
        return {f.name: f for f in fields(cls) if not f.kw_only}

    def apply(self, agent: Any) -> Outcome:
        """Carry the operation out on an `Agent`.

        Raises:
            HitabError: if it is refused; nothing has changed.
        """
        raise NotImplementedError


def is_required(field: Field[Any]) -> bool:
    """Return whether a field of an operation has no default."""
    return field.default is MISSING and field.default_factory is MISSING
