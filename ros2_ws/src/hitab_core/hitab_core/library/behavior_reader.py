"""Reads a behavior file without trusting it; reports every fault by line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hitab_core.automaton import FLAGS, RESERVED, START, Automaton
from hitab_core.domain import Domain, Scale
from hitab_core.errors import HitabError, VocabularyError
from hitab_core.example import Example
from hitab_core.example_codec import example_of
from hitab_core.learning.transition_learning import earlier, learn_transitions
from hitab_core.library.behavior_file import (
    BehaviorFile,
    feature_record,
    file_name,
    meaning_of,
    scale_of,
)
from hitab_core.library.behavior_schema import SUFFIX, check_format, migrated
from hitab_core.library.digests import checksum, learned_digest
from hitab_core.library.example_check import wrong_with
from hitab_core.library.provenance import Provenance
from hitab_core.library.yaml_places import Complaints, Document, read_yaml
from hitab_core.remedies import Do
from hitab_core.transition_function import LearnedTransition
from hitab_core.use import Use
from hitab_core.vocabulary import unknown
from hitab_core.wording import quantity


def read_behavior(
    text: str, file: str, domain: Domain, *, name: str | None = None, accepting: bool = False
) -> BehaviorFile:
    """Read a behavior from the text of its file.

    The transition functions are learned again from the examples and compared with the digests in
    the file. Whether the used behaviors exist is not checked here; the library does that.

    Args:
        text: of the file.
        file: its name, for errors.
        domain: in which it must have been trained.
        name: that it must have; by default that of the file.
        accepting: accept an edited text whatever its digests.

    Raises:
        LibraryError: naming every fault, by line.
    """
    document = read_yaml(text, file)
    check_format(document)
    complaints = Complaints(document)
    if not accepting:
        _check_checksum(document, complaints)
    content: dict[str, Any] = migrated(document.value)
    # Here because pydantic is slow to import.
    from hitab_core.library.behavior_model import BehaviorRecord
    from hitab_core.library.yaml_models import read_record

    if read_record(BehaviorRecord, content, complaints) is None:
        complaints.raise_any()  # what follows relies on the form
    return _Reader(document, content, domain, complaints, accepting).read(
        name or file.removesuffix(SUFFIX), text
    )


def _check_checksum(document: Document, complaints: Complaints) -> None:
    stated = document.value.get("checksum")
    if stated is None:
        return  # the model complains
    if stated != checksum(document.value):
        complaints.add(
            ("checksum",),
            "the checksum does not match the file: it was edited or damaged",
            Do.ACCEPT(file=document.file),
        )


class _Reader:
    def __init__(
        self,
        document: Document,
        content: dict[str, Any],
        domain: Domain,
        complaints: Complaints,
        accepting: bool,
    ) -> None:
        self._document = document
        self._content = content
        self._domain = domain
        self._complaints = complaints
        self._accepting = accepting
        self._before = len(complaints)
        self._accept = Do.ACCEPT(file=document.file)

    def read(self, name: str, text: str) -> BehaviorFile:
        content, complaints = self._content, self._complaints
        self._check_domain()
        self._check_name(name)
        self._check_parameters()
        states = self._states()
        features, scales = self._features()
        self._check_meaning(states, features)
        self._stop_if_wrong()  # examples make no sense without these
        readable, readings = self._readings()
        examples = self._examples([str(state) for state in states], scales, readings)
        self._stop_if_wrong()
        functions, trees = self._learn(content["classifier"], examples, features, scales)
        if trees != content["trees"]:  # perhaps an earlier version has saved it
            for classifier in earlier(content["classifier"]):
                former = self._learn(classifier, examples, features, scales)
                if former[1] == content["trees"]:
                    functions, trees = former
                    content = {**content, "classifier": classifier}
                    break
        if not self._accepting:
            self._check_trees(trees)
            self._check_uses({s.name for s in states if s.name not in FLAGS})
        complaints.raise_any()
        automaton = Automaton(
            content["name"],
            tuple(states),
            tuple(features),
            functions,
            tuple(content["parameters"]),
            tuple(examples),
            content["description"],
            tuple(readable),
        )
        provenance = Provenance(**content["provenance"])
        return BehaviorFile(
            automaton,
            content["classifier"],
            trees,
            dict(content["uses"]),
            provenance,
            learned_digest(content, trees),
            checksum(self._document.value),
            text,
            tuple(self._document.line(("states", i)) for i in range(len(states))),
        )

    def _stop_if_wrong(self) -> None:
        """Stop if anything but the checksum is wrong."""
        if len(self._complaints) > self._before:
            self._complaints.raise_any()

    def _check_domain(self) -> None:
        stated, domain = self._content["domain"]["name"], self._domain.name
        if stated != domain:
            # Nothing else can be right, so stop here.
            self._complaints.add(
                ("domain", "name"),
                f'was trained in domain "{stated}", but this is "{domain}"; '
                "use a library of this domain",
            )
            self._complaints.raise_any()

    def _check_meaning(self, states: Sequence[Use], features: Sequence[Use]) -> None:
        """Check that what it uses means what it did; other words may have come and gone."""
        stated, domain = self._content["domain"], self._domain
        ours = meaning_of(states, features, domain)
        # Files of older formats do not say, and an edited one may use other words than it says.
        knows = stated["signature"] and not self._before
        same = not knows or stated["signature"] == ours["signature"]
        same &= stated["version"] in (ours["version"], domain.version)
        if not same and not self._accepting:
            self._complaints.add(
                ("domain",),
                f'was trained with domain "{domain.name}" version {stated["version"]} (signature '
                f"{stated['signature'] or 'unknown'} of what it uses), but this is version "
                f"{ours['version']} (signature {ours['signature']}); if what it uses no longer "
                "means the same, give it up and train it again",
                self._accept,
            )

    def _check_name(self, expected: str) -> None:
        name = self._content["name"]
        if name != expected:
            self._complaints.add(
                ("name",),
                f'is called "{name}", but the file is called "{self._document.file}"; '
                f'rename the file to "{file_name(name)}", or give the behavior the file\'s name',
            )
        if name in RESERVED:
            self._complaints.add(("name",), f'"{name}" is reserved; choose another name')
        if name in self._domain.behaviors:
            self._complaints.add(
                ("name",),
                f'"{name}" is a basic behavior of domain "{self._domain.name}"; '
                "choose another name",
            )

    def _check_parameters(self) -> None:
        parameters = self._content["parameters"]
        for i, parameter in enumerate(parameters):
            if parameter in self._domain.targets:
                self._complaints.add(
                    ("parameters", i),
                    f'parameter "{parameter}" is also a target; rename it',
                )
            if parameter in parameters[:i]:
                self._complaints.add(
                    ("parameters", i), f'has parameter "{parameter}" twice; remove one'
                )

    def _states(self) -> list[Use]:
        states = self._uses("states", self._content["states"])
        arguments = {*self._domain.targets, *self._content["parameters"]}
        for i, state in enumerate(states):
            if state.name == START:
                self._complaints.add(
                    ("states", i), f"{START} is implicit; remove it from the states"
                )
            elif state.name in FLAGS and state.arguments:
                self._complaints.add(
                    ("states", i), f'flag state "{state.name}" takes no targets; remove them'
                )
            for argument in state.arguments:
                if argument not in arguments:
                    self._complaints.add(
                        ("states", i),
                        unknown("target", argument, arguments, f' in state "{state}"')
                        + "; name one of these, or add it to the parameters",
                    )
        return states

    def _features(self) -> tuple[list[Use], list[Scale]]:
        records = self._content["features"]
        features = self._uses("features", [record["feature"] for record in records])
        scales = []
        for i, (use, record) in enumerate(zip(features, records, strict=True)):
            try:
                self._domain.check_feature(use, self._content["parameters"])
                scales.append(scale_of(use, self._domain))
            except VocabularyError as error:
                way = "correct it, or give the behavior up and train it again"
                self._complaints.add(("features", i), f"{error}; {way}")
                continue
            for key, value in feature_record(use, self._domain).items():
                if key != "feature" and record.get(key) != value:
                    self._complaints.add(
                        ("features", i),
                        f'"{key}" of feature "{use}" is {record.get(key)} here but {value} in '
                        "the domain, so its values mean something else; give it up and train it "
                        "again",
                    )
        return features, scales

    def _uses(self, key: str, texts: Sequence[str]) -> list[Use]:
        uses: list[Use] = []
        for i, text in enumerate(texts):
            try:
                use = Use.parse(text)
            except VocabularyError as error:
                self._complaints.add((key, i), str(error))
                continue
            if use in uses:
                self._complaints.add((key, i), f'has "{use}" twice; remove one')
            uses.append(use)
        if len(uses) < len(texts):
            self._stop_if_wrong()  # positions would no longer fit
        return uses

    def _readings(self) -> tuple[list[Use], dict[int, Sequence[float | None]]]:
        """Return the names of the readings, and the readings by command."""
        # What the domain has no more is not an error here: only who chooses it must have it.
        readable = self._uses("readable", self._content["readable"])
        readings: dict[int, Sequence[float | None]] = {}
        for i, record in enumerate(self._content["readings"]):
            if len(record["values"]) != len(readable):
                self._complaints.add(
                    ("readings", i),
                    f"has {quantity(len(record['values']), 'value')} for "
                    f"{quantity(len(readable), 'name')} in readable; give one for each, or "
                    "remove this line",
                )
            if record["command"] in readings:
                self._complaints.add(
                    ("readings", i), f"has command {record['command']} twice; remove one"
                )
            readings[record["command"]] = record["values"]
        return readable, readings

    def _examples(
        self,
        labels: Sequence[str],
        scales: Sequence[Scale],
        readings: Mapping[int, Sequence[float | None]],
    ) -> list[Example]:
        examples = []
        numbers: dict[int, int] = {}
        for i, record in enumerate(self._content["examples"]):
            example = example_of(record, readings.get(int(record["command"]), ()))
            for wrong in wrong_with(example, labels, scales):
                self._complaints.add(("examples", i), f"example {example.number} {wrong}")
            if example.number in numbers:
                first = self._document.line(("examples", numbers[example.number]))
                self._complaints.add(
                    ("examples", i),
                    f"example number {example.number} is already used at line {first}; "
                    "give each example its own number",
                )
            numbers.setdefault(example.number, i)
            examples.append(example)
        return examples

    def _learn(
        self,
        classifier: str,
        examples: Sequence[Example],
        features: Sequence[Use],
        scales: Sequence[Scale],
    ) -> tuple[Mapping[str, LearnedTransition], dict[str, str]]:
        """Return what is learned for each state, and its digest."""
        names = [str(use) for use in features]
        try:
            functions = learn_transitions(examples, scales, classifier, names)
        except HitabError as error:
            self._complaints.add(("classifier",), f"nothing can be learned: {error}")
            self._complaints.raise_any()
            raise
        return functions, {state: function.digest() for state, function in functions.items()}

    def _check_trees(self, learned: Mapping[str, str]) -> None:
        stated = self._content["trees"]
        for state, digest in learned.items():
            if stated.get(state) != digest:
                self._complaints.add(
                    ("trees", state),
                    f'what is learned for state "{state}" from the examples differs from what was '
                    "saved: they were edited, or this version of HiTAB learns differently",
                    self._accept,
                )
        for state in stated:
            if state not in learned:
                self._complaints.add(
                    ("trees", state), f'there is no example of state "{state}"; remove the line'
                )

    def _check_uses(self, used: Iterable[str]) -> None:
        if {*used} != {*self._content["uses"]}:
            self._complaints.add(
                ("uses",),
                f"lists {', '.join(self._content['uses']) or 'nothing'}, but the states use "
                f"{', '.join(sorted(used)) or 'nothing'}",
                self._accept,
            )
