"""Every command of the pages runs, in the order of the page, and prints what the page shows."""

import os
import re

import pytest
from mentions import ROOT
from pages import Reader, steps_of

from hitab_bringup.libraries.opened_library import open_library
from hitab_core import BehaviorLibrary

LIBRARY = ROOT / "ros2_ws/src/keepaway_world/libraries/keepaway"
ELSEWHERE = {
    r"scripts/test\b": "is what runs this",
    r"scripts/hitab demo\b": "test_demo.py",
    r"scripts/wheels\b": "test_wheels.py",
    r"(scripts/)?hitab up thousand\b": "test_scale.py",
}
"""Commands that other tests run, because they take long; with all that follows to `hitab down`."""


def to_be_run(page: str):
    """Go through the steps of a page without those that are run elsewhere."""
    away = False
    for step in steps_of(page):
        if re.match(r"(scripts/)?hitab up ", step.command):
            away = False
        elsewhere = next((k for k in ELSEWHERE if re.match(k, step.command)), None)
        if elsewhere is not None:
            away = " up " in step.command
        elif not away:
            yield step


@pytest.fixture
def reader(apart, monkeypatch):
    """Someone who begins with a page, knows nothing of other swarms and has none."""
    (checkout := apart / "checkout").mkdir()
    return Reader(checkout, {**os.environ, "COLUMNS": "80"})


@pytest.mark.parametrize(
    "page",
    [
        "README.md",
        pytest.param("docs/tutorial.md", marks=pytest.mark.long),
        pytest.param("docs/commanders.md", marks=pytest.mark.long),
        pytest.param("docs/bootstrapping.md", marks=pytest.mark.long),
        pytest.param("docs/half-field.md", marks=pytest.mark.long),
        pytest.param("docs/second-thoughts.md", marks=pytest.mark.long),
    ],
)
def test_the_page_shows_what_its_commands_print(reader, page):
    steps = list(to_be_run(page))
    assert len(steps) > 5
    wrong = [complaint for complaint in map(reader.type, steps) if complaint]
    assert not wrong, "\n\n".join(wrong)
    assert steps[-1].command.endswith("hitab down")


def test_the_library_page_shows_what_its_commands_print(reader):
    library = reader.folder / "lib"
    there = open_library(LIBRARY)
    BehaviorLibrary(library, there.domain).install(there.texts())
    path = library / "ApproachBall.hfa.yaml"

    def edit() -> None:
        """Change example 3 by hand."""
        text, changed = re.subn(
            r"(number: +3,.*features: )\[ *[0-9.]+\]", r"\1[5.5]", path.read_text()
        )
        assert changed == 1
        path.write_text(text)

    first = {"check": [None, edit]}
    wrong = []
    for step in steps_of("docs/library-format.md"):
        words = step.command.split()
        if not step.shown or not step.command.endswith(" -l lib"):
            continue
        if (actions := first.get(words[2])) and (action := actions.pop(0)):
            action()
        wrong.append(reader.type(step))
        if words[2] == "rename" and "--with-users" in words:
            break  # what follows is about another library
    assert len(wrong) == 7
    assert not any(wrong), "\n\n".join(filter(None, wrong))
