"""The list of agents stays short, however many there are."""

from types import SimpleNamespace
from typing import Any

from hitab_msgs.msg import Subordinate

from hitab_studio.views.agents import unfolded


def commander(*subordinates: str, superior: str = "") -> SimpleNamespace:
    members = [Subordinate(name=name) for name in subordinates]
    return SimpleNamespace(subordinates=members, superior=superior)


def shown(
    agents: list[str], groups: dict[str, Any], folds: Any = None, viewed: str = ""
) -> list[tuple[str, int, int, bool]]:
    return list(unfolded(agents, groups, folds or {}, viewed))


def test_of_a_thousand_the_top_is_shown_and_opened_step_by_step():
    squads = {
        f"squad_{s}": commander(*(f"robot_{10 * s + i}" for i in range(10))) for s in range(100)
    }
    groups = {"staff": commander(*squads), **squads}
    agents = [*groups, *(sub.name for squad in squads.values() for sub in squad.subordinates)]
    assert shown(agents, groups) == [("staff", 0, 1100, False)]
    assert len(shown(agents, groups, {"staff": True})) == 101
    opened = shown(agents, groups, {"staff": True, "squad_3": True})
    assert ("robot_30", 2, 0, False) in opened
    assert len(opened) == 111
    assert ("robot_5", 2, 0, False) in shown(agents, groups, viewed="robot_5")


def test_a_commander_stands_under_its_own_before_that_was_heard():
    groups = {
        "general_1": commander("staff_1"),
        "company_1": commander("squad_1", superior="staff_1"),
    }
    agents = ["company_1", "general_1", "lone", "squad_1", "staff_1"]
    assert [(name, depth) for name, depth, _, _ in shown(agents, groups)] == [
        ("general_1", 0),
        ("staff_1", 1),
        ("company_1", 2),
        ("squad_1", 3),
        ("lone", 0),
    ]
    elsewhere = {"company_1": commander("squad_1", superior="nobody_here")}
    assert shown(["company_1"], elsewhere)[0][:2] == ("company_1", 0)


def test_commanders_that_command_each_other_end_nothing():
    groups = {"a": commander("b"), "b": commander("a"), "c": commander("a")}
    assert shown(["a", "b", "c"], groups)[0][:2] == ("c", 0)
