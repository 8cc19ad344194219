"""Commands are printed the way the user types them."""

import re
from pathlib import Path

import pytest

from hitab_client import console
from hitab_client.called_as import CALLED_AS, as_called

TEXT = """\
look with `hitab status`; run: hitab library accept A.hfa.yaml
Next:
  hitab up keepaway
"""


def test_commands_are_named_as_hitab_was_called(monkeypatch):
    monkeypatch.setenv(CALLED_AS, "../scripts/hitab")
    assert as_called(TEXT) == TEXT.replace("hitab ", "../scripts/hitab ")


@pytest.mark.parametrize("text", ["files in /home/me/hitab keepaway", "hitab 0.1.0", "a `hitab`"])
def test_what_is_no_command_stays_as_it_is(monkeypatch, text):
    monkeypatch.setenv(CALLED_AS, "scripts/hitab")
    assert as_called(text) == text


def test_where_hitab_is_on_the_path_texts_stay_as_they_are(monkeypatch):
    monkeypatch.delenv(CALLED_AS, raising=False)
    assert as_called(TEXT) == TEXT


def test_results_messages_and_errors_are_printed_so(monkeypatch, capsys):
    monkeypatch.setenv(CALLED_AS, "scripts/hitab")
    console.say("`hitab down` ends it")
    console.note("see `hitab status --watch`")
    console.error("no swarm is up; `hitab up keepaway` starts one")
    printed = capsys.readouterr()
    assert printed.out == "`scripts/hitab down` ends it\n"
    assert "`scripts/hitab status --watch`" in printed.err
    assert "`scripts/hitab up keepaway` starts one" in printed.err


def test_lines_of_tables_trees_and_groups_are_printed_so(monkeypatch):
    monkeypatch.setenv(CALLED_AS, "scripts/hitab")
    assert console.line("emergency stop; `hitab go` releases it").plain.count("scripts/hitab") == 1


def test_no_line_is_made_in_another_way():
    sources = Path(__file__).parents[2]
    made = [p for p in sources.glob("*/*/**/*.py") if re.search(r"\bText\(", p.read_text())]
    assert [path.name for path in made if path.parent.name != "test"] == ["console.py"]
