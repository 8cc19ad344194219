"""What a commander perceives of its subordinates, over topics, and how it is trained by it."""

import math

from hitab_msgs import msg, srv

from hitab_ros import names, qos

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


def crew(troop, **settings):
    return troop.commander("chief", CREW, ANTS, **settings)


def await_value(troop, feature, value, name="chief"):
    troop.until(lambda: math.isclose(troop.sees(name, feature), value, abs_tol=1e-9))


def teach_errand(troop):
    """Teach ant a the errand: search, and raise Done at home; return its library."""
    troop.ant("a", "chief")
    troop.perceive("a", 0.0, 0.0, 0.0)
    troop.ask(srv.BeginTraining, "a", names.BEGIN, automaton="Errand", features=["AtHome"])
    troop.command("a", "Search")
    troop.perceive("a", 0.0, 0.0, 1.0)
    troop.command("a", "Done")
    assert troop.ask(srv.SaveBehavior, "a", names.SAVE).success
    return str(troop.folder / "libraries" / "a")


def test_features_sum_up_what_the_subordinates_perceive_and_where_they_are(troop):
    crew(troop)
    for name, x, y, home in (("a", 1.0, 0.0, 1.0), ("b", 5.0, 2.0, 0.0)):
        troop.ant(name, "chief")
        troop.perceive(name, x, y, home)
    await_value(troop, "MeanX", 3.0)
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
    assert {feature: troop.sees("chief", feature) for feature in expected} == expected


def test_active_states_at_any_level_are_seen_as_soon_as_they_change(troop):
    library = teach_errand(troop)
    crew(troop)
    troop.ant("b", "chief", library=library)
    troop.perform("chief", "Run")
    troop.until(lambda: troop.performs("b") == "Errand")
    await_value(troop, "Searching", 0.0)
    troop.perceive("b", 0.0, 0.0, 0.0)
    await_value(troop, "Searching", 0.5)


def test_states_inside_the_ordered_behavior_are_reported_only_to_a_commander_that_looks_at_them(
    troop,
):
    library = teach_errand(troop)
    looks = "  Searching: {fraction: {active: Search}}\n"
    for name, kind in (("chief", CREW), ("other", CREW.replace(looks, ""))):
        ant = {"chief": "b", "other": "c"}[name]
        troop.commander(name, kind, [ant])
        troop.ant(ant, name, library=library)
        troop.perform(name, "Run")
        troop.until(lambda ant=ant: troop.performs(ant) == "Errand")
        troop.perceive(ant, 0.0, 0.0, 0.0)
        troop.until(lambda ant=ant: troop.statuses[ant].active_path == ["Search"])
        await_value(troop, "MeanX", 0.0, name)
    heard = {"chief": "b", "other": "c"}
    paths = {
        name: list(troop.nodes[name].agent.body.members[ant].report.path)
        for name, ant in heard.items()
    }
    assert paths == {"chief": ["Errand", "Search"], "other": ["Errand"]}


def test_a_subordinate_that_falls_silent_is_left_out_and_counted(troop):
    crew(troop)
    for name, x in (("a", 1.0), ("b", 5.0)):
        troop.ant(name, "chief")
        troop.perceive(name, x, 0.0, 0.0)
    await_value(troop, "MeanX", 3.0)
    troop.end("b")
    await_value(troop, "FractionSilent", 0.5)
    assert troop.sees("chief", "MeanX") == 1.0
    troop.until(lambda: list(troop.groups["chief"].silent) == [False, True])
    troop.ant("b", "chief")
    await_value(troop, "FractionSilent", 0.0)


def test_an_agent_in_a_world_that_stands_still_is_not_silent(troop):
    crew(troop)
    troop.ant("a", "chief")
    troop.ant("b", "chief")
    await_value(troop, "FractionSilent", 0.0)
    # Longer than the deadline without a percept.
    assert not troop.holds(lambda: troop.sees("chief", "FractionSilent") > 0.0, 2.5)


def test_a_flag_is_up_until_the_next_order(troop):
    library = teach_errand(troop)
    crew(troop)
    troop.ant("b", "chief", library=library)
    troop.perform("chief", "Run")
    troop.until(lambda: [troop.performs(name) for name in ANTS] == ["Errand", "Errand"])
    for home in (0.0, 1.0, 0.0):  # it begins again after it has raised its flag
        troop.perceive("a", 0.0, 0.0, home)
    await_value(troop, "AnyDone", 1.0)
    assert troop.sees("chief", "AllDone") == 0.0
    for home in (0.0, 1.0):
        troop.perceive("b", 0.0, 0.0, home)
    await_value(troop, "AllDone", 1.0)
    troop.perform("chief", "Search")
    await_value(troop, "AnyDone", 0.0)


