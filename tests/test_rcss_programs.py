"""The benchmarks on the real simulator notice a build of UT Austin's players that is no good."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from rcss_programs import lost_commands, tell_lost_commands

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
