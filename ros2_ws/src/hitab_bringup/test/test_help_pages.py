"""The help of every verb."""

import re

from typer.testing import CliRunner

from hitab_bringup.help_pages import verbs
from hitab_bringup.main import make_app


def output_of(*words):
    result = CliRunner().invoke(make_app(), list(words), env={"COLUMNS": "80", "TERM": "dumb"})
    assert result.exit_code == 0, words
    return result.stdout


def test_every_verb_has_help_with_what_it_does():
    wrong = []
    for path, verb in verbs(make_app()):
        page = output_of(*path, "--help")
        does = verb.callback.__doc__.split("\n")[0]
        if does not in re.sub(r"\s+", " ", page):
            wrong.append(path)
    assert wrong == []


def test_the_help_lists_at_most_forty_verbs_and_a_group_is_one():
    app = make_app()
    alone = [c for c in app.registered_commands if not c.hidden]
    assert len(alone) + len(app.registered_groups) <= 40


def test_without_a_verb_the_help_is_what_was_asked_for():
    for path in ((), ("library",), ("world",), ("lesson",), ("examples",)):
        assert "Usage: hitab" in output_of(*path)