def test_a_commander_is_trained_as_an_agent_is_and_its_flag_reaches_its_own_commander(troop):
    library = teach_errand(troop)
    top = "commander: Top\norders: {Go: Mission}\nfeatures: {Over: {all: Done}}\n"
    troop.commander("general", top, ["chief"])
    crew(troop, superior="general")
    troop.ant("b", "chief", library=library)
    for name in ANTS:
        troop.perceive(name, 0.0, 0.0, 0.0)
    await_value(troop, "FractionSilent", 0.0)

    begun = troop.ask(
        srv.BeginTraining, "chief", names.BEGIN, automaton="Mission", features=["AllDone"]
    )
    assert begun.success
    troop.command("chief", "Run")
    troop.until(lambda: [troop.performs(name) for name in ANTS] == ["Errand", "Errand"])
    for name in ANTS:
        troop.perceive(name, 0.0, 0.0, 0.0)
        troop.perceive(name, 0.0, 0.0, 1.0)
    await_value(troop, "AllDone", 1.0)
    troop.command("chief", "Done")
    listed = troop.ask(srv.ListExamples, "chief", names.LIST_EXAMPLES).examples
    assert [(e.state, e.next_state, list(e.values)) for e in listed] == [
        ("Start", "Run", [0.0]),
        ("Run", "Run", [0.0]),
        ("Run", "Done", [1.0]),
    ]
    assert troop.ask(srv.SaveBehavior, "chief", names.SAVE).success
    assert (troop.folder / "libraries" / "chief" / "Mission.hfa.yaml").exists()

    # From above: the general orders what was learned, and hears when it is over.
    troop.perform("chief", "Rest")
    troop.until(lambda: [troop.performs(name) for name in ANTS] == ["", ""])
    troop.perform("general", "Go")
    troop.until(lambda: [troop.performs(name) for name in ANTS] == ["Errand", "Errand"])
    await_value(troop, "Over", 0.0, "general")
    for name in ANTS:
        troop.perceive(name, 0.0, 0.0, 0.0)
        troop.perceive(name, 0.0, 0.0, 1.0)
    await_value(troop, "Over", 1.0, "general")


def test_features_of_a_commander_are_features_of_a_subordinate_for_its_own(troop):
    top = "commander: Top\norders: {Go: Rest}\nfeatures: {Far: {mean: MeanX}, X: {group: x}}\n"
    troop.commander("general", top, ["chief"])
    crew(troop, superior="general")
    for name, x in (("a", 2.0), ("b", 4.0)):
        troop.ant(name, "chief")
        troop.perceive(name, x, 0.0, 0.0)
    await_value(troop, "Far", 3.0, "general")
    await_value(troop, "X", 3.0, "general")


def test_a_training_goes_on_after_the_commander_was_restarted(troop):
    crew(troop)
    for name in ANTS:
        troop.ant(name, "chief")
        troop.perceive(name, 1.0, 0.0, 0.0)
    await_value(troop, "MeanX", 1.0)
    troop.ask(srv.BeginTraining, "chief", names.BEGIN, automaton="Plan", features=["MeanX"])
    troop.command("chief", "Search")
    troop.until(lambda: [troop.performs(name) for name in ANTS] == ["Search", "Search"])
    troop.end("chief")
    crew(troop)
    troop.until(lambda: troop.statuses["chief"].examples == 2)
    troop.until(lambda: list(troop.groups["chief"].obeying) == [True, True])
    assert troop.begun("a") == ["Search"]


def test_the_automaton_of_a_commander_begins_at_start_with_each_episode(troop):
    crew(troop)
    for name in ANTS:
        troop.ant(name, "chief")
        troop.perceive(name, 1.0, 0.0, 0.0)
    await_value(troop, "MeanX", 1.0)
    troop.ask(srv.BeginTraining, "chief", names.BEGIN, automaton="Plan", features=["MeanX"])
    troop.command("chief", "Search")
    troop.until(lambda: troop.nodes["chief"].agent.active_path == ["Search"])
    troop.perceive("a", 1.0, 0.0, 0.0, episode=1)
    troop.until(lambda: troop.nodes["chief"].agent.active_path == ["Start"])


def begin_plan(troop):
    """Have the chief of a and b train a plan, in the state Search."""
    crew(troop)
    for name in ANTS:
        troop.ant(name, "chief")
        troop.perceive(name, 1.0, 0.0, 0.0, episode=3)
    await_value(troop, "MeanX", 1.0)
    troop.ask(srv.BeginTraining, "chief", names.BEGIN, automaton="Plan", features=["MeanX"])
    search(troop)


def search(troop):
    troop.command("chief", "Search")
    troop.until(lambda: troop.nodes["chief"].agent.active_path == ["Search"])


def test_reports_of_strangers_and_of_those_just_started_begin_no_episode(troop):
    begin_plan(troop)
    stranger = troop.link.create_publisher(msg.Reports, f"/chief/{names.REPORTS}", qos.EVENTS)
    troop.until(lambda: stranger.get_subscription_count() > 0)
    reports = [msg.Report(agent="stranger", episode=9, cycle=1), msg.Report(agent="a")]
    stranger.publish(msg.Reports(reports=reports))
    body = troop.nodes["chief"].agent.body
    troop.until(lambda: not body.members["a"].report.cycle)
    troop.until(lambda: body.members["a"].report.cycle)
    assert troop.nodes["chief"].agent.active_path == ["Search"]


def test_an_episode_that_is_played_again_begins_at_start_once_all_have_told_of_it(troop):
    begin_plan(troop)
    for name in ANTS:
        troop.perceive(name, 1.0, 0.0, 0.0, episode=4)
    troop.until(lambda: troop.nodes["chief"].agent.active_path == ["Start"])
    search(troop)
    body = troop.nodes["chief"].agent.body
    for name, path in (("a", ["Search"]), ("b", ["Start"])):
        troop.perceive(name, 1.0, 0.0, 0.0, episode=3)
        troop.until(lambda name=name: body.members[name].report.episode == 3)
        assert troop.nodes["chief"].agent.active_path == path


def test_the_time_of_a_commander_goes_on_when_a_subordinate_is_gone(troop):
    crew(troop)
    for name in ANTS:
        troop.ant(name, "chief")
        troop.perceive(name, 1.0, 0.0, 0.0)
    await_value(troop, "MeanX", 1.0)
    troop.end("b")
    await_value(troop, "FractionSilent", 0.5)
    link = troop.nodes["chief"]._link
    begun = link.seconds
    troop.until(lambda: link.seconds > begun + 3 * link.body.kind.report_period)
