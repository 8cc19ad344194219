"""Exporting learned behaviors: what is refused, and by which values nothing is decided.

What is decided is compared with the engine in tests/test_exporting.py.
"""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from hitab_core import (
    START,
    ActionBehavior,
    Automaton,
    BasicBehavior,
    BehaviorLibrary,
    Domain,
    Example,
    Feature,
    FeatureKind,
    HandWritten,
    Target,
    Term,
    VocabularyError,
)
from hitab_core.learning import learn_transitions
from hitab_export import LANGUAGES, exported

FEATURES = ("Near", "Role", "Angle")
NEIGHBORS = "sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)"


def nothing(body: object, *targets: object) -> float:
    return 0.0


@pytest.fixture
def library(tmp_path: Path) -> BehaviorLibrary:
    """Return a library with behaviors that can and that cannot be exported."""
    domain = Domain.of(
        "walker",
        "1",
        lambda name: None,
        behaviors=[
            BasicBehavior("Walk"),
            BasicBehavior("Rest"),
            ActionBehavior("GoTo", action_type="nav2_msgs/action/NavigateToPose", action="go"),
        ],
        features=[
            Feature("Near", nothing, FeatureKind.BOOLEAN, required=True),
            Feature("Role", nothing, FeatureKind.CATEGORICAL, categories=("leads", "follows")),
            Feature("Angle", nothing, FeatureKind.TOROIDAL, period=360.0),
        ],
        targets=[Target("home", nothing)],
        automata=[
            Automaton("Pace", (Term("Walk"),), (), {START: HandWritten(lambda: "Walk")}),
        ],
    )
    library = BehaviorLibrary(tmp_path / "library", domain)

    def teach(
        name: str,
        *states: str,
        classifier: str = "tree",
        parameter: str = "",
        leaving: tuple[str, ...] = (),
    ) -> None:
        rows = [((1.0, 0.0, 0.0), states[0]), ((0.0, 0.0, 0.0), states[1])]
        rows += [((0.0, 1.0, 0.0), states[0]), ((0.0, 1.0, 90.0), states[1])]
        examples = tuple(
            Example(state, values, following, number=4 * index + number, command=number)
            for index, state in enumerate(leaving or (START, *states))
            for number, (values, following) in enumerate(rows, 1)
        )
        terms = tuple(map(Term, FEATURES))
        learned = learn_transitions(
            examples, [domain.scale_of(term) for term in terms], classifier
        )
        parameters = (parameter,) if parameter else ()
        used = tuple(map(Term.parse, states))
        automaton = Automaton(name, used, terms, learned, parameters, examples)
        library.save(automaton, classifier=classifier)

    teach("Roam", "Walk", "Rest")
    teach("Begin", "Walk", "Rest", leaving=(START,))
    teach("Bound", "Walk", "Rest", parameter="A")
    teach("Neighborly", "Walk", "Rest", classifier=NEIGHBORS)
    teach("Errand", "GoTo", "Rest")
    teach("Parade", "Pace", "Roam")
    return library


@pytest.mark.parametrize(
    ("behavior", "why"),
    [
        ("Rome", 'Did you mean "Roam"'),
        ("Walk", '"Walk" is a basic behavior.*export a learned one'),
        ("Bound", "takes 1 target, not 0; write, for example, Bound.home."),
        ("Bound(hame)", 'Did you mean "home"'),
        ("Ro am", "write Name or Name.target."),
        (
            "Neighborly",
            '"Neighborly" .*learned by sklearn.*KNeighborsClassifier.*as a tree',
        ),
        ("Errand", '"GoTo" in it is an action.*export a behavior that does without'),
        ("Parade", '"Pace" cannot be exported: it is written by hand.*train a behavior'),
    ],
)
@pytest.mark.parametrize("language", LANGUAGES)
def test_what_cannot_be_exported_is_refused_by_name_with_a_way_out(
    library: BehaviorLibrary, behavior: str, why: str, language: str
) -> None:
    with pytest.raises(VocabularyError, match=why):
        exported(library, behavior, language)


def test_an_unknown_language_is_refused_with_the_known_ones(library: BehaviorLibrary) -> None:
    with pytest.raises(VocabularyError, match=r'Did you mean "python"'):
        exported(library, "Roam", "pyton")


