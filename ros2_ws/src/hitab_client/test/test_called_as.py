"""Commands are printed the way the user types them."""

import pytest

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
