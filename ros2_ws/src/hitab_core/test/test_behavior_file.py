from __future__ import annotations

import os
import string
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hitab_core.automaton import Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind, Target
from hitab_core.library.behavior_file import BehaviorFile, text_of
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.provenance import Provenance
from hitab_core.library.yaml_places import read_text
from hitab_core.texts.errors import LibraryError

Teach = Callable[..., Automaton]
USES = {"Approach": "0" * 64, "Kick": "basic", "GoTo": "basic"}
fuzzing = settings(max_examples=80, suppress_health_check=[HealthCheck.too_slow])


@pytest.fixture(scope="module")
def text(robot: Domain, control: Automaton) -> str:
    """Return the file of `control`."""
    return written(control, robot)


def written(control: Automaton, robot: Domain) -> str:
    provenance = Provenance(3, "2012-06-18T09:30:00Z", "Ann", "keeper_1", "hitab", "", "")
    return text_of(control, robot, classifier="tree", uses=USES, provenance=provenance)


def complaints_of(text: str, robot: Domain, file: str = "Control.hfa.yaml") -> list[str]:
    with pytest.raises(LibraryError) as refused:
        read_behavior(text, file, robot)
    return str(refused.value).splitlines()


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def edited(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


def says_the_same(one: BehaviorFile, other: Automaton) -> bool:
    automaton = one.automaton
    return (
        (automaton.name, automaton.states, automaton.features, automaton.parameters)
        == (other.name, other.states, other.features, other.parameters)
        and automaton.examples == other.examples
        and automaton.description == other.description
        and one.trees == {s: f.digest() for s, f in other.transitions.items()}  # type: ignore[attr-defined]
    )


def test_a_behavior_comes_back_from_its_file_as_it_was(
    text: str, robot: Domain, control: Automaton
) -> None:
    file = read_behavior(text, "Control.hfa.yaml", robot)
    assert says_the_same(file, control)
    assert file.classifier == "tree"
    assert file.uses == USES
    assert file.provenance.version == 3
    assert file.provenance.agent == "keeper_1"


def test_any_yaml_reader_can_read_a_behavior_file(text: str, control: Automaton) -> None:
    content = yaml.safe_load(text)
    assert content["states"] == list(control.labels)
    assert [tuple(e["features"]) for e in content["examples"]] == [
        e.features for e in control.examples
    ]
    assert content["checksum"] == behavior_checksum(content)


def behavior_checksum(content: dict[str, object]) -> str:
    from hitab_core.library.digests import checksum

    return checksum(content)


@given(data=st.data())
@settings(max_examples=40)
def test_values_and_descriptions_come_back_exactly(
    data: st.DataObject, robot: Domain, teach: Teach
) -> None:
    number = st.floats(allow_nan=False, allow_infinity=False)
    row = st.tuples(
        st.sampled_from(["Start", "GoFast", "Stop"]),
        st.tuples(number, st.sampled_from([0, 1, 2])),
        st.sampled_from(["GoFast", "Stop", "Done"]),
    )
    rows = data.draw(st.lists(row, max_size=12))
    taught = teach("Any", ["DistanceTo(ball)", "Role"], rows)
    automaton = Automaton(
        "Any",
        taught.states,
        taught.features,
        taught.transitions,
        (),
        taught.examples,
        data.draw(st.text()),
    )
    written = text_of(
        automaton,
        robot,
        classifier="tree",
        uses={"GoFast": "basic", "Stop": "basic"},
        provenance=Provenance(author=data.draw(st.text())),
    )
    assert says_the_same(read_behavior(written, "Any.hfa.yaml", robot), automaton)


@given(data=st.data())
@fuzzing
def test_a_damaged_file_is_refused_or_shows_that_it_was_edited_or_says_what_it_said(
    data: st.DataObject, text: str, robot: Domain, control: Automaton
) -> None:
    damaged = bytearray(text.encode())
    match data.draw(st.sampled_from(["cut", "bytes", "insert", "remove", "swap lines"])):
        case "cut":
            del damaged[data.draw(st.integers(0, len(damaged) - 1)) :]
        case "bytes":
            for _ in range(data.draw(st.integers(1, 4))):
                place = data.draw(st.integers(0, len(damaged) - 1))
                damaged[place] = data.draw(st.integers(0, 255))
        case "insert":
            place = data.draw(st.integers(0, len(damaged)))
            damaged[place:place] = data.draw(
                st.text("{}[]:,&*!|>'\"%@`#-? \n\t0123456789.eE+" + string.ascii_letters)
            ).encode()
        case "remove":
            place = data.draw(st.integers(0, len(damaged) - 1))
            del damaged[place : place + data.draw(st.integers(1, 200))]
        case _:
            lines = text.splitlines(keepends=True)
            i, j = (data.draw(st.integers(0, len(lines) - 1)) for _ in range(2))
            lines[i], lines[j] = lines[j], lines[i]
            damaged = bytearray("".join(lines).encode())
    with suppress(UnicodeDecodeError, LibraryError):
        file = read_behavior(damaged.decode(), "Control.hfa.yaml", robot)
        assert file.edits or says_the_same(file, control)


@given(st.text(max_size=300) | st.binary(max_size=300).map(lambda data: data.decode("latin-1")))
@fuzzing
def test_anything_that_is_no_behavior_file_is_refused(robot: Domain, text: str) -> None:
    with pytest.raises(LibraryError, match=r"^Some\.hfa\.yaml"):
        read_behavior(text, "Some.hfa.yaml", robot)


@given(data=st.data())
@fuzzing
def test_an_edited_file_is_refused_or_makes_an_automaton(
    data: st.DataObject, text: str, robot: Domain
) -> None:
    words = [
        "Start",
        "Kick",
        "Done",
        ".nan",
        "-.inf",
        "1e999",
        "''",
        "[]",
        "{}",
        "null",
        "-1",
        "GoTo()",
        "GoTo(ball, ball)",
        "true",
        "tree(max_depth=-1)",
        "default",
        "3.5",
        "Control",
        "Approach",
    ]
    tokens = text.split(" ")
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(tokens) - 1))
        end = "".join(c for c in tokens[place] if c in ",]}\n")
        tokens[place] = data.draw(st.sampled_from(words)) + end
    try:
        file = read_behavior(" ".join(tokens), "Control.hfa.yaml", robot)
    except LibraryError:
        return
    for example in file.automaton.examples:
        assert len(example.features) == len(file.automaton.features)
        assert float("inf") not in map(abs, example.features), "null: a value is missing"