IMPOSSIBLE = (
    {"Near": math.nan, "Role": 0.0, "Angle": 0.0},
    {"Near": 0.0, "Role": 2.0, "Angle": 0.0},
    {"Near": 0.0, "Role": 0.5, "Angle": 0.0},
    {"Near": 0.0, "Role": -1.0, "Angle": 0.0},
    {"Near": 0.0, "Role": 1.0, "Angle": math.inf},
)


@pytest.mark.parametrize("percept", [*IMPOSSIBLE, {"Role": 1.0}, {"Near": None}])
def test_python_decides_nothing_by_impossible_values_and_names_the_feature(
    library: BehaviorLibrary, percept: dict[str, float]
) -> None:
    module: Any = ModuleType("roam")
    exec(exported(library, "Roam", "python"), module.__dict__)
    robot = module.Roam()
    with pytest.raises(ValueError, match=r"(Near|Role|Angle) has"):
        robot.tick(percept, 0.0, float)
    assert robot.path == ["Start"]
    assert robot.tick({"Near": True}, 0.1, float).name == "Walk"


def test_python_does_nothing_without_a_required_value_in_a_state_that_tests_nothing(
    library: BehaviorLibrary,
) -> None:
    module: Any = ModuleType("begin")
    exec(exported(library, "Begin", "python"), module.__dict__)
    robot = module.Begin()
    assert robot.tick({"Near": True}, 0.0, float).name == "Walk"
    with pytest.raises(ValueError, match="Near has no value"):
        robot.tick({"Role": 0.0, "Angle": 0.0}, 0.1, float)
    assert robot.tick({"Near": False}, 0.2, float).name == "Walk"


@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no g++")
def test_cpp_decides_nothing_by_impossible_values(
    library: BehaviorLibrary, tmp_path: Path
) -> None:
    for name in ("Roam", "Begin"):
        (tmp_path / f"{name}.hpp").write_text(exported(library, name, "cpp"))
    tries = "".join(
        f"refused += tries({', '.join(str(v).upper().replace('INF', 'INFINITY') for v in row)});\n"
        for row in (p.values() for p in IMPOSSIBLE)
    )
    (tmp_path / "main.cpp").write_text(
        f"""
        #include "Roam.hpp"
        #include "Begin.hpp"
        int tries(double near, double role, double angle) {{
          hitab_Roam::Behavior robot;
          hitab_Roam::Features features;
          features.Near = near, features.Role = role, features.Angle = angle;
          try {{ robot.tick(features, 0, [] {{ return 0.5; }}); }}
          catch (const std::invalid_argument&) {{ return robot.path()[0] == "Start"; }}
          return 0;
        }}
        bool blind() {{
          hitab_Begin::Behavior robot;
          hitab_Begin::Features features;
          features.Near = 1;
          robot.tick(features, 0, [] {{ return 0.5; }});
          features.Near = NAN;
          try {{ robot.tick(features, 1, [] {{ return 0.5; }}); }}
          catch (const std::invalid_argument&) {{ return robot.path()[0] == "Walk"; }}
          return false;
        }}
        int main() {{
          int refused = tries(1, 0, 0) || !blind() ? -99 : 0;
          {tries} return refused;
        }}
        """
    )
    subprocess.run(["g++", "-std=c++17", "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == len(IMPOSSIBLE)


@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no g++")
@pytest.mark.parametrize(
    ("flags", "compiles"),
    [
        ("-ffast-math", False),
        ("-Ofast", False),
        ("-O2 -ffinite-math-only", False),
        ("-O2 -ffast-math -fno-finite-math-only", True),
    ],
)
def test_cpp_does_not_compile_where_a_missing_value_would_be_taken_for_a_number(
    library: BehaviorLibrary, tmp_path: Path, flags: str, compiles: bool
) -> None:
    (tmp_path / "roam.hpp").write_text(exported(library, "Roam", "cpp"))
    (tmp_path / "main.cpp").write_text("""
        #include "roam.hpp"
        int main() {
          hitab_Roam::Behavior robot;
          try { robot.tick({}, 0, [] { return 0.5; }); }
          catch (const std::invalid_argument&) { return 0; }
          return 1;
        }
    """)
    command = ["g++", "-std=c++17", *flags.split(), "main.cpp", "-o", "main"]
    done = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True, text=True)
    assert (done.returncode == 0) == compiles, done.stderr
    if compiles:
        subprocess.run([tmp_path / "main"], check=True)
    else:
        assert "add -fno-finite-math-only" in done.stderr
