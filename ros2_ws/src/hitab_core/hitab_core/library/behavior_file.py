"""A stored behavior: the automaton, how it was learned, and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from hitab_core.automaton import FLAGS, Automaton
from hitab_core.codec import plain_values, to_dict
from hitab_core.domain import Domain, FeatureKind
from hitab_core.example import CYCLE_MAX, Example
from hitab_core.learning.transition_learning import rules_of
from hitab_core.library.behavior_text import behavior_text
from hitab_core.library.digests import checksum
from hitab_core.library.expectation import KEY, Expectation, broken_expectations
from hitab_core.library.provenance import Provenance
from hitab_core.term import Term
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.wording import quantity

BEHAVIOR_FORMAT = 3
"""The format version that is written, and the only one that is read."""

FLAG = "flag"
"""The kind of a feature that is true if the active sub-behavior has raised a flag."""

BEHAVIOR_SUFFIX = ".hfa.yaml"
"""Ending of a behavior file's name."""

BASIC = "basic"
"""Marks a used behavior that is hard-coded in the robot."""

HAND_WRITTEN = "hand-written"
"""Marks a used automaton that comes with the domain."""


@dataclass(frozen=True, slots=True, weakref_slot=True)
class BehaviorFile:
    """The contents of a behavior file. Equal checksums mean equal contents.

    Attributes:
        automaton: automaton with transition functions learned from its examples.
        classifier: classifier that learns them, see `hitab_core.learning.transition_learning`.
        trees: digest of each state's transition function.
        uses: checksum of each used behavior's file when this one was saved, or ``"basic"``, or
            ``"hand-written"``. For information only: a used behavior may be retrained.
        provenance: origin of the behavior.
        learned: digest of the learned automaton; see `hitab_core.library.digests.learned_digest`.
        checksum: SHA-256 of the contents.
        text: text of the file.
        state_lines: line of each state, in the automaton's order.
        expectations: stored in the file.
        edits: signs of edits after it was saved, by line.
    """

    automaton: Automaton = field(compare=False)
    classifier: str = field(compare=False)
    trees: Mapping[str, str] = field(compare=False)
    uses: Mapping[str, str] = field(compare=False)
    provenance: Provenance = field(compare=False)
    learned: str = field(compare=False)
    checksum: str
    text: str = field(compare=False, repr=False)
    state_lines: tuple[int, ...] = field(compare=False, repr=False)
    expectations: tuple[Expectation, ...] = field(default=(), compare=False)
    edits: tuple[str, ...] = field(default=(), compare=False)

    @property
    def name(self) -> str:
        """Name of the behavior."""
        return self.automaton.name

    @property
    def broken(self) -> list[str]:
        """Broken expectations, with the actual decisions, by line."""
        return broken_expectations(self.expectations, self.automaton, file_name(self.name))


def file_name(name: str) -> str:
    """Return the name of the file of the behavior called ``name``."""
    return name + BEHAVIOR_SUFFIX


def meaning_of(states: Sequence[Term], features: Sequence[Term], domain: Domain) -> dict[str, str]:
    """Return the version and the signature of the words of a domain that an automaton uses."""
    behaviors, read = {state.name for state in states}, {feature.name for feature in features}
    targets = {target for term in (*states, *features) for target in term.arguments}
    of = domain.version_of
    return {
        "version": domain.version if of is None else of(behaviors | read | targets),
        "signature": domain.signature_of(behaviors, read, targets),
    }


def feature_record(term: Term, domain: Domain) -> dict[str, Any]:
    """Return a feature's entry in a file: all that is needed to interpret its values."""
    if term.name in FLAGS:
        return {"feature": str(term), "kind": FLAG}
    feature = domain.feature(term.name)
    record: dict[str, Any] = {"feature": str(term), "kind": feature.kind.value}
    if feature.unit:
        record["unit"] = feature.unit
    if feature.kind is FeatureKind.TOROIDAL:
        record["period"] = float(feature.period)
    if feature.kind is FeatureKind.CATEGORICAL:
        record["categories"] = list(feature.categories)
    return record


def text_of(
    automaton: Automaton,
    domain: Domain,
    *,
    classifier: str,
    uses: Mapping[str, str],
    provenance: Provenance,
    expectations: Sequence[Expectation] = (),
) -> str:
    """Return the file of an automaton.

    Raises:
        LibraryError: if a transition function was not learned, which cannot be stored.
    """
    content: dict[str, Any] = {
        "format": BEHAVIOR_FORMAT,
        "name": automaton.name,
        "description": automaton.description,
        "domain": {
            "name": domain.name,
            **meaning_of(automaton.states, automaton.features, domain),
        },
        "parameters": list(automaton.parameters),
        "states": list(automaton.labels),
        "features": [feature_record(feature, domain) for feature in automaton.features],
        "classifier": classifier,
        "examples": _examples(automaton, domain),
        "trees": _digests(automaton),
        "uses": {name: uses[name] for name in sorted(automaton.behaviors_used)},
        **_readings(automaton),
        "provenance": asdict(provenance),
    }
    optional = {
        KEY: [to_dict(one, ["line"]) for one in expectations],
        "chosen": [str(term) for term in automaton.chosen],
        "numbers": [
            {"example": e.number, "values": list(e.numbers)}
            for e in automaton.examples
            if e.numbers
        ],
    }
    if any(optional.values()):
        content["optional"] = {key: entries for key, entries in optional.items() if entries}
    return behavior_text(content | {"checksum": checksum(content)}, rules_of(automaton))


def _readings(automaton: Automaton) -> dict[str, Any]:
    """Return the readings of each command, which all its examples share."""
    by_command = {e.command: e.readings for e in automaton.examples if e.readings}
    return {
        "readable": [str(term) for term in automaton.readable] if by_command else [],
        "readings": [
            {"command": command, "values": plain_values(readings)}
            for command, readings in by_command.items()
        ],
    }


def _digests(automaton: Automaton) -> dict[str, str]:
    digests = {}
    for state, function in automaton.transitions.items():
        digest = getattr(function, "digest", None)
        if digest is None:
            raise LibraryError(
                f'"{automaton.name}" cannot be saved: the transition function of "{state}" was '
                "not learned from examples; a hand-written automaton belongs to its domain"
            )
        digests[state] = str(digest())
    return digests


def _examples(automaton: Automaton, domain: Domain) -> list[dict[str, Any]]:
    kinds = [domain.scale_of(feature).kind for feature in automaton.features]
    for example in automaton.examples:
        if len(example.features) != len(kinds):
            raise LibraryError(
                f'"{automaton.name}" cannot be saved: example {example.number} has '
                f"{quantity(len(example.features), 'value')} for "
                f"{quantity(len(kinds), 'feature')}; delete it"
            )
        if example.cycle > CYCLE_MAX:
            raise LibraryError(
                f'"{automaton.name}" cannot be saved: example {example.number} is of cycle '
                f"{example.cycle}, and no world counts beyond {CYCLE_MAX}; delete it"
            )
    counted = [not kind.is_measured for kind in kinds]
    return [_example(example, counted) for example in automaton.examples]


def _example(example: Example, counted: Sequence[bool]) -> dict[str, Any]:
    """Return an example's entry; ``counted`` tells the features with whole numbers."""
    values = [
        int(value) if whole and value is not None and value.is_integer() else value
        for value, whole in zip(plain_values(map(float, example.features)), counted, strict=True)
    ]
    record = to_dict(example, ["readings", "numbers"])
    return {"number": example.number, **record, "features": values}
