"""What a commander perceives of its subordinates, over topics, and how it is trained by it."""

import math

from hitab_msgs import msg, srv

from hitab_core.operations import SaveBehavior
from hitab_ros import names, qos
from hitab_ros.nodes.diagnostics import Level

CREW = """\
commander: Crew
orders:
  Run: Errand
  Search: Search
  Rest: nothing
features:
  AllDone: {all: Done}
  AnyDone: {any: Done}
  Searching: {fraction: {active: Search}}
  Home: {count: AtHome}
  Far: {count: X, above: 4}
  MeanX: {mean: X}
  MinX: {minimum: X}
  MaxX: {maximum: X}
  XOf(A): {value: X}
  GroupX: {group: x}
  GroupY: {group: y}
  Spread: {group: spread}
targets:
  foremost: {maximum: X}
  second: {number: 2}
deadline: 1.0
report_period: 0.1
"""
ANTS = ["a", "b"]


def crew(team, **settings):
    return team.commander("chief", CREW, ANTS, **settings)


def perceiving_crew(team, *xs, **settings):
    """Return a chief whose subordinates perceive this, and who knows it."""
    chief = crew(team, **settings)
    for name, x in zip(ANTS, xs, strict=True):
        team.ant(name, "chief")
        team.perceive(name, x, 0.0, 0.0)
    await_value(team, "MeanX", sum(xs) / len(xs))
    return chief


def await_value(team, feature, value, name="chief"):
    team.until(lambda: math.isclose(team.sees(name, feature), value, abs_tol=1e-9))


def teach_errand(team):
    """Teach ant a the errand: search, and raise Done at home; return its library."""
    team.ant("a", "chief")
    team.perceive("a", 0.0, 0.0, 0.0)
    team.train("a", "Errand", "AtHome")
    team.command("a", "Search")
    team.perceive("a", 0.0, 0.0, 1.0)
    team.command("a", "Done")
    assert team.do("a", SaveBehavior()).success
    return str(team.folder / "libraries" / "a")


def test_features_sum_up_what_the_subordinates_perceive_and_where_they_are(team):
    crew(team)
    for name, x, y, home in (("a", 1.0, 0.0, 1.0), ("b", 5.0, 2.0, 0.0)):
        team.ant(name, "chief")
        team.perceive(name, x, y, home)
    await_value(team, "MeanX", 3.0)
    expected = {
        "Home": 1.0,
        "Far": 1.0,
        "MinX": 1.0,
        "MaxX": 5.0,
        "GroupX": 3.0,
        "GroupY": 1.0,
        "Spread": math.sqrt(5.0),
        "XOf(foremost)": 5.0,
        "XOf(second)": 5.0,
        "FractionSilent": 0.0,
    }
    assert {feature: team.sees("chief", feature) for feature in expected} == expected


def test_active_states_at_any_level_are_seen_as_soon_as_they_change(team):
    library = teach_errand(team)
    crew(team)
    team.ant("b", "chief", library=library)
    team.perform("chief", "Run")
    team.until(lambda: team.performs("b") == "Errand")
    await_value(team, "Searching", 0.0)
    team.perceive("b", 0.0, 0.0, 0.0)
    await_value(team, "Searching", 0.5)


def test_states_inside_the_ordered_behavior_are_reported_only_to_a_commander_that_looks_at_them(
    team,
):
    library = teach_errand(team)
    looks = "  Searching: {fraction: {active: Search}}\n"
    for name, kind in (("chief", CREW), ("other", CREW.replace(looks, ""))):
        ant = {"chief": "b", "other": "c"}[name]
        team.commander(name, kind, [ant])
        team.ant(ant, name, library=library)
        team.perform(name, "Run")
        team.until(lambda ant=ant: team.performs(ant) == "Errand")
        team.perceive(ant, 0.0, 0.0, 0.0)
        team.until(lambda ant=ant: team.statuses[ant].active_path == ["Search"])
        await_value(team, "MeanX", 0.0, name)
    heard = {"chief": "b", "other": "c"}
    paths = {
        name: list(team.nodes[name].agent.body.members[ant].report.path)
        for name, ant in heard.items()
    }
    assert paths == {"chief": ["Errand", "Search"], "other": ["Errand"]}


