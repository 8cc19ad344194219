"""Reads a behavior file without trusting it; reports every fault by line."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hitab_core.automaton import FLAGS, RESERVED_NAMES, START, Automaton
from hitab_core.codec import from_dict
from hitab_core.domain import Domain, FeatureKind, Scale
from hitab_core.example import Example
from hitab_core.learning.transition_learning import learn_transitions
from hitab_core.library.behavior_file import (
    BEHAVIOR_FORMAT,
    BEHAVIOR_SUFFIX,
    BehaviorFile,
    feature_record,
    file_name,
    meaning_of,
)
from hitab_core.library.digests import checksum, learned_digest
from hitab_core.library.expectation import KEY, Expectation
from hitab_core.library.provenance import Provenance
from hitab_core.library.yaml_places import Complaints, Document, Place, read_yaml
from hitab_core.number import wrong_with
from hitab_core.regression import learn_numbers
from hitab_core.term import Term
from hitab_core.texts.errors import HitabError, VocabularyError, newer_format
from hitab_core.texts.vocabulary import has, unknown
from hitab_core.texts.wording import quantity
from hitab_core.transition_function import LearnedTransition


def read_behavior(
    text: str, file: str, domain: Domain, *, name: str | None = None
) -> BehaviorFile:
    """Read a behavior from the text of its file.

    The transition functions are learned again from the examples. The contents of an edited file
    count; its digests only reveal the edit. The existence of used behaviors is not checked here;
    the library does that.

    Args:
        text: text of the file.
        file: name of the file, for errors.
        domain: domain in which it must have been trained.
        name: required name of the behavior; by default the name of the file.

    Raises:
        LibraryError: naming every fault, by line.
    """
    document = read_yaml(text, file)
    content, complaints = document.value, Complaints(document)
    _check_format(content, complaints)
    # Here because pydantic is slow to import.
    from hitab_core.library.behavior_model import BehaviorRecord
    from hitab_core.library.yaml_models import read_record

    record = read_record(BehaviorRecord, content, complaints)
    if record is None:
        complaints.raise_any()  # the checks below rely on the form
    reader = _Reader(document, record, domain, complaints)
    return reader.read(name or file.removesuffix(BEHAVIOR_SUFFIX), text)


def _check_format(content: Any, complaints: Complaints) -> None:
    found = content.get("format") if isinstance(content, dict) else None
    if found == BEHAVIOR_FORMAT and not isinstance(found, bool):
        return
    wrong = f"is not a behavior file of format {BEHAVIOR_FORMAT}, the one that this HiTAB reads"
    if isinstance(found, int) and found > BEHAVIOR_FORMAT:
        wrong = newer_format(found, BEHAVIOR_FORMAT)
    complaints.add(("format",), f"{wrong}, or save the behavior with the version that wrote it")
    complaints.raise_any()


@dataclass
class _Reader:
    _document: Document
    _record: Any
    _domain: Domain
    _complaints: Complaints

    def __post_init__(self) -> None:
        self._content: dict[str, Any] = self._document.value
        self._checksum = checksum(self._content)

    def read(self, name: str, text: str) -> BehaviorFile:
        content = self._content
        self._check_domain()
        self._check_names(name)
        states = self._states()
        features, scales = self._features()
        self._check_meaning(states, features)
        self._complaints.raise_any()  # examples make no sense without these
        readable, readings = self._readings()
        examples = self._examples(states, scales, readings)
        expectations = self._expectations()
        self._complaints.raise_any()
        functions = self._learn(examples, features, scales)
        trees = {state: function.digest() for state, function in functions.items()}
        automaton = Automaton(
            content["name"],
            tuple(states),
            tuple(features),
            functions,
            tuple(content["parameters"]),
            tuple(examples),
            content["description"],
            tuple(readable),
            tuple(dict.fromkeys(self._record.optional.chosen)),
            learn_numbers(states, scales, examples, self._domain.numbers_of),
        )
        return BehaviorFile(
            automaton,
            content["classifier"],
            trees,
            dict(content["uses"]),
            Provenance(**content["provenance"]),
            learned_digest(content, examples, trees),
            self._checksum,
            text,
            tuple(self._document.line(("states", i)) for i in range(len(states))),
            expectations,
            self._edits(trees),
        )

    def _complain(self, wrong: str, *path: str | int) -> None:
        self._complaints.add(path, wrong)

    def _check_domain(self) -> None:
        stated, domain = self._content["domain"]["name"], self._domain.name
        if stated != domain:  # nothing else can be right
            self._complain(
                f'was trained in domain "{stated}", but this is "{domain}"; '
                "use a library of this domain",
                "domain",
                "name",
            )
            self._complaints.raise_any()

    def _check_meaning(self, states: Sequence[Term], features: Sequence[Term]) -> None:
        """Check that all used words mean the same as before; unused ones may have changed."""
        stated, domain = self._content["domain"], self._domain
        ours = meaning_of(states, features, domain)
        # An edited file may use other words than when it was saved; `_edits` shows that.
        self._same_words = stated["signature"] == ours["signature"]
        same = self._same_words or self._is_edited
        if not same or stated["version"] not in (ours["version"], domain.version):
            self._complain(
                f'was trained with domain "{domain.name}" version {stated["version"]} (signature '
                f"{stated['signature']} of its parts), but this is version {ours['version']} "
                f"(signature {ours['signature']}); if its parts still mean the same, write that "
                "here, and otherwise give it up and train it again",
                "domain",
            )

    def _check_names(self, expected: str) -> None:
        name, domain = self._content["name"], self._domain
        if name != expected:
            self._complain(
                f'is called "{name}", but the file is called "{self._document.file}"; '
                f'rename the file to "{file_name(name)}", or give the behavior the file\'s name',
                "name",
            )
        if name in RESERVED_NAMES or name in domain.behaviors:
            self._complain(
                f'"{name}" is a basic behavior of domain "{domain.name}", or reserved; '
                "choose another name",
                "name",
            )
        parameters = self._content["parameters"]
        for i, parameter in enumerate(parameters):
            if parameter in domain.targets or parameter in (*RESERVED_NAMES, *parameters[:i]):
                self._complain(
                    f'parameter "{parameter}" is also a target, reserved, or there twice; '
                    "rename it",
                    "parameters",
                    i,
                )

    def _states(self) -> list[Term]:
        states: list[Term] = self._record.states
        self._check_distinct("states", states)
        arguments = {*self._domain.targets, *self._content["parameters"]}
        for i, state in enumerate(states):
            if state.name == START:
                self._complain(f"{START} is implicit; remove it from the states", "states", i)
            elif state.name in FLAGS and state.arguments:
                self._complain(f'flag "{state.name}" takes no targets; remove them', "states", i)
            for argument in state.arguments:
                if argument not in arguments:
                    wrong = unknown("target", argument, arguments, f' in state "{state}"')
                    self._complain(
                        f"{wrong}; name one of these, or add it to the parameters", "states", i
                    )
        return states

    def _features(self) -> tuple[list[Term], list[Scale]]:
        records = self._content["features"]
        features: list[Term] = [record.feature for record in self._record.features]
        self._check_distinct("features", features)
        scales = []
        for i, (term, record) in enumerate(zip(features, records, strict=True)):
            try:
                self._domain.check_feature(term, self._content["parameters"])
                scales.append(self._domain.scale_of(term))
            except VocabularyError as error:
                way = "correct it, or give the behavior up and train it again"
                self._complain(f"{error}; {way}", "features", i)
                continue
            for key, value in feature_record(term, self._domain).items():
                if key != "feature" and record.get(key) != value:
                    self._complain(
                        f'"{key}" of feature "{term}" is {record.get(key)} here but {value} in '
                        "the domain, so its values mean something else; give it up and train it "
                        "again",
                        "features",
                        i,
                    )
        return features, scales

    def _check_distinct(self, key: str, uses: Sequence[Term]) -> None:
        for i, term in enumerate(uses):
            if term in uses[:i]:
                self._complain(f'has "{term}" twice; remove one', key, i)

    def _readings(self) -> tuple[list[Term], dict[int, Sequence[float | None]]]:
        """Return the names of the readings, and the readings by command."""
        # A word that the domain no longer has is no error here; choosing it is.
        readable: list[Term] = self._record.readable
        self._check_distinct("readable", readable)
        readings: dict[int, Sequence[float | None]] = {}
        for i, record in enumerate(self._content["readings"]):
            if len(record["values"]) != len(readable) or record["command"] in readings:
                self._complain(
                    f"has {quantity(len(record['values']), 'value')} for "
                    f"{quantity(len(readable), 'name')} in readable, or its command is there "
                    "twice; remove this line",
                    "readings",
                    i,
                )
            readings[record["command"]] = record["values"]
        return readable, readings

    def _examples(
        self,
        states: Sequence[Term],
        scales: Sequence[Scale],
        readings: Mapping[int, Sequence[float | None]],
    ) -> list[Example]:
        examples = []
        labels = [str(state) for state in states]
        given = {record.example: record.values for record in self._record.optional.numbers}
        wanted = {str(state): self._domain.numbers_of(state) for state in states}
        first_at: dict[int, int] = {}
        for i, record in enumerate(self._content["examples"]):
            values = readings.get(int(record["command"]), ())
            numbers = given.pop(int(record["number"]), ())
            example = from_dict(Example, {**record, "readings": values, "numbers": numbers})
            for wrong in wrong_with(numbers, wanted.get(example.next_state, ())):
                self._complain(f"example {example.number} {wrong}", "optional", "numbers")
            for wrong in _wrong_with(example, labels, scales):
                self._complain(f"example {example.number} {wrong}", "examples", i)
            if example.number in first_at:
                first = self._document.line(("examples", first_at[example.number]))
                self._complain(
                    f"example number {example.number} is already used at line {first}; "
                    "give each example its own number",
                    "examples",
                    i,
                )
            first_at.setdefault(example.number, i)
            examples.append(example)
        for number in given:
            wrong = f"example {number} has numbers, but is not listed; remove them"
            self._complain(wrong, "optional", "numbers")
        return examples

    def _expectations(self) -> tuple[Expectation, ...]:
        found: dict[str, Expectation] = {}
        for i, read in enumerate(self._record.optional.expectations):
            place = ("optional", KEY, i)
            if read.name in found:
                self._complain(f'expectation "{read.name}" is there twice; rename one', *place)
            line = self._document.line(place)
            found[read.name] = Expectation(**read.model_dump(), line=line)
        return tuple(found.values())

    def _learn(
        self, examples: Sequence[Example], features: Sequence[Term], scales: Sequence[Scale]
    ) -> Mapping[str, LearnedTransition]:
        names = [str(term) for term in features]
        try:
            return learn_transitions(examples, scales, self._content["classifier"], names)
        except HitabError as error:
            self._complain(f"nothing can be learned: {error}", "classifier")
            self._complaints.raise_any()
            raise

    @property
    def _is_edited(self) -> bool:
        return bool(self._checksum != self._content["checksum"])

    def _edits(self, learned: Mapping[str, str]) -> tuple[str, ...]:
        """Return the differences from the saved version, by line."""
        stated = self._content["trees"]
        places = [("trees", state) for state in stated.keys() | learned.keys()]
        found: list[tuple[Place, str]] = [
            (
                place,
                f'what is learned for state "{place[1]}" differs from what was saved: its '
                "examples were edited, or this version of HiTAB learns differently",
            )
            for place in places
            if stated.get(place[1]) != learned.get(place[1])
        ]
        if not self._same_words:
            found += [(("domain",), "the signature is not that of the words that it uses")]
        if self._is_edited:
            found += [(("checksum",), "the file was edited or damaged after it was saved")]
        by_line = sorted((self._document.line(place), text) for place, text in found)
        return tuple(f"{self._document.file}:{line}: {text}" for line, text in by_line)


def _wrong_with(example: Example, labels: Sequence[str], scales: Sequence[Scale]) -> Iterable[str]:
    """Yield the faults of an example, which may be edited by hand, worded to follow its number."""
    state, to = example.state, example.next_state
    if state not in (START, *labels):
        yield f'is of state "{state}", which is not listed {has([START, *labels], state)}'
    if to not in labels:
        yield f'goes to "{to}", which is not a listed state {has(labels, to)}'
    if example.is_default and to != state:
        yield "is a default example, but leaves its state; make it a demonstrated one"
    if len(example.features) != len(scales):
        there, wanted = len(example.features), len(scales)
        yield (
            f"has {quantity(there, 'value')} for {quantity(wanted, 'feature')}; give one for each"
        )
        return
    for i, (value, scale) in enumerate(zip(example.features, scales, strict=True), 1):
        if math.isnan(value):
            continue  # missing
        most = len(scale.categories) - 1 if scale.categories else math.inf
        if math.isinf(value):
            yield f"has {value} as value {i}; write a finite number, or delete the example"
        elif scale.kind is FeatureKind.BOOLEAN and value not in (0.0, 1.0):
            yield f"has {value:g} as value {i}, which is boolean: 0 or 1"
        elif scale.kind is FeatureKind.CATEGORICAL and not (
            value.is_integer() and 0 <= value <= most
        ):
            yield f"has {value:g} as value {i}, which is a category: 0 to {most}"
