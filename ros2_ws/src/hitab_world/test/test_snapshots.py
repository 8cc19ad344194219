"""What snapshots have in common: a header that tells of which world they are, and when."""

from dataclasses import dataclass

import pytest

from hitab_world.parameters import Parameters
from hitab_world.simulating.snapshots import header, reading
from hitab_world.world import EpisodeResult, WorldError


@dataclass(frozen=True)
class PuddleParameters(Parameters):
    WORLD = "puddle"

    width: float = 5.0


class Puddle:
    """As much of a world as has to do with headers."""

    name = "puddle"
    cycle_seconds = 0.1

    def __init__(self, width=5.0, **counts):
        self.parameters = PuddleParameters(width)
        self.seed, self.episode, self.cycle, self.episode_cycle, self.ended = 0, 0, 0, 0, ""
        self.refused = {"frog": "cannot fly"}
        self.__dict__.update(counts)

    def restore(self, snapshot, version=1):
        with reading(snapshot, self, version) as moment:
            leaves = [float(leaf) for leaf in snapshot["leaves"]]
        moment.bring_back(self)
        return leaves


@pytest.fixture
def kept():
    world = Puddle(seed=7, episode=2, cycle=90, episode_cycle=30, ended="dry")
    return {**header(world, 1), "leaves": [1.0, 2.0]}


def test_a_header_brings_back_when_it_was_taken(kept):
    world = Puddle()
    assert world.restore(kept) == [1.0, 2.0]
    assert header(world, 1) == {k: v for k, v in kept.items() if k != "leaves"}
    assert world.refused == {}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"world": "pond"}, "the snapshot's world is pond, this world's is puddle"),
        (
            {"version": 2},
            "the snapshot's version is 2, this world's is 1; another version of HiTAB took it",
        ),
        (
            {"parameters": {"width": 6.0}},
            "the snapshot was taken with other parameters (width: 6.0 there",
        ),
        ({"cycle": 3.5}, "damaged: TypeError 3.5 is not a whole number"),
        ({"episode": True}, "damaged: TypeError True is not a whole number"),
        ({"ended": None}, "damaged: TypeError None is not text"),
        ({"leaves": ["x"]}, "damaged: ValueError could not convert"),
        ({"leaves": 3}, "damaged: TypeError"),
        ({"leaves": [10**400]}, "damaged: OverflowError"),
    ],
)
def test_what_is_not_of_such_a_world_or_damaged_is_refused(kept, changes, told):
    world = Puddle()
    before = dict(world.__dict__)
    with pytest.raises(WorldError) as error:
        world.restore({**kept, **changes})
    assert told in str(error.value)
    assert world.__dict__ == before


@pytest.mark.parametrize("part", ["world", "version", "parameters", "seed", "ended", "leaves"])
def test_what_is_incomplete_is_refused(kept, part):
    del kept[part]
    with pytest.raises(WorldError, match=part):
        Puddle().restore(kept)


@pytest.mark.parametrize(
    ("cycles", "seconds"), [(262, 26.2), (3, 0.3), (0, 0.0), (1_000_001, 1e5 + 0.1)]
)
def test_the_seconds_of_a_result_are_without_noise(cycles, seconds):
    assert EpisodeResult.of(Puddle(episode_cycle=cycles), {}).seconds == seconds
