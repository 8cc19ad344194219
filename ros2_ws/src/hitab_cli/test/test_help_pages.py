"""The help of every verb."""

import re

import pytest
import typer
from typer.main import get_command
from typer.testing import CliRunner

from hitab_cli.help_pages import verbs
from hitab_cli.main import make_app


@pytest.fixture(scope="module")
def app():
    return make_app()


def output_of(app, *words, code=0):
    result = CliRunner().invoke(app, list(words), env={"COLUMNS": "80", "TERM": "dumb"})
    assert result.exit_code == code, words
    return result.stdout


def test_every_verb_has_help_with_what_it_does(app):
    for path, verb in verbs(app):
        page = output_of(app, *path, "--help")
        does = verb.callback.__doc__.split("\n")[0]
        assert does in re.sub(r"\s+", " ", page), path
        assert "Args:" not in page, path


def test_every_option_and_argument_has_help(app):
    command = get_command(app)
    for path, _ in verbs(app):
        verb = command
        for word in path:
            verb = verb.commands[word]
        for parameter in verb.get_params(verb.make_context("", [], resilient_parsing=True)):
            assert parameter.help, (path, parameter.name)


def test_the_help_lists_at_most_44_verbs_and_a_group_is_one(app):
    shown = typer.main.get_group(app).commands  # by name: another test may have registered twice
    assert 20 < sum(not command.hidden for command in shown.values()) <= 44


def test_without_a_verb_the_help_is_shown_as_a_mistake_of_usage(app):
    for path in ((), ("library",)):
        assert "Usage: hitab" in output_of(app, *path, code=2)


def test_each_example_stays_on_a_line_of_its_own(app):
    page = [line.strip() for line in output_of(app, "examples", "delete", "--help").splitlines()]
    assert page[page.index("Example:") + 1] == "hitab examples delete keeper_1 3 4"
