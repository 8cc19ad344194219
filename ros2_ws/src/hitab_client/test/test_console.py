"""Tables fit a terminal of 80 columns without losing anything, and are whole when piped."""

import io
import sys

from rich.console import Console

from hitab_client import console
from hitab_client.called_as import CALLED_AS

COLUMNS = ("agent", "mode", "behavior", "active", "examples", "library")
ROW = (
    "keeper_1",
    "performing",
    "Keepaway",
    "ControlBall > GotoBall > ApproachBall > GoMedium",
    "118 (59 default)",
    "e3b0c442",
)


def test_a_table_fits_80_columns_and_loses_nothing():
    text = io.StringIO()
    screen = Console(file=text, width=80, force_terminal=True, color_system=None, highlight=False)
    long = "A" * 200
    screen.print(console.table(COLUMNS, [ROW, (long, *ROW[1:])]))
    lines = text.getvalue().splitlines()
    assert all(len(line) <= 80 for line in lines)
    shown = "".join(lines)
    assert "…" not in shown
    assert shown.count("A") == 200 + 2 * 1  # ApproachBall, twice
    for word in " ".join(ROW[3:4]).split(" > "):
        assert word in shown


def test_a_table_is_whole_when_it_is_piped(capsys):
    many = tuple(f"DistanceTo(target_{number})" for number in range(30))
    console.out().print(console.table(many, [many], "Title of it"))
    title, header, row = capsys.readouterr().out.splitlines()
    assert title.strip() == "Title of it"
    assert tuple(header.split()) == tuple(row.split()) == many


def test_a_long_line_is_whole_when_it_is_piped(capsys):
    console.out().print("word " * 100)
    assert capsys.readouterr().out.count("\n") == 1


def test_what_is_kept_up_to_date_ends_with_its_last_state_in_a_pipe(capsys):
    with console.live("first") as update:
        update("second")
        update("last")
    assert capsys.readouterr().out == "last\n"


def test_the_lines_of_a_table_end_with_their_last_word(capsys):
    rows = [("keeper_1", "idle"), ("keeper_2", ""), ("keeper_3", "performing")]
    console.out().print(console.table(("agent", "mode"), rows, "Who"))
    assert capsys.readouterr().out.splitlines() == [
        "Who",
        "agent     mode",
        "keeper_1  idle",
        "keeper_2",
        "keeper_3  performing",
    ]


def test_a_table_names_commands_as_the_user_calls_hitab(capsys, monkeypatch):
    monkeypatch.setenv(CALLED_AS, "scripts/hitab")
    console.out().print(console.table(("why",), [("stopped; `hitab go` releases it",)]))
    assert "`scripts/hitab go`" in capsys.readouterr().out


def test_a_result_reaches_a_pipe_when_it_is_said(monkeypatch):
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written))
    console.say("Taught ApproachBall")
    assert written.getvalue() == b"Taught ApproachBall\n"


def test_a_long_progress_prints_lines_where_there_is_no_bar(capsys):
    with console.progress("playing", "episodes", line_every=20) as advance:
        for done in (0, 1, 19, 21, 22, 39, 45):
            advance(done, 50, "")
    assert capsys.readouterr().err.splitlines() == [
        "playing: 21 of 50 episodes",
        "playing: 45 of 50 episodes",
    ]
    with console.progress("playing", "episodes") as advance:
        advance(45, 50, "")
    assert not capsys.readouterr().err.strip()
