"""The list of agents stays short, however many there are."""

from types import SimpleNamespace

from hitab_msgs.msg import Subordinate

from hitab_studio.views.agent_tree import FEW, tree, unfolded


def commander(*subordinates: str, superior: str = "") -> SimpleNamespace:
    members = [Subordinate(name=name) for name in subordinates]
    return SimpleNamespace(subordinates=members, superior=superior)


def shown(agents, groups, folds=None, agent=""):
    found = unfolded(tree(agents, groups), folds or {}, agent)
    return [(branch.name, depth, fold) for branch, depth, fold in found]


def test_a_few_agents_are_all_shown_under_their_commanders():
    groups = {"captain": commander("keeper_1", "keeper_2")}
    assert shown(["captain", "keeper_1", "keeper_2", "lone"], groups) == [
        ("captain", 0, "open"),
        ("keeper_1", 1, ""),
        ("keeper_2", 1, ""),
        ("lone", 0, ""),
    ]


def thousand():
    squads = {
        f"squad_{s}": commander(*(f"robot_{10 * s + i}" for i in range(10))) for s in range(100)
    }
    groups = {"staff": commander(*squads), **squads}
    agents = [*groups, *(sub.name for squad in squads.values() for sub in squad.subordinates)]
    return agents, groups


def test_of_a_thousand_the_top_is_shown_and_opened_step_by_step():
    agents, groups = thousand()
    (staff,) = tree(agents, groups)
    assert staff.size == 1101
    assert shown(agents, groups) == [("staff", 0, "closed")]
    assert len(shown(agents, groups, {"staff": True})) == 101
    opened = shown(agents, groups, {"staff": True, "squad_3": True})
    assert ("robot_30", 2, "") in opened
    assert len(opened) == 111


def test_many_agents_without_a_commander_are_gathered_by_what_they_are_called():
    agents = [f"forager_{i}" for i in range(FEW)] + ["ann", "ben"]
    assert shown(agents, {}) == [("forager_…", 0, "closed"), ("ann", 0, ""), ("ben", 0, "")]
    assert len(shown(agents, {}, {"forager_…": True})) == FEW + 3


def test_a_commander_stands_under_its_own_before_that_was_heard():
    groups = {
        "general_1": commander("staff_1"),
        "company_1": commander("squad_1", superior="staff_1"),
    }
    agents = ["company_1", "general_1", "squad_1", "staff_1"]
    assert [(name, depth) for name, depth, _ in shown(agents, groups)] == [
        ("general_1", 0),
        ("staff_1", 1),
        ("company_1", 2),
        ("squad_1", 3),
    ]
    elsewhere = {"company_1": commander("squad_1", superior="nobody_here")}
    assert shown(["company_1"], elsewhere)[0][:2] == ("company_1", 0)
