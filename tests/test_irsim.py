"""Robots in ir-sim, examples/irsim_robots: what holds without the simulator, and a run with it."""

import math
import sys
from dataclasses import replace
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_commander import KIND_FILE, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_core import Automaton, BehaviorLibrary, Repertoire, Term
from hitab_core.domain import load_domain
from hitab_world.inprocess import AutomatonPlayer

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "examples/irsim_robots"
LIBRARIES = EXAMPLE / "libraries"
sys.path.insert(0, str(EXAMPLE))


def trained(folder: str) -> dict[str, Automaton]:
    """Return what the robots or the captain have learned, learned again from the examples."""
    if folder == "robot":
        domain = load_domain("irsim_robots.domain:DOMAIN")
    else:
        domain = commander_domain(read_kind(LIBRARIES / folder / KIND_FILE))
    return dict(BehaviorLibrary(LIBRARIES / folder, domain).load())


near = st.floats(0.2, 6.0)
percepts = st.tuples(
    near, near, st.floats(0.5, 8.5), st.floats(0.5, 6.5), st.floats(-math.pi, math.pi)
)


@settings(deadline=None, max_examples=40)
@given(st.lists(percepts, min_size=1, max_size=60))
def test_the_trained_robots_do_not_drive_at_what_is_near_whatever_they_do(seen):
    domain = load_domain("irsim_robots.domain:DOMAIN")
    repertoire = Repertoire(replace(domain, automata=trained("robot")))
    player = AutomatonPlayer(repertoire, Term("Patrol"), "robot_1")
    player.begin(1, 0)
    for i, (ahead, beside, x, y, heading) in enumerate(seen):
        scan = [ahead, 0.0, min(ahead, beside), 0.0]
        player.body.sense([0.2 * i, x, y, heading, 0.0, 0.0, 0.0, *scan], ())
        player.tick()
        velocity, _ = player.body.act()
        if velocity:  # none where a round ends
            assert velocity[0] == 0.0 or ahead > 0.5
