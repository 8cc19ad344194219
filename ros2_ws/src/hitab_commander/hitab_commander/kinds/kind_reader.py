"""The YAML description of a kind of commander: reading and writing.

    commander: Captain
    orders:                                  # name: what the subordinates perform
      Play: Keepaway                         # all of them
      Attack: {scout: Search, carrier: Follow(ball)}    # by role
      Send(A): {A: Fetch, others: keep}      # about one of them; keep: no change
      Rest: nothing
    features:
      AllDone: {all: Done}                   # a flag
      Searching: {fraction: {active: Search}, role: scout}    # an active state
      Near: {count: DistanceTo(ball), below: 5}               # a feature of the subordinates
      Nearest: {minimum: DistanceTo(ball)}
      BallDistance(A): {value: DistanceTo(ball)}              # of one of them
      Spread: {group: spread}                # of where they are: x, y, spread
    targets:
      closest: {minimum: DistanceTo(ball)}   # one of them
      first: {number: 1}
    deadline: 3                              # s; a member silent for longer is left out
    rate: 10                                 # Hz
    report_period: 0.5                       # s between reports of values that change

`any`, `all`, `fraction` and `count` aggregate true-or-false observations of the subordinates;
`mean`, `minimum` and `maximum` aggregate values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar

import yaml
from pydantic import AfterValidator, Field, PlainValidator, create_model

from hitab_commander.kinds.kind import (
    EXTREMES,
    GROUP_PARTS,
    CommanderKind,
    GroupFeature,
    Observation,
    OrderMap,
    Over,
    Pick,
)
from hitab_core import (
    FLAGS,
    VOCABULARY_NAME,
    VOCABULARY_NAME_RULE,
    Term,
    VocabularyError,
    quantity,
)
from hitab_core.library.yaml_models import (
    NONE_IS_EMPTY,
    Format,
    MappingOr,
    OneOf,
    Record,
    among,
    open_record,
    read_use,
)
from hitab_core.library.yaml_places import Complaints, Document, Place, kind_of, open_yaml
from hitab_core.orders import ALL_OTHERS

FORMAT = 1
"""The newest format version that is read."""

KEEP = "keep"
NO_BEHAVIOR = "nothing"
OTHERS_WORD = "others"
KIND_FILE = "commander.yaml"
"""The file in a commander's library folder that describes its kind."""

RATE_MAX_HZ = 1000.0
"""Hz; the highest rate at which a commander may be asked to decide."""

TIME_MAX_S = 1e6
"""s; the longest time accepted. Its inverse is the shortest time and the lowest rate, Hz."""


def _label(text: str) -> str:
    if len(arguments := read_use(text).arguments) > 1:
        counted = quantity(len(arguments), "parameter")
        raise ValueError(f"has {counted}; leave one, for one subordinate")
    return text


def _receiver(text: str) -> str:
    if VOCABULARY_NAME.match(text) is None:
        raise ValueError("is not a name for a role")
    return ALL_OTHERS if text == OTHERS_WORD else text


def _behavior(text: Any) -> str | None:
    if text in (KEEP, NO_BEHAVIOR):
        return None if text == KEEP else ""
    if not isinstance(text, str):
        given = kind_of(text)
        raise ValueError(f"must be a behavior, `{NO_BEHAVIOR}` or `{KEEP}`, not {given}")
    return str(read_use(text))


T = TypeVar("T")
Label = Annotated[str, AfterValidator(_label)]
Behavior = Annotated[str | None, PlainValidator(_behavior)]
Behaviors = dict[Annotated[str, AfterValidator(_receiver)], Behavior]
Time = Annotated[float, Field(ge=1.0 / TIME_MAX_S, le=TIME_MAX_S)]


class ObservedState(Record):
    """An observed active state."""

    active: str


Observed = Annotated[
    ObservedState | str,
    MappingOr(ObservedState, Annotated[str, AfterValidator(lambda t: str(read_use(t)))]),
]


class Observing(Record):
    """The entry of a target or feature; only features may have limits."""

    over: Over = Field(default=Over.MINIMUM, alias=":over")
    of: Observed = ""
    role: str = ""
    below: float | None = None
    above: float | None = None

    def observation(self) -> Observation:
        """Return the observation of each subordinate."""
        if isinstance(self.of, ObservedState):
            return Observation(active=self.of.active)
        if self.of in FLAGS:
            return Observation(flag=self.of)
        return Observation(feature=self.of, below=self.below, above=self.above)


class PositionsPart(Record):
    """The entry of a feature of the positions."""

    part: Annotated[str, among(GROUP_PARTS)] = Field(alias="group")


class Numbered(Record):
    """The entry of a target that is a subordinate's number."""

    number: int = Field(ge=1)
    role: str = ""


def _over(over: Over) -> type[Record]:
    made: type[Record] = create_model(
        over.value,
        __base__=Observing,
        over=(Over, Field(default=over, alias=":over")),
        of=(Observed, Field(alias=over.value)),
    )
    return made


_OVER = {over.value: _over(over) for over in Over if over is not Over.GROUP}
_FEATURES = {**_OVER, Over.GROUP.value: PositionsPart}
_TARGETS = {**{over.value: _OVER[over] for over in EXTREMES}, "number": Numbered}


