"""Reads kinds of commanders from YAML.

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

`any`, `all`, `fraction` and `count` ask something of each subordinate; `mean`, `minimum` and
`maximum` sum up values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
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
from hitab_core import FLAGS, NAME, NAME_RULE, HitabError, Use, VocabularyError, quantity
from hitab_core.commanding import OTHERS
from hitab_core.library import Fields
from hitab_core.library.yaml_places import Complaints, open_yaml

FORMAT = 1
"""The newest format version that is read."""

KEEP = "keep"
NOTHING = "nothing"
OTHERS_WORD = "others"
KIND_FILE = "commander.yaml"
"""The file in a commander's library folder that describes its kind."""

FASTEST = 1000.0
"""Hz; the highest rate at which a commander may be asked to decide."""

LONGEST = 1e6
"""s; the longest time accepted. Its inverse is the shortest time and the lowest rate, Hz."""


def read_kind(path: Path) -> CommanderKind:
    """Read a kind of commander from a file.

    Raises:
        VocabularyError: with everything that is wrong, by file and line.
    """
    document = open_yaml(path, error=VocabularyError)
    top = Fields(Complaints(document, VocabularyError))
    top.check_format(FORMAT)
    kind = parse_kind(top.text("commander") or "", top)
    if not kind.orders:
        top.complain("needs `orders:` with at least one order, such as `Play: Keepaway`")
    top.complaints.raise_any()
    return kind


def parse_kind(name: str, top: Fields) -> CommanderKind:
    """Return a kind; what is wrong is complained about and left out.

    Args:
        name: of the kind.
        top: the mapping described above. Without ``orders`` the kind has none.
    """
    top.raw("commander", None)
    if name and NAME.match(name) is None:
        top.complain(f'"{name}" is not a name for a kind of commander; {NAME_RULE}')
    kind = CommanderKind(
        name,
        tuple(_each(top, "orders", _order)),
        tuple(_each(top, "features", _feature)),
        tuple(_each(top, "targets", _target)),
        _positive(top, "deadline", 3.0),
        _positive(top, "rate", 10.0, FASTEST),
        _positive(top, "report_period", 0.5),
    )
    top.done()
    _refuse_doubles(top, "orders", [order.name for order in kind.orders])
    _refuse_doubles(top, "features", [feature.name for feature in kind.features])
    return kind


def _positive(top: Fields, key: str, default: float, most: float = LONGEST) -> float:
    value: float = top.number(key, default)
    if not 1.0 / LONGEST <= value <= most:
        top.complain(f"`{key}:` must be from {1.0 / LONGEST:g} to {most:g}", key)
        return default
    return value


def _each(top: Fields, key: str, read: Callable[[Fields, str, str, str], Any]) -> Iterable[Any]:
    """Read each line of a mapping whose keys are ``Name`` or ``Name(A)``."""
    section = top.inner(key)
    for label in section.names():
        use = _use(section, label, label)
        if use is None:
            continue
        if len(use.arguments) > 1:
            section.complain(
                f'"{label}" has {quantity(len(use.arguments), "parameter")}; '
                "leave one, for one subordinate",
                label,
            )
            continue
        made = read(section, label, use.name, "".join(use.arguments))
        if made is not None:
            yield made


def _use(fields: Fields, text: Any, key: str) -> Use | None:
    try:
        return Use.parse(str(text))
    except HitabError as error:
        fields.complain(str(error), key)
        return None


def _refuse_doubles(top: Fields, key: str, names: list[str]) -> None:
    for name in sorted({name for name in names if names.count(name) > 1}):
        top.complain(f'has "{name}" twice; rename one', key)


# -- orders ---------------------------------------------------------------------------------


def _order(section: Fields, label: str, name: str, parameter: str) -> OrderMap | None:
    if not isinstance(section.raw(label), dict):
        if parameter:
            section.complain(
                f'the order "{name}" is about {parameter}; say what it and the others do: '
                f"{{{parameter}: ..., {OTHERS_WORD}: {KEEP}}}",
                label,
            )
            return None
        return OrderMap(name, {OTHERS: _behavior(section, label)})
    fields = section.inner(label)
    behaviors: dict[str, str | None] = {}
    for key in fields.names():
        receiver = OTHERS if key == OTHERS_WORD else key
        if receiver and NAME.match(receiver) is None:
            fields.complain(f'"{key}" is not a name for a role', key)
        behaviors[receiver] = _behavior(fields, key)
    if parameter and parameter not in behaviors:
        fields.complain(
            f'the order "{name}" does not say what {parameter} does; add a line `{parameter}: ...`'
        )
    if not behaviors:
        fields.complain(f'the order "{name}" orders nothing; write `{name}: {NOTHING}`')
    return OrderMap(name, behaviors, parameter)


def _behavior(fields: Fields, key: str) -> str | None:
    text = fields.raw(key)
    if text == KEEP:
        return None
    if text == NOTHING:
        return ""
    if not isinstance(text, str):
        fields.complain(f"must be a behavior, `{NOTHING}` or `{KEEP}`, not {text!r}", key)
        return None
    use = _use(fields, text, key)
    return None if use is None else str(use)


# -- features and targets -------------------------------------------------------------------


def _feature(section: Fields, label: str, name: str, parameter: str) -> GroupFeature | None:
    fields = section.inner(label)
    over = _over(fields, tuple(Over))
    if over is None:
        return None
    if (over is Over.VALUE) != bool(parameter):
        fields.complain(
            f'"{name}" is the value of one subordinate: write `{name}(A):`'
            if not parameter
            else f'"{name}({parameter})" is about all subordinates: write `{name}:` without a '
            "parameter, or use `value:`",
        )
        return None
    role = fields.text("role", "")
    below, above = fields.number("below", None), fields.number("above", None)
    if over is Over.GROUP:
        part = fields.text(over.value, among=GROUP_PARTS)
        fields.done()
        return GroupFeature(name, over, part=part)
    of = _observation(fields, over, below, above)
    fields.done()
    return None if of is None else GroupFeature(name, over, of, role, parameter)


def _target(section: Fields, label: str, name: str, parameter: str) -> Pick | None:
    fields = section.inner(label)
    if parameter:
        fields.complain(f"a target has no parameter: write `{name}:`")
    role = fields.text("role", "")
    if "number" in fields:
        number = fields.integer("number", least=1)
        fields.done()
        return None if number is None else Pick(name, role=role, number=number)
    over = _over(fields, EXTREMES, "number")
    if over is None:
        return None
    of = _observation(fields, over)
    fields.done()
    return None if of is None else Pick(name, over, of, role)


def _over(fields: Fields, known: tuple[Over, ...], *further: str) -> Over | None:
    found = [over for over in known if over.value in fields]
    if len(found) != 1:
        names = ", ".join([*(over.value for over in known), *further])
        fields.complain(f"needs one of: {names}")
        return None
    return found[0]


def _observation(
    fields: Fields, over: Over, below: float | None = None, above: float | None = None
) -> Observation | None:
    of = fields.raw(over.value)
    if isinstance(of, dict):
        inner = fields.inner(over.value)
        state = inner.text("active")
        inner.done()
        if state is None:
            return None
        found = Observation(active=state)
    elif of in FLAGS:
        found = Observation(flag=of)
    else:
        use = _use(fields, of, over.value)
        if use is None:
            return None
        return Observation(feature=str(use), below=below, above=above)
    if below is not None or above is not None:
        fields.complain("`below:` and `above:` are for features")
    return found
