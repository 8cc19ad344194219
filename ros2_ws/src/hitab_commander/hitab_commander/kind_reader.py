"""Reads kinds of commanders from YAML.

    commander: Captain
    orders:                                  # name: what the subordinates perform
      Play: Keepaway                         # all of them
      Attack: {scout: Search, carrier: Follow(ball)}    # by role
      Send(A): {A: Fetch, others: keep}      # about one of them; keep: go on with what you do
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
    deadline: 3                              # s; who is silent for longer is left out
    rate: 10                                 # Hz
    report_period: 0.5                       # s between reports of values that change

`any`, `all`, `fraction` and `count` ask something of each subordinate; `mean`, `minimum` and
`maximum` sum up values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from hitab_commander.kind import (
    EXTREMES,
    GROUP_PARTS,
    CommanderKind,
    GroupFeature,
    Observation,
    OrderMap,
    Over,
    Pick,
)
from hitab_core import FLAGS, NAME, HitabError, Use, VocabularyError, has
from hitab_core.commanding import OTHERS
from hitab_core.library.yaml_places import Complaints, read_yaml
from hitab_core.library.yaml_places import Path as Place

Complain = Callable[[Place, str], None]
"""Called with where in the kind's mapping something is wrong, and what."""

KEEP = "keep"
NOTHING = "nothing"
OTHERS_WORD = "others"
KIND_FILE = "commander.yaml"
"""The file that tells, in a commander's library folder, what its kind is."""

FASTEST = 1000.0
"""Hz; the highest rate at which a commander may be asked to decide."""

LONGEST = 1e6
"""s; the longest time that means anything here, and its inverse the lowest rate and time."""

_KEYS = ("commander", "orders", "features", "targets", "deadline", "rate", "report_period")