def test_a_subordinate_that_falls_silent_is_left_out_and_counted(team):
    chief = perceiving_crew(team, 1.0, 5.0)
    team.end("b")
    await_value(team, "FractionSilent", 0.5)
    assert team.sees("chief", "MeanX") == 1.0
    team.until(lambda: [s.silent for s in team.groups["chief"].subordinates] == [False, True])
    assert chief.troubles() == [(Level.WARN, "silent subordinates: b")]
    assert chief.diagnose().level == Level.WARN
    team.ant("b", "chief")
    await_value(team, "FractionSilent", 0.0)


def test_an_agent_in_a_world_that_stands_still_is_not_silent(team):
    crew(team)
    team.ant("a", "chief")
    team.ant("b", "chief")
    await_value(team, "FractionSilent", 0.0)
    # Longer than the deadline without a percept.
    assert not team.holds(lambda: team.sees("chief", "FractionSilent") > 0.0, 2.5)


def test_a_flag_is_up_until_the_next_order(team):
    library = teach_errand(team)
    crew(team)
    team.ant("b", "chief", library=library)
    team.perform("chief", "Run")
    team.until(lambda: [team.performs(name) for name in ANTS] == ["Errand", "Errand"])
    for home in (0.0, 1.0, 0.0):  # it begins again after it has raised its flag
        team.perceive("a", 0.0, 0.0, home)
    await_value(team, "AnyDone", 1.0)
    assert team.sees("chief", "AllDone") == 0.0
    for home in (0.0, 1.0):
        team.perceive("b", 0.0, 0.0, home)
    await_value(team, "AllDone", 1.0)
    team.perform("chief", "Search")
    await_value(team, "AnyDone", 0.0)


def test_a_commander_is_trained_as_an_agent_is_and_its_flag_reaches_its_own_commander(team):
    library = teach_errand(team)
    top = "commander: Top\norders: {Go: Mission}\nfeatures: {Over: {all: Done}}\n"
    team.commander("general", top, ["chief"])
    crew(team, superior="general")
    team.ant("b", "chief", library=library)
    for name in ANTS:
        team.perceive(name, 0.0, 0.0, 0.0)
    await_value(team, "FractionSilent", 0.0)

    begun = team.train("chief", "Mission", "AllDone")
    assert begun.success
    team.command("chief", "Run")
    team.until(lambda: [team.performs(name) for name in ANTS] == ["Errand", "Errand"])
    for name in ANTS:
        team.perceive(name, 0.0, 0.0, 0.0)
        team.perceive(name, 0.0, 0.0, 1.0)
    await_value(team, "AllDone", 1.0)
    team.command("chief", "Done")
    listed = team.ask(srv.GetBehavior, "chief", names.GET_BEHAVIOR).automaton.examples
    assert [(e.state, e.next_state, list(e.features)) for e in listed] == [
        ("Start", "Run", [0.0]),
        ("Run", "Run", [0.0]),
        ("Run", "Done", [1.0]),
    ]
    assert team.do("chief", SaveBehavior()).success
    assert (team.folder / "libraries" / "chief" / "Mission.hfa.yaml").exists()

    # From above: the general orders what was learned, and hears when it is over.
    team.perform("chief", "Rest")
    team.until(lambda: [team.performs(name) for name in ANTS] == ["", ""])
    team.perform("general", "Go")
    team.until(lambda: [team.performs(name) for name in ANTS] == ["Errand", "Errand"])
    await_value(team, "Over", 0.0, "general")
    for name in ANTS:
        team.perceive(name, 0.0, 0.0, 0.0)
        team.perceive(name, 0.0, 0.0, 1.0)
    await_value(team, "Over", 1.0, "general")


