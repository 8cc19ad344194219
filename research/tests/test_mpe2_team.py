"""A team of an environment that nobody here wrote is trained by a script."""

from statistics import fmean

import mpe2_team

SEED, EPISODES = 1234, 10


def test_a_trained_team_gets_more_than_any_of_its_words_alone():
    automaton, pupil, examples = mpe2_team.taught(SEED)
    assert len(pupil.commands) < examples <= mpe2_team.BUDGET
    trained, *alone = (
        fmean(mpe2_team.rewards(team, EPISODES, SEED))
        for team in (
            mpe2_team.performing(mpe2_team.NAME, automaton),
            *map(mpe2_team.performing, mpe2_team.GOALS),
        )
    )
    assert trained > max(alone)
    assert mpe2_team.taught(SEED)[0] == automaton, "the same seed gives the same demonstration"


def test_random_teams_depend_on_seed_and_episode_alone():
    def team(world):
        return mpe2_team.drawn(
            world,
            lambda random: mpe2_team.performing(
                mpe2_team.NAME, mpe2_team.random_automaton(random)
            ),
        )

    first, again = (mpe2_team.rewards(team, 4, SEED) for _ in range(2))
    assert first == again
    assert len({*first}) == 4
