"""The help of every verb: paragraphs that fit the terminal, and examples below each other."""

import inspect
import re
from itertools import pairwise

import pytest
from typer.testing import CliRunner

from hitab_bringup.help_pages import verbs
from hitab_bringup.main import make_app

WIDTH = 80


ALL = {path: verb.callback for path, verb in verbs(make_app())}


def help_of(*path):
    settings = {"COLUMNS": str(WIDTH), "TERMINAL_WIDTH": "", "TERM": "dumb"}
    result = CliRunner().invoke(make_app(), [*path, "--help"], env=settings)
    assert result.exit_code == 0
    return result.stdout


def description_in(page):
    return [line.strip() for line in page.split("╭")[0].split("\n")]


def examples_of(callback):
    told = inspect.getdoc(callback)
    return re.findall(r"(?m)^  (hitab .*)$", told)


def test_the_help_lists_at_most_forty_verbs_and_a_group_is_one():
    app = make_app()
    alone = [c for c in app.registered_commands if not c.hidden]
    assert len(alone) + len(app.registered_groups) <= 40


@pytest.mark.parametrize("path", sorted(ALL), ids=" ".join)
def test_no_line_of_a_paragraph_ends_early(path):
    lines = description_in(help_of(*path))
    for line, following in pairwise(lines):
        if line and following and not following.startswith("hitab "):
            assert len(f" {line} {following.split()[0]}") > WIDTH - 2, line


@pytest.mark.parametrize("path", sorted(ALL), ids=" ".join)
def test_each_example_is_a_line_below_the_other(path):
    shown = help_of(*path).split("╭")[0]
    examples = examples_of(ALL[path])
    assert "\n".join(f"   {line}" for line in examples) in re.sub(r" +\n", "\n", shown)
    if examples:
        assert f" {'Example' if len(examples) == 1 else 'Examples'}:" in shown


@pytest.mark.parametrize("path", sorted(ALL), ids=" ".join)
def test_the_help_names_no_types_of_python(path):
    page = help_of(*path)
    assert not re.search(r"<(bool|str|int|float|path|list)|\[x|<=x|\[\[", page)


def test_a_range_of_numbers_is_told():
    assert "NUMBER 1 to 65535" in " ".join(help_of("studio").split())
    assert "NUMBER from 1" in help_of("library", "restore")


@pytest.mark.parametrize("path", [(), ("library",), ("world",), ("lesson",), ("examples",)])
def test_without_a_verb_the_help_is_what_was_asked_for(path):
    result = CliRunner().invoke(make_app(), list(path), env={"COLUMNS": "80", "TERM": "dumb"})
    assert result.exit_code == 0
    assert "Usage: hitab" in result.stdout