def test_features_of_a_commander_are_features_of_a_subordinate_for_its_own(team):
    top = "commander: Top\norders: {Go: Rest}\nfeatures: {Far: {mean: MeanX}, X: {group: x}}\n"
    team.commander("general", top, ["chief"])
    perceiving_crew(team, 2.0, 4.0, superior="general")
    await_value(team, "Far", 3.0, "general")
    await_value(team, "X", 3.0, "general")


def test_that_the_world_went_back_is_told_up_the_tree_in_real_time(team, monkeypatch):
    team.commander("general", "commander: Top\norders: {Go: Rest}\n", ["chief"])
    perceiving_crew(team, 2.0, 4.0, superior="general")
    cycles: list[int] = []
    monkeypatch.setattr(team.nodes["general"].agent, "go_back", cycles.append)
    told = team.link.create_publisher(msg.Reports, f"/chief/{names.REPORTS}", qos.EVENTS)
    team.until(told.get_subscription_count)
    back = msg.Report(agent="a", mode="performing", path=["Search"], cycle=1, back=True)
    told.publish(msg.Reports(reports=[back]))
    team.until(lambda: cycles)


def test_a_training_goes_on_after_the_commander_was_restarted(team):
    perceiving_crew(team, 1.0, 1.0)
    team.train("chief", "Plan", "MeanX")
    team.command("chief", "Search")
    team.until(lambda: [team.performs(name) for name in ANTS] == ["Search", "Search"])
    team.end("chief")
    crew(team)
    team.until(lambda: team.statuses["chief"].training.examples == 2)
    team.until(lambda: team.obeying() == [True, True])
    assert team.begun("a") == ["Search"]


def begin_plan(team):
    """Have the chief of a and b train a plan, in the state Search."""
    crew(team)
    for name in ANTS:
        team.ant(name, "chief")
        team.perceive(name, 1.0, 0.0, 0.0, episode=3)
    await_value(team, "MeanX", 1.0)
    team.train("chief", "Plan", "MeanX")
    search(team)


def search(team):
    team.command("chief", "Search")
    team.until(lambda: team.nodes["chief"].agent.active_path == ["Search"])


def test_reports_of_strangers_and_of_those_just_started_begin_no_episode(team):
    begin_plan(team)
    stranger = team.link.create_publisher(msg.Reports, f"/chief/{names.REPORTS}", qos.EVENTS)
    team.until(lambda: stranger.get_subscription_count() > 0)
    reports = [msg.Report(agent="stranger", episode=9, cycle=1), msg.Report(agent="a")]
    stranger.publish(msg.Reports(reports=reports))
    body = team.nodes["chief"].agent.body
    team.until(lambda: not body.members["a"].report.cycle)
    team.until(lambda: body.members["a"].report.cycle)
    assert team.nodes["chief"].agent.active_path == ["Search"]


def test_an_episode_that_is_played_again_begins_at_start_once_all_have_told_of_it(team):
    begin_plan(team)
    for name in ANTS:
        team.perceive(name, 1.0, 0.0, 0.0, episode=4)
    team.until(lambda: team.nodes["chief"].agent.active_path == ["Start"])
    search(team)
    body = team.nodes["chief"].agent.body
    for name, path in (("a", ["Search"]), ("b", ["Start"])):
        team.perceive(name, 1.0, 0.0, 0.0, episode=3)
        team.until(lambda name=name: body.members[name].report.episode == 3)
        assert team.nodes["chief"].agent.active_path == path


def test_the_time_of_a_commander_goes_on_when_a_subordinate_is_gone(team):
    perceiving_crew(team, 1.0, 1.0)
    team.end("b")
    await_value(team, "FractionSilent", 0.5)
    link = team.nodes["chief"]._link
    begun = link.seconds
    team.until(lambda: link.seconds > begun + 3 * link.body.kind.report_period)
