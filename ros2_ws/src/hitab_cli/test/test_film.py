"""A film shows the cycles of an episode that `evaluate` plays."""

import pytest
from PIL import Image

from hitab_bringup.casting import Cast
from hitab_bringup.evaluation import evaluated_swarm, games_of, play_alike
from hitab_cli.views import field_film as field_film
from hitab_core import HitabError

SEED, EPISODE = 4, 2


@pytest.fixture
def game(home):
    swarm = evaluated_swarm("keepaway_trained", SEED, ["taker_speed=1.0"])
    with games_of(swarm, [Cast(swarm).parts()]) as (made,):
        yield made


def pictures(path) -> int:
    with Image.open(path) as film:
        return film.n_frames


def test_a_film_takes_as_long_as_the_episode_that_is_evaluated(game):
    *_, (played,) = play_alike([game], EPISODE + 1)
    filmed = field_film.film(game, EPISODE, 0.0, 1000.0)
    assert filmed.ended == played.ended
    assert len(filmed.moments) == played.cycles
    assert filmed.seconds == pytest.approx(played.seconds)


def test_a_part_of_an_episode_is_what_was_in_the_whole(game):
    whole = field_film.film(game, EPISODE, 0.0, 3.0)
    part = field_film.film(game, EPISODE, 1.0, 0.5)
    assert part.moments == whole.moments[10:15]
    assert (part.begin, part.ended) == (1.0, "")


@pytest.mark.parametrize("suffix", field_film.SUFFIXES)
def test_each_format_has_a_picture_of_each_cycle(game, tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    filmed = field_film.film(game, EPISODE, 0.0, 0.5)
    done = []
    field_film.draw_film(filmed, path, lambda *so_far: done.append(so_far[:2]), pixels=120)
    assert pictures(path) == 5
    assert done[-1] == (5, 5)
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_a_film_that_cannot_be_made_is_refused_and_leaves_nothing(game, tmp_path):
    with pytest.raises(HitabError, match=r"film\.mp4 .*must end with \.gif, \.png, \.webp"):
        field_film.check_film(tmp_path / "film.mp4")
    with pytest.raises(HitabError, match="there is no folder"):
        field_film.check_film(tmp_path / "absent" / "film.gif")
    with pytest.raises(
        HitabError, match=r"episode 2 ended after \d+\.\d s; begin the film before"
    ):
        field_film.film(game, EPISODE, 900.0, 1.0)

    def interrupted(*_):
        raise KeyboardInterrupt

    filmed = field_film.film(game, EPISODE, 0.0, 0.5)
    with pytest.raises(KeyboardInterrupt):
        field_film.draw_film(filmed, tmp_path / "film.gif", interrupted)
    assert list(tmp_path.iterdir()) == []