class KindRecord(Record):
    """The description of a kind."""

    format: Format = 1
    commander: str = ""
    orders: Annotated[
        dict[Label, Annotated[Behaviors | str | None, MappingOr(Behaviors, Behavior)]],
        NONE_IS_EMPTY,
    ] = Field(default_factory=dict)
    features: Annotated[
        dict[Label, Annotated[Observing | PositionsPart, OneOf(_FEATURES)]], NONE_IS_EMPTY
    ] = Field(default_factory=dict)
    targets: Annotated[
        dict[Label, Annotated[Observing | Numbered, OneOf(_TARGETS)]], NONE_IS_EMPTY
    ] = Field(default_factory=dict)
    deadline: Time = 3.0
    rate: Annotated[float, Field(ge=1.0 / TIME_MAX_S, le=RATE_MAX_HZ)] = 10.0
    report_period: Time = 0.5


def read_kind(path: Path) -> CommanderKind:
    """Read a kind of commander from a file.

    Raises:
        VocabularyError: naming all errors, by file and line.
    """
    document = open_yaml(path, error=VocabularyError)
    return _opened(document)


def described_kind(name: str, described: Mapping[str, Any]) -> CommanderKind:
    """Return the kind with a description that has the form of a file.

    Raises:
        VocabularyError: naming all errors.
    """
    return _opened(Document(name, {**described, "commander": name}, {(): 1}))


def _opened(document: Document) -> CommanderKind:
    record = open_record(KindRecord, document, FORMAT)
    complaints = Complaints(document)
    kind = kind_in(record, record.commander, complaints)
    if not record.commander:
        complaints.add((), "`commander:` is missing here; write the name of the kind")
    if not kind.orders:
        complaints.add((), "needs `orders:` with at least one order, such as `Play: Keepaway`")
    complaints.raise_any()
    return kind


def kind_in(
    record: KindRecord, name: str, complaints: Complaints, at: Place = ()
) -> CommanderKind:
    """Return a kind without the invalid parts of its description, which become complaints.

    Args:
        record: description of the kind. Without ``orders`` the kind has none.
        name: name of the kind.
        complaints: collects the errors.
        at: place of the description in its document.
    """
    if name and VOCABULARY_NAME.match(name) is None:
        complaints.add(
            at, f'"{name}" is not a name for a kind of commander; {VOCABULARY_NAME_RULE}'
        )

    def each(key: str, lines: Mapping[str, Any], read: Callable[[Term, Any], T]) -> Iterator[T]:
        seen: set[str] = set()
        for label, line in lines.items():
            term = Term.parse(label)
            if term.name in seen:
                complaints.add((*at, key), f'has "{term.name}" twice; rename one')
            seen.add(term.name)
            try:
                yield read(term, line)
            except ValueError as wrong:
                complaints.add((*at, key, label), str(wrong))

    described = complaints.document.value
    for key in at:
        described = described[key]
    return CommanderKind(
        name,
        tuple(each("orders", record.orders, _order)),
        tuple(each("features", record.features, _feature)),
        tuple(each("targets", record.targets, _target)),
        record.deadline,
        record.rate,
        record.report_period,
        described or {},
    )


def kind_text(kind: CommanderKind) -> str:
    """Return the text of a file that describes a kind."""
    described = {"commander": ""} | dict(kind.described) | {"commander": kind.name}
    return yaml.safe_dump(described, sort_keys=False)


def _order(term: Term, line: Behaviors | str | None) -> OrderMap:
    name, parameter = term.name, "".join(term.arguments)
    behaviors = line if isinstance(line, dict) else {ALL_OTHERS: line}
    if parameter and parameter not in behaviors:
        raise ValueError(
            f'the order "{name}" is about {parameter}; say what {parameter} and the others do: '
            f"{{{parameter}: ..., {OTHERS_WORD}: {KEEP}}}"
        )
    if not behaviors:
        raise ValueError(f'the order "{name}" orders nothing; write `{name}: {NO_BEHAVIOR}`')
    return OrderMap(name, behaviors, parameter)


def _feature(term: Term, line: Observing | PositionsPart) -> GroupFeature:
    name, parameter = term.name, "".join(term.arguments)
    of_one = isinstance(line, Observing) and line.over is Over.VALUE
    if of_one and not parameter:
        raise ValueError(f'"{name}" is the value of one subordinate: write `{name}(A):`')
    if parameter and not of_one:
        raise ValueError(
            f'"{term}" is about all subordinates: write `{name}:` without a parameter, or use '
            "`value:`"
        )
    if isinstance(line, PositionsPart):
        return GroupFeature(name, Over.GROUP, part=line.part)
    of = line.observation()
    if not of.feature and (line.below is not None or line.above is not None):
        raise ValueError("`below:` and `above:` are for features")
    return GroupFeature(name, line.over, of, line.role, parameter)


def _target(term: Term, line: Observing | Numbered) -> Pick:
    if term.arguments:
        raise ValueError(f"a target has no parameter: write `{term.name}:`")
    if isinstance(line, Numbered):
        return Pick(term.name, role=line.role, number=line.number)
    if line.below is not None or line.above is not None:
        raise ValueError("a target has no limits; leave out `below:` and `above:`")
    return Pick(term.name, line.over, line.observation(), line.role)
