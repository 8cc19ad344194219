"""The benchmarks on the real simulator notice a build of UT Austin's players that is no good."""

from contextlib import ExitStack
from pathlib import Path

import pytest
from rcss_programs import lost_commands, start, start_team, tell_lost_commands

# As rcssserver 19.0.0 logged what players of two builds sent.
SOUND = '597,0\tRecv takers_1: (dash 100)(turn_neck 8)(say "0zE")\n597,0\tRecv takers_1: (done)\n'
GARBLED = '598,0\tRecv takers_1: (say "1BEBz19AE1(say "100)(turn_neck 2)")\n'


def test_commands_that_a_message_overwrites_are_counted_and_told(tmp_path, capsys):
    log = tmp_path / "game.rcl"
    log.write_text(SOUND)
    assert lost_commands(tmp_path) == 0
    tell_lost_commands(tmp_path)
    assert capsys.readouterr().out == ""
    log.write_text(SOUND + GARBLED + SOUND + GARBLED)
    assert lost_commands(tmp_path) == 2
    tell_lost_commands(tmp_path)
    assert "has lost 2 commands" in capsys.readouterr().out


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """Return a program without one of its libraries."""
    program = tmp_path / "player"
    program.write_text("#!/bin/sh\necho 'cannot open librcssnet.so.2' >&2\nexit 127\n")
    program.chmod(0o755)
    return program


def test_a_program_that_does_not_start_is_shown_with_what_it_printed_and_its_status(
    broken, tmp_path
):
    told = f"error: {broken} has ended with status 127:\ncannot open librcssnet.so.2\n"
    with ExitStack() as stack, pytest.raises(SystemExit) as ended:
        start(stack, tmp_path, str(broken))
    assert str(ended.value) == told
    with ExitStack() as stack, pytest.raises(SystemExit, match="has ended with status 127"):
        start_team(stack, tmp_path, broken, 6500, (3, 2), "takers")
