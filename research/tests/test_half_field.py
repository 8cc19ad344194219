"""The comparison of attackers in roles: its teams, and that what is learned is worth something."""

from half_field import ONE_ROLE, ROLES, ROLES_TEAM, goals_of, one_role, played, teams, trained
from half_field_rules import SWAPS


def test_one_role_learns_from_all_commands_for_the_roles():
    learned = trained()
    merged = one_role(learned)
    assert len(merged.examples) == sum(len(learned[role].examples) for role in ROLES)
    assert {"RunTo(spot)", "RunTo(near_wing)", "PlayBall"} <= set(merged.labels)


def test_all_teams_play_and_the_same_episodes_give_the_same_results():
    for team in teams().values():
        results = played(team, 11, range(3, 5), False)
        assert results == played(team, 11, range(3, 5), False)
        assert [r.number for r in results] == [3, 4]
        assert all(r.ended for r in results)


def test_trained_attackers_score_and_those_with_swapped_words_do_not():
    made = teams()
    roles = goals_of(played(made[ROLES_TEAM], 12, range(30), False))
    assert roles > goals_of(
        played(made[f"rules, {SWAPS[0][0]} and {SWAPS[0][1]} swapped"], 12, range(30), False)
    )
    assert roles > goals_of(played(made["random"], 12, range(30), False))
    assert ONE_ROLE in made