def test_a_file_edited_by_hand_is_what_it_says_and_shows_that_it_was_edited(
    text: str, robot: Domain
) -> None:
    file = read_behavior(edited(text, "author: Ann", "author: Bob"), "Control.hfa.yaml", robot)
    assert file.provenance.author == "Bob"
    line = line_of(text, "checksum:")
    assert file.edits == (
        f"Control.hfa.yaml:{line}: the file was edited or damaged after it was saved",
    )
    assert read_behavior(text, "Control.hfa.yaml", robot).edits == ()


def test_comments_and_spaces_may_be_changed(text: str, robot: Domain) -> None:
    changed = edited(text, "examples:", "# a note\n\nexamples:").replace("\n", "\r\n")
    assert read_behavior(changed, "Control.hfa.yaml", robot) == read_behavior(
        text, "Control.hfa.yaml", robot
    )


@pytest.mark.parametrize(
    ("old", "new", "at", "complaint"),
    [
        ("next_state: Approach,", "next_state: Aproach,", "next_state: Aproach",
         'goes to "Aproach", which is not a listed state (known: Approach, Done, GoTo(goal)'),
        ("{number: 1, state: Start,", "{number: 1, state: Begin,", "Begin",
         'example 1 is of state "Begin", which is not listed'),
        ("0.1,  10.0, 1, 0]", "0.1,  10.0, 1]", "0.1,  10.0, 1]",
         "example 3 has 3 values for 4 features"),
        ("0.1,  10.0, 1, 0]", "far,  10.0, 1, 0]", "far",
         'must be a number or null, not the text "far"'),
        ("0.1,  10.0, 1, 0]", "1e400,  10.0, 1, 0]", "1e400", "example 3 has inf as value 1"),
        ("0.1,  10.0, 1, 0]", "0.1,  10.0, 2, 0]", "10.0, 2", "boolean: 0 or 1"),
        ("0.1,  10.0, 1, 0]", "0.1,  10.0, 1, 3]", "10.0, 1, 3]", "a category: 0 to 2"),
        ("{number: 3,", "{number: 1,", "{number: 1, state: Approach, ",
         "example number 1 is already used at line"),
        ("- GoTo(goal)", "- GoTo(moon)", "- GoTo(moon)",
         'unknown target "moon" in state "GoTo(moon)" (known: ball, goal)'),
        ("- GoTo(goal)", "- Kick", "  - Kick\n\nfeatures", 'has "Kick" twice'),
        ("- Done", "- Start", "- Start", "Start is implicit; remove it"),
        ("DirectionTo(goal), kind", "Direction(goal), kind", "Direction(goal)",
         'unknown feature "Direction" (known: BallIsKickable, DirectionTo, DistanceTo, Done'),
        ("period: 360.0", "period: 400.0", "period: 400",
         '"period" of feature "DirectionTo(goal)" is 400.0 here but 360.0 in the domain'),
        ("unit: m}", "unit: cm}", "unit: cm", '"unit" of feature "DistanceTo(ball)" is cm here'),
        ("classifier: tree", "classifier: tree(depth=3)", "classifier: ",
         'nothing can be learned: the classifier "tree" has no parameter "depth"'),
        ("parameters: []", "parameters: [ball]", "parameters:", "is also a target"),
        ("name: Control", "name: Attack", "name: Attack",
         'is called "Attack", but the file is called "Control.hfa.yaml"'),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_reported_by_line(
    text: str, robot: Domain, old: str, new: str, at: str, complaint: str
) -> None:
    wrong = edited(text, old, new)
    found = [line for line in complaints_of(wrong, robot) if complaint in line]
    assert found
    assert found[0].startswith(f"Control.hfa.yaml:{line_of(wrong, at)}: ")


def test_trees_are_learned_again_and_a_difference_is_shown(
    text: str, robot: Domain, control: Automaton
) -> None:
    digest = control.transitions["Approach"].digest()  # type: ignore[attr-defined]
    file = read_behavior(edited(text, digest, "f" * 64), "Control.hfa.yaml", robot)
    assert says_the_same(file, control)
    tree, _ = file.edits  # the checksum is another one, too
    assert tree.startswith(f"Control.hfa.yaml:{line_of(text, digest)}: what is learned for state")
    assert '"Approach" differs from what was saved' in tree


def test_a_file_that_was_cut_off_says_so(text: str, robot: Domain) -> None:
    at_a_line = text[: text.index("provenance:")]
    assert complaints_of(at_a_line, robot) == [
        f"Control.hfa.yaml:3: `{key}:` is missing here; add it, or was the file cut off?"
        for key in ("checksum", "provenance")
    ]
    assert "was cut off" in complaints_of(text[: text.index("next_state: ") + 4], robot)[0]


@pytest.mark.parametrize(
    ("found", "reason"), [("2", "of format 3"), ("4", "reads up to 3"), ("true", "of format 3")]
)
def test_a_file_of_another_format_is_refused_with_nothing_else_said(
    text: str, robot: Domain, found: str, reason: str
) -> None:
    complaints = complaints_of(edited(text, "format: 3", f"format: {found}"), robot)
    assert len(complaints) == 1
    assert reason in complaints[0]


def test_sections_that_a_later_hitab_may_add_are_kept_out_of_what_is_learned(
    text: str, robot: Domain, control: Automaton
) -> None:
    added = edited(text, "\nprovenance:", "\noptional: {checks: [{never: Kick}]}\nprovenance:")
    added = edited(added, "cycle: 10,", "cycle: 10, optional: {weight: 2.0},")
    content = yaml.safe_load(added)
    added = edited(added, content["checksum"], behavior_checksum(content))
    read = read_behavior(added, "Control.hfa.yaml", robot)
    assert says_the_same(read, control)
    assert read.learned == read_behavior(text, "Control.hfa.yaml", robot).learned


def test_a_file_of_another_domain_is_refused_with_nothing_else_said(
    text: str, robot: Domain
) -> None:
    other = Domain.of("boat", "1", robot.body, behaviors=[], features=[])
    assert complaints_of(text, other) == [
        f'Control.hfa.yaml:{line_of(text, "domain:")}: was trained in domain "small_robot", '
        'but this is "boat"; use a library of this domain'
    ]


def test_a_file_whose_feature_now_means_something_else_is_not_accepted(
    text: str, robot: Domain
) -> None:
    features = {
        **robot.features,
        "BallIsKickable": Feature("BallIsKickable", float, FeatureKind.CONTINUOUS),
    }
    changed = Domain.of(
        robot.name,
        "2",
        robot.body,
        behaviors=robot.behaviors.values(),
        features=features.values(),
        targets=robot.targets.values(),
    )
    with pytest.raises(LibraryError, match='"kind" of feature "BallIsKickable" is boolean here'):
        read_behavior(text, "Control.hfa.yaml", changed)


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda path: path.write_bytes(b"format: 1\nname: \xff\n"), ":2: is not UTF-8 text"),
        (os.mkfifo, "is a pipe"),
        (lambda path: path.mkdir(), "cannot read it: Is a directory; it is a folder"),
        (lambda path: None, "cannot read it: No such file or directory; check the path"),
    ],
)
def test_a_file_that_cannot_be_read_is_named(
    tmp_path: Path, robot: Domain, make: Callable[[Path], object], complaint: str
) -> None:
    path = tmp_path / "Control.hfa.yaml"
    make(path)
    with pytest.raises(LibraryError) as refused:
        read_behavior(read_text(path), path.name, robot)
    assert "Control.hfa.yaml" in str(refused.value)
    assert complaint in str(refused.value)