def read_kind(path: Path) -> CommanderKind:
    """Read a kind of commander from a file.

    Raises:
        VocabularyError: with everything that is wrong, by file and line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise VocabularyError(f"{path}: cannot be read: {error}") from None
    document = read_yaml(text, str(path), error=VocabularyError)
    complaints = Complaints(document, VocabularyError)
    name = document.value.get("commander") if isinstance(document.value, dict) else None
    if not isinstance(name, str):
        complaints.add((), "needs `commander:`, the name of the kind")
    kind = parse_kind(name or "", document.value, complaints.add)
    if not kind.orders:
        complaints.add((), "needs `orders:`, a line with a name each")
    complaints.raise_any()
    return kind


def parse_kind(name: str, value: Any, complain: Complain) -> CommanderKind:
    """Return a kind from plain data; what is wrong is complained about and left out.

    Args:
        name: of the kind.
        value: the mapping described above. Without ``orders`` the kind has none.
        complain: told what is wrong, and where.
    """
    reader = _Reader(complain)
    top = reader.mapping((), value)
    reader.known((), top, _KEYS)
    if name and NAME.match(name) is None:
        complain((), f'"{name}" is not a name for a kind of commander; use letters, digits and _')
    kind = CommanderKind(
        name,
        tuple(reader.each(top, "orders", reader.order)),
        tuple(reader.each(top, "features", reader.feature)),
        tuple(reader.each(top, "targets", reader.target)),
        reader.positive(top, "deadline", 3.0),
        reader.positive(top, "rate", 10.0, FASTEST),
        reader.positive(top, "report_period", 0.5),
    )
    reader.refuse_doubles(kind)
    return kind


class _Reader:
    """Takes plain data apart, complaining about what is wrong."""

    def __init__(self, complain: Complain) -> None:
        self.complain = complain

    def mapping(self, place: Place, value: Any) -> dict[str, Any]:
        if value is None:
            return {}
        if not isinstance(value, dict):
            self.complain(place, f"needs `key: value` lines here, not {value!r}")
            return {}
        return value

    def known(self, place: Place, value: Mapping[str, Any], keys: Iterable[str]) -> None:
        for key in value:
            if key not in keys:
                self.complain((*place, key), f"`{key}:` is not known here {has(keys)}")

    def positive(
        self, top: Mapping[str, Any], key: str, default: float, most: float = LONGEST
    ) -> float:
        value = top.get(key, default)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not value > 0:
            self.complain((key,), f"`{key}:` must be a number above 0, not {value!r}")
            return default
        if value > most or value < 1.0 / LONGEST:
            self.complain((key,), f"`{key}:` must be from {1.0 / LONGEST:g} to {most:g}")
            return default
        return float(value)

    def each(
        self, top: Mapping[str, Any], key: str, read: Callable[[Place, str, str, Any], Any]
    ) -> list[Any]:
        """Read each line of a mapping whose keys are ``Name`` or ``Name(A)``."""
        found = []
        for label, value in self.mapping((key,), top.get(key)).items():
            place = (key, label)
            use = self.use(place, label)
            if use is None:
                continue
            if len(use.arguments) > 1:
                self.complain(place, f'"{label}" can be about one subordinate only; leave one')
                continue
            made = read(place, use.name, "".join(use.arguments), value)
            if made is not None:
                found.append(made)
        return found

    def use(self, place: Place, text: Any) -> Use | None:
        try:
            return Use.parse(text if isinstance(text, str) else str(text))
        except HitabError as error:
            self.complain(place, str(error))
            return None

    # -- orders -----------------------------------------------------------------------------

    def order(self, place: Place, name: str, parameter: str, value: Any) -> OrderMap | None:
        if not isinstance(value, dict):
            if parameter:
                self.complain(
                    place,
                    f'the order "{name}" is about {parameter}; tell what it and the others do: '
                    f"{{{parameter}: ..., {OTHERS_WORD}: {KEEP}}}",
                )
                return None
            return OrderMap(name, {OTHERS: self.behavior(place, value)})
        behaviors: dict[str, str | None] = {}
        for key, behavior in value.items():
            receiver = OTHERS if key == OTHERS_WORD else key
            if receiver and NAME.match(receiver) is None:
                self.complain((*place, key), f'"{key}" is not a name for a role')
            behaviors[receiver] = self.behavior((*place, key), behavior)
        if parameter and parameter not in behaviors:
            self.complain(place, f'the order "{name}" does not tell what {parameter} does; add it')
        if not behaviors:
            self.complain(place, f'the order "{name}" orders nothing; write `{name}: {NOTHING}`')
        return OrderMap(name, behaviors, parameter)

    def behavior(self, place: Place, text: Any) -> str | None:
        if text == KEEP:
            return None
        if text == NOTHING:
            return ""
        if not isinstance(text, str):
            self.complain(
                place, f"must be a behavior, `{NOTHING}` or `{KEEP}`, not {text!r}; see the docs"
            )
            return None
        use = self.use(place, text)
        return None if use is None else str(use)

    # -- features and targets ---------------------------------------------------------------

    def feature(self, place: Place, name: str, parameter: str, value: Any) -> GroupFeature | None:
        value = self.mapping(place, value)
        over = self.over(place, value, tuple(Over))
        if over is None:
            return None
        self.known(place, value, (over.value, "role", "below", "above"))
        if (over is Over.VALUE) != bool(parameter):
            self.complain(
                place,
                f'"{name}" is the value of one subordinate: write `{name}(A):`'
                if not parameter
                else f'"{name}({parameter})" sums up all: write `{name}:`, or use `value:`',
            )
            return None
        if over is Over.GROUP:
            part = value[over.value]
            if part not in GROUP_PARTS:
                self.complain((*place, over.value), f'"{part}" is unknown {has(GROUP_PARTS)}')
                return None
            return GroupFeature(name, over, part=part)
        of = self.observation(place, over, value)
        return (
            None
            if of is None
            else GroupFeature(name, over, of, self.role(place, value), parameter)
        )

    def target(self, place: Place, name: str, parameter: str, value: Any) -> Pick | None:
        value = self.mapping(place, value)
        if parameter:
            self.complain(place, f"a target has no parameter: write `{name}:`")
        if "number" in value:
            self.known(place, value, ("number", "role"))
            number = value["number"]
            if isinstance(number, bool) or not isinstance(number, int) or number < 1:
                self.complain((*place, "number"), "`number:` must be 1, 2, 3, ...")
                return None
            return Pick(name, role=self.role(place, value), number=number)
        over = self.over(place, value, EXTREMES, "number")
        if over is None:
            return None
        self.known(place, value, (over.value, "role"))
        of = self.observation(place, over, value)
        return None if of is None else Pick(name, over, of, self.role(place, value))

    def over(
        self, place: Place, value: Mapping[str, Any], known: tuple[Over, ...], *further: str
    ) -> Over | None:
        found = [over for over in known if over.value in value]
        if len(found) != 1:
            names = ", ".join([*(over.value for over in known), *further])
            self.complain(place, f"needs one of: {names}")
            return None
        return found[0]

    def role(self, place: Place, value: Mapping[str, Any]) -> str:
        role = value.get("role", "")
        if not isinstance(role, str):
            self.complain((*place, "role"), f"`role:` must be a name, not {role!r}")
            return ""
        return role

    def observation(
        self, place: Place, over: Over, value: Mapping[str, Any]
    ) -> Observation | None:
        inner = (*place, over.value)
        limits: dict[str, float | None] = {}
        for key in ("below", "above"):
            limit = value.get(key)
            if limit is not None and (
                isinstance(limit, bool) or not isinstance(limit, int | float)
            ):
                self.complain((*place, key), f"`{key}:` must be a number, not {limit!r}")
                limit = None
            limits[key] = None if limit is None else float(limit)
        of = value[over.value]
        limited = any(limit is not None for limit in limits.values())
        if isinstance(of, dict):
            self.known(inner, of, ("active",))
            state = of.get("active")
            if not isinstance(state, str):
                self.complain(inner, "needs a flag, a feature, or {active: STATE}")
                return None
            found = Observation(active=state)
        elif of in FLAGS:
            found = Observation(flag=of)
        else:
            use = self.use(inner, of)
            if use is None:
                return None
            return Observation(feature=str(use), below=limits["below"], above=limits["above"])
        if limited:
            self.complain(place, "`below:` and `above:` are for features")
        return found

    def refuse_doubles(self, kind: CommanderKind) -> None:
        for key, names in (
            ("orders", [order.name for order in kind.orders]),
            ("features", [feature.name for feature in kind.features]),
        ):
            for name in sorted({name for name in names if names.count(name) > 1}):
                self.complain((key,), f'has "{name}" twice; rename one')
