"""The checks that any world can be put through find what is wrong with one."""

import math
from random import Random, random

import pytest

from hitab_world.simulating.snapshots import finite, text, whole
from hitab_world.testing import Wandering, check_world
from hitab_world.world import Entity, EpisodeResult, Look, WorldError

LOOKS = {"bead": Look("#3f8f6b", faces=False)}


class Line:
    """Two beads on a line that jitter; correct, unless a flaw is asked for."""

    name = "line"
    cycle_seconds = 0.1
    looks = LOOKS
    size = (10.0, 1.0)
    agents = ("bead_1", "bead_2")

    def __init__(self, seed=0, flaw=""):
        self.flaw = flaw
        if flaw == "looks of its own":
            self.looks = {"bead": "green"}
        self.seed, self.cycle = seed, 0
        self.random = Random()
        self.reset(0)

    def reset(self, episode=None, seed=None):
        self.seed = self.seed if seed is None else seed
        self.episode = self.episode + 1 if episode is None else episode
        self.episode_cycle, self.ended, self.refused = 0, "", {}
        if self.flaw != "episodes depend on what was before":
            self.random.seed(f"{self.seed} {self.episode}")
        self.x = {name: self.random.random() for name in self.agents}

    def percept(self, agent):
        if agent not in self.x:
            raise WorldError(f'no bead "{agent}"')
        if self.flaw == "perceiving changes something":
            self.random.random()
        return [self.x[agent]], []

    def step(self, actions):
        if self.ended and self.flaw != "goes on after the end":
            raise WorldError("has ended; reset()")
        self.refused = {}
        for name, action in actions.items():
            try:
                speed = float(action[0][0]) if action[0] else 0.0
                if name not in self.x:
                    raise ValueError("no such bead")
                if not math.isfinite(speed) and self.flaw != "believes in NaN":
                    raise ValueError("not finite")
            except (TypeError, ValueError, KeyError) as error:
                self.refused[name] = f"{name}: {error}"
                continue
            self.x[name] += speed
        jitter = random if self.flaw == "not seeded" else self.random.random
        for name in self.agents:
            self.x[name] += jitter() - 0.5
        self.cycle += 1
        self.episode_cycle += 1
        self.ended = "time" if self.episode_cycle == 25 else ""
        return self.ended or None

    def entities(self):
        return [Entity(name, "bead", x, 0.0) for name, x in self.x.items()]

    def place(self, placements, *, new_episode=False):
        placements = list(placements)
        for placement in placements:
            if placement.name not in self.x or math.isinf(placement.x):
                raise WorldError(f"{placement.name} cannot be placed")
            if self.flaw == "places half":
                self.x[placement.name] = placement.x
        if new_episode:
            self.reset()
        for placement in placements:
            self.x[placement.name] = placement.x

    def snapshot(self):
        version, state, gauss = self.random.getstate()
        kept = {
            "world": self.name,
            "x": dict(self.x),
            "counts": [self.seed, self.episode, self.cycle, self.episode_cycle],
            "ended": self.ended,
            "random": [version, list(state), gauss],
        }
        if self.flaw == "forgets its random numbers":
            del kept["random"]
        return kept

    def restore(self, snapshot):
        if snapshot.get("world") != self.name:
            raise WorldError("not a snapshot of a line")
        random = Random()
        try:
            if self.flaw == "restores half":
                self.cycle = whole(snapshot["counts"][2])
            x = {name: finite(snapshot["x"][name]) for name in self.agents}
            counts, ended = [whole(count) for count in snapshot["counts"]], text(snapshot["ended"])
            if self.flaw != "forgets its random numbers":
                version, state, gauss = snapshot["random"]
                random.setstate((version, tuple(state), gauss))
                if gauss is not None:
                    finite(gauss)
        except (KeyError, TypeError, ValueError) as error:
            if self.flaw == "falls over damaged snapshots":
                raise
            if self.flaw == "believes in damaged snapshots":
                return
            raise WorldError(f"damaged: {error}") from None
        self.x, self.ended, self.refused = x, ended, {}
        self.seed, self.episode, self.cycle, self.episode_cycle = counts
        self.random.setstate(random.getstate())

    def result(self):
        seconds = self.episode_cycle * self.cycle_seconds
        return EpisodeResult(self.episode, self.seed, self.episode_cycle, seconds, self.ended)


WANDERING = Wandering([[], [0.1], [-0.2]])


def test_a_world_that_keeps_its_promises_passes():
    check_world(Line, WANDERING)


@pytest.mark.parametrize(
    ("flaw", "message"),
    [
        ("looks of its own", "looks are Look objects"),
        ("not seeded", "the same seed must give the same run"),
        ("episodes depend on what was before", "seed"),
        ("perceiving changes something", "looking must not change what happens"),
        ("forgets its random numbers", "continues the same"),
        ("believes in NaN", "is reported in `refused`"),
        ("restores half", "changes nothing"),
        ("falls over damaged snapshots", "raises a WorldError"),
        ("believes in damaged snapshots", "raises a WorldError"),
        ("goes on after the end", "after the end of an episode raises"),
        ("places half", "nothing is placed if anything is refused"),
    ],
)
def test_a_flaw_is_found(flaw, message):
    with pytest.raises(AssertionError, match=message):
        check_world(lambda seed: Line(seed, flaw), WANDERING)


@pytest.mark.parametrize(
    ("look", "message"),
    [
        ({"color": "yellow"}, 'a color is written like "#f2c94c", not "yellow"'),
        ({"shape": "squre"}, 'Did you mean "square"'),
        ({"opacity": float("nan")}, "an opacity is between 0 and 1, not nan"),
        ({"layer": 128}, "a layer is between -128 and 127, not 128"),
    ],
)
def test_a_look_that_cannot_be_drawn_is_refused(look, message):
    with pytest.raises(WorldError) as refused:
        Look(**look)
    assert message in str(refused.value)
