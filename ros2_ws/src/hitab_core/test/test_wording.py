"""Texts that hold numbers say them in plain English."""

import ast
import re
from pathlib import Path

import pytest

from hitab_core.wording import LONG, gist, in_lines, quantity, said_of

SOURCES = Path(__file__).parents[2]
PLURAL = re.compile(r" ([a-z]+ )?[a-z]+s\b")
OTHERS = re.compile(r" (is|has|was|does|needs|bytes|characters|items|snapshots)\b")
"""Verbs, and what is counted only where it is too much."""


def test_one_thing_is_in_the_singular():
    assert quantity(1, "example") == "1 example"
    assert quantity(0, "example") == "0 examples"
    assert quantity(2, "process", "processes") == "2 processes"
    assert quantity(1, "process", "processes") == "1 process"


def test_a_text_that_begins_with_the_name_does_not_get_it_again():
    assert said_of("keeper_1", "keeper_1 is idle") == "keeper_1 is idle"
    assert said_of("keeper_1", "keeper_10 is idle") == "keeper_1: keeper_10 is idle"
    assert said_of("keeper_1", "unknown mode") == "keeper_1: unknown mode"


def test_a_long_text_is_shown_with_its_remedies_below_each_other():
    what = "a" * LONG
    assert in_lines(f"{what}; do this; or that") == f"{what};\n  do this;\n  or that"
    assert in_lines("short; as it is") == "short; as it is"
    assert in_lines(f"short; line\n{what}; do this") == f"short; line\n{what};\n  do this"


def test_the_gist_of_a_long_text_says_where_the_rest_is():
    what = "a" * LONG
    text = f"{what}; bring it back with `hitab library restore A 1 -l lib`"
    assert gist(text) == f"{what}; see `hitab library check`"
    assert gist(f"{what}; call the doctor") == f"{what}; call the doctor"
    taken_out = f"{what}; train it with `hitab train AGENT A`, or use `hitab library import`"
    assert gist(taken_out) == taken_out, "`hitab library check` does not tell of it"
    assert gist("short; see `hitab library list`") == "short; see `hitab library list`"


def modules() -> list[Path]:
    return sorted(p for p in SOURCES.glob("*/*/**/*.py") if "test" not in p.parts)


@pytest.mark.parametrize("package", sorted({p.relative_to(SOURCES).parts[0] for p in modules()}))
def test_a_length_that_may_be_one_never_stands_before_a_plural(package):
    """Else it says "1 examples"; `quantity` knows the singular."""
    wrong = []
    for path in modules():
        if path.relative_to(SOURCES).parts[0] != package:
            continue
        for text in ast.walk(ast.parse(path.read_text())):
            if not isinstance(text, ast.JoinedStr):
                continue
            for value, behind in zip(text.values, text.values[1:], strict=False):
                if (
                    isinstance(value, ast.FormattedValue)
                    and isinstance(value.value, ast.Call)
                    and getattr(value.value.func, "id", "") == "len"
                    and isinstance(behind, ast.Constant)
                    and PLURAL.match(str(behind.value))
                    and not OTHERS.match(str(behind.value))
                ):
                    wrong.append(f"{path}:{text.lineno}: {behind.value}")
    assert wrong == []
