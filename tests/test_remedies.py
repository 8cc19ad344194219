"""Every remedy that an error carries can be worded by each face."""

import ast
from string import Formatter

import pytest
from mentions import ROOT, SOURCES
from test_mentions import complaint

from hitab_client.terminal.cli_remedies import (
    CALLED_AS,
    REMEDY_COMMANDS,
    THEN,
    as_command,
    with_commands,
)
from hitab_core import Fix, HitabError
from hitab_ros.messages.conversions import remedies_of, remedy_messages
from hitab_studio.pages.ui_remedies import BUTTONS, in_studio

CHOSEN = {"behavior", "feature", "snapshot"}
"""What only a person can choose: a remedy may leave it open."""


def arguments(text):
    return {name for _, name, _, _ in Formatter().parse(text) if name}


def made():
    """Go through all remedies that the code makes: where, the code and the names of arguments."""
    for pattern in SOURCES:
        for path in sorted(ROOT.glob(pattern)):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("Fix."):
                    names = {keyword.arg for keyword in node.keywords}
                    place = f"{path.relative_to(ROOT)}:{node.lineno}"
                    yield place, Fix[node.func.attr], names


@pytest.mark.parametrize("code", REMEDY_COMMANDS, ids=lambda code: code.name)
def test_the_command_for_a_remedy_is_there(code):
    numbers = {"version": "1", "number": "1", "seconds": "0.3"}
    known = {name: numbers.get(name, "X") for name in arguments(REMEDY_COMMANDS[code])}
    for command in REMEDY_COMMANDS[code].format_map(known).split(THEN):
        assert complaint(command.split(), in_passing=False) == ""


def test_every_argument_of_a_remedy_is_told_by_some_face():
    wrong = [
        (place, code.name)
        for place, code, names in made()
        if not names <= arguments(code.value) | arguments(REMEDY_COMMANDS.get(code, ""))
    ]
    assert wrong == []


def test_no_remedy_leaves_open_what_is_known():
    # The engine's remedies are for the agent that gives them, which adds its name.
    wrong = [
        (place, code.name, name)
        for place, code, names in made()
        for name in arguments(code.value) | arguments(REMEDY_COMMANDS.get(code, "")) - CHOSEN
        if name not in names | CHOSEN
        and not (name == "agent" and place.startswith("ros2_ws/src/hitab_core/"))
    ]
    assert wrong == []
    for code in (Fix.CAUTION, Fix.TRAIN, Fix.CORRECT):
        assert ("agent", "ann") in code().of("ann").arguments
    assert Fix.SAVE(agent="bob").of("ann") == Fix.SAVE(agent="bob")


def test_a_remedy_survives_the_way_to_each_face(monkeypatch):
    error = HitabError("it waits", Fix.RESUME(agent="ann"), Fix.MOVE_AWAY(file="a b"), where="ann")
    remedies = remedies_of(remedy_messages([*error.remedies, *error.remedies]))
    assert remedies == error.remedies
    assert str(error) == "ann: it waits; go on with the training of ann; move a b away"
    told = "ann: it waits\n  go on with the training of ann: `{} train ann`\n  move a b away"
    assert with_commands(error.problem, remedies) == told.format("hitab")
    monkeypatch.setenv(CALLED_AS, "scripts/hitab")
    assert with_commands(error.problem, remedies) == told.format("scripts/hitab")
    assert BUTTONS[Fix.RESUME] in in_studio(remedies[0])
    corrected = as_command(Fix.CORRECT(agent="ann", behavior="Go(a b)"))
    assert corrected.endswith(
        "`scripts/hitab train ann`, then `scripts/hitab demonstrate ann 'Go(a b)'`"
    )


def test_a_remedy_of_another_version_is_left_out():
    (message,) = remedy_messages([Fix.GO()])
    message.code = "UNHEARD_OF"
    assert remedies_of([message]) == ()