def test_a_hand_written_automaton_cannot_be_stored(robot: Domain) -> None:
    from hitab_core.transition_function import HandWritten

    automaton = Automaton("Fixed", (), (), {"Start": HandWritten(lambda: "Start")})
    with pytest.raises(LibraryError, match="was not learned from examples"):
        text_of(automaton, robot, classifier="tree", uses={}, provenance=Provenance())


def test_a_library_is_read_without_scikit_learn_or_matplotlib() -> None:
    code = (
        "import sys; import hitab_core.library.behavior_library, hitab_core.library.bundle; "
        "import hitab_core.learning.trimming; "
        "import hitab_core.drawing.text, hitab_core.drawing.picture; "
        "print([m for m in ('sklearn', 'matplotlib', 'scipy', 'rclpy') if m in sys.modules])"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert found.stdout.strip() == "[]"


def test_words_can_be_added_to_a_domain_as_long_as_those_in_use_stay_as_they_are(
    text: str, robot: Domain, control: Automaton
) -> None:
    def domain(*behaviors: BasicBehavior, features: Sequence[Feature] = ()) -> Domain:
        return Domain.of(
            robot.name,
            robot.version,
            robot.body,
            behaviors=(robot.behaviors | {b.name: b for b in behaviors}).values(),
            features=[*robot.features.values(), *features],
            targets=[*robot.targets.values(), Target("dock", lambda body: 2)],
        )

    grown = domain(BasicBehavior("Beep"), features=[Feature("Battery", float)])
    unused = domain(BasicBehavior("GoSlow", one_shot=True))
    for added in (grown, unused):
        assert says_the_same(read_behavior(text, "Control.hfa.yaml", added), control)

    changed = domain(BasicBehavior("Kick", one_shot=False))
    complaint = complaints_of(text, changed)[0]
    assert "of its parts), but this is version 1" in complaint
    assert "if its parts still mean the same, write that here" in complaint
    old, new = (
        yaml.safe_load(one)["domain"]["signature"] for one in (text, written(control, changed))
    )
    added = edited(text, 'description: ""', 'description: "mine"')
    said = read_behavior(added, "Control.hfa.yaml", changed).edits
    assert "the signature is not that of the words that it uses" in said[0], "edits count"
    stated = edited(text, old, new)
    assert says_the_same(read_behavior(stated, "Control.hfa.yaml", changed), control)
