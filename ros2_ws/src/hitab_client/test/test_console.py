"""Tables fit a terminal of 80 columns without losing anything, and are whole when piped."""

import io

from rich.console import Console

from hitab_client import console

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
