"""A team of hard-coded automata: one is trained on the field, and loaded as the others run."""

from pathlib import Path

import pytest
from keepers import played, trained_keepers

from hitab_bringup import open_library, read_swarm, temporary_swarm
from hitab_client.lessons import LessonPlayer, read_lesson
from hitab_client.runs.shipped import find_file, shipped
from hitab_core import Example, Repertoire, load_domain
from hitab_world.inprocess import perform, play
from keepaway_world.parameters import variant
from keepaway_world.world import KeepawayWorld

KEEPERS = ("keeper_1", "keeper_2", "keeper_3")
LIBRARY = shipped("libraries", "keepaway_handcoded")
SECONDS = 60.0


def examples_of(library: Path) -> tuple[Example, ...]:
    return open_library(library).load()["GotoBall"].examples


def test_the_team_of_hard_coded_and_trained_automata_is_evaluated_as_any_other():
    swarm = trained_keepers(LIBRARY, "Keepaway", {"taker_speed": 0.25}, seed=5)
    assert [one.seconds for one in played(swarm, 3)] == by_themselves(3, 5, LIBRARY)


def by_themselves(episodes: int, seed: int, library: Path | None) -> list[float]:
    """Return how long the team keeps the ball in one process, s; None for all hard-coded."""
    domain = load_domain("keepaway_handcoded")
    repertoire = Repertoire(domain, {} if library is None else open_library(library).load())
    world = KeepawayWorld(variant("paper"), seed)
    return [r.seconds for r in play(world, perform(world, repertoire, "Keepaway"), episodes)]


@pytest.mark.long
def test_it_is_trained_on_one_robot_and_loaded_into_all_from_a_file_while_they_run(
    home, hitab, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    swarm = read_swarm(find_file("keepaway_handcoded", "swarms", "swarm"))
    swarm = swarm.with_world(pace="lockstep", paused=True)

    def did(*arguments: str) -> str:
        done = hitab(*arguments)
        assert done.returncode == 0, done.stderr
        return done.stdout

    with temporary_swarm(swarm, tmp_path / "run") as running:
        running.folder.write(running.record, register=True)
        agents, world, link = running.agents, running.world, running.link

        def untrained() -> set[str]:
            return {n for n in KEEPERS if agents.statuses[n].library_digest == before_training}

        def held(episodes: int, seed: int) -> list[float]:
            return [episode.seconds for episode in world.play(episodes, seed)]

        # All play what is hard-coded.
        (before_training,) = {agents.statuses[name].library_digest for name in KEEPERS}
        assert {agents.statuses[name].behavior for name in KEEPERS} == {"Keepaway"}
        assert held(1, swarm.world.seed) == by_themselves(1, swarm.world.seed, None)

        # One is trained by commands, and plays; the others go on meanwhile.
        lesson = read_lesson(find_file("handcoded/goto_ball", "lessons", "lesson"))
        report = LessonPlayer(lesson, agents, world).play()
        assert report.examples <= 20
        learned = Path(report.path).parent
        for one, shipped_one in zip(examples_of(learned), examples_of(LIBRARY), strict=True):
            assert (one.state, one.next_state) == (shipped_one.state, shipped_one.next_state)
            # The keeper runs in between, and the noise depends on the number of the episode.
            assert one.features == pytest.approx(shipped_one.features, abs=0.1)
        assert link.spin_until(lambda: untrained() == {"keeper_2", "keeper_3"}, SECONDS)
        assert link.spin_until(
            lambda: {agents.statuses[name].behavior for name in KEEPERS} == {"Keepaway"}, SECONDS
        )

        # The others load it from a file while they play.
        world.control("resume")
        assert did("library", "export", "GotoBall", "--agent", "keeper_1") == (
            "wrote GotoBall to GotoBall.bundle.yaml\n"
        )
        for name in ("keeper_2", "keeper_3"):
            assert "GotoBall: new\n" in did(
                "library", "import", "GotoBall.bundle.yaml", "--agent", name
            )
        before = world.status.cycle
        did("library", "reload")
        assert link.spin_until(lambda: not untrained(), SECONDS)
        digests = {agents.statuses[name].library_digest for name in KEEPERS}
        assert len(digests) == 1

        went: set[str] = set()

        def all_went() -> bool:
            for name in KEEPERS:
                path = agents.statuses[name].active_path
                if list(path[:2]) == ["ControlBall", "GotoBall"] and len(path) > 2:
                    went.add(name)
            return went == set(KEEPERS)

        assert link.spin_until(all_went, SECONDS)
        assert world.status.cycle > before
        assert {agents.statuses[name].behavior for name in KEEPERS} == {"Keepaway"}

        # Together they play as the same team does in one process, far longer than without it.
        world.control("pause")
        together = held(5, 12)
        assert together == by_themselves(5, 12, learned)
