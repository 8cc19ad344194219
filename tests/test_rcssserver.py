"""Keepers as processes of their own play on an rcssserver: on a stand-in, and on a real one."""

import importlib.util
from pathlib import Path

import hitab_rcssserver
from hitab_bringup import temporary_swarm
from hitab_bringup.swarm_files.swarm_options import described_swarm

_path = Path(hitab_rcssserver.__file__).parents[1] / "test" / "rcss_stand_in.py"
_spec = importlib.util.spec_from_file_location("rcss_stand_in", _path)
stand_in = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(stand_in)


def test_keepers_over_topics_play_what_the_stand_in_replays(home):
    described = described_swarm("keepaway_rcssserver", None, pace="lockstep", paused=True)
    with stand_in.StandIn() as server:
        parameters = {**described.world.parameters, "port": server.port}
        with temporary_swarm(described.with_world(parameters=parameters)) as running:
            played = running.world.play(2, 1)
            missed = running.world.wait().missed_deadlines
    assert not server.errors
    # Which ones depends on whether the keepers are there before the first one is over.
    assert [one.cycles for one in played] in ([190, 193], [193, 246])
    assert [one.ended for one in played] == ["out", "out"]
    assert missed == 0
    sorts = {text.split()[0] for number in (0, 1, 2) for text in server.commands(number)}
    assert {"(dash", "(turn"} <= sorts
    assert {text.split()[0] for text in server.commands(3)} & {"(dash", "(turn", "(kick"}
