"""What runs from the checkout writes where the README says, nowhere else in the home folder."""

import os
import subprocess

from mentions import ROOT

DRAW = """
from hitab_core import Automaton, Term, draw_automata
from hitab_core import HandWritten
stand = HandWritten(lambda: "Stop", ())
stop = Term("Stop")
draw_automata([Automaton("Stand", (stop,), (), {"Start": stand, "Stop": stand})], "out.svg")
"""


def test_drawing_writes_nothing_into_the_home_folder(tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("MPL", "XDG", "VIRTUAL_ENV"))}
    subprocess.run(
        ["bash", "-c", '. "$0" && python -c "$1"', ROOT / "scripts/env.sh", DRAW],
        check=True,
        cwd=tmp_path,
        env={**kept, "HOME": str(home)},
    )
    assert (tmp_path / "out.svg").exists()
    assert list(home.rglob("*")) == []
