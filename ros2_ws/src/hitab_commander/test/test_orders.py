"""Orders over topics: latched, numbered, obeyed on arrival, by role, to any depth."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from hitab_msgs import msg

from hitab_commander.commander_node import CommanderNode
from hitab_core.operations import LoadLibrary, SaveBehavior
from hitab_core.texts.errors import HitabError
from hitab_ros import give_signs_of_life, names, qos
from hitab_ros.messages.conversions import pairs_message

SQUAD = """\
commander: Squad
orders:
  Attack: {scout: Search, others: Follow}
  Retreat: Home
  Rest: nothing
features:
  AllHome: {all: AtHome}
"""
ANTS = ["a", "b"]
TO_ALL = pairs_message([("", "Wait")])


def squad(team, **settings):
    return team.commander("chief", SQUAD, ANTS, roles=["scout", "carrier"], **settings)


def test_an_order_has_each_subordinate_perform_what_it_means_for_its_role(team):
    squad(team)
    team.ant("a", "chief", "scout")
    team.ant("b", "chief", "carrier")
    assert team.perform("chief", "Attack").success
    team.until(lambda: [team.performs(name) for name in ANTS] == ["Search", "Follow"])
    team.perform("chief", "Rest")
    team.until(lambda: [team.performs(name) for name in ANTS] == ["", ""])


def test_who_joins_late_or_is_restarted_performs_the_current_order_once(team):
    squad(team)
    team.perform("chief", "Attack")
    team.ant("b", "chief", "carrier", behavior="Follow")
    team.until(lambda: team.obeying() == [False, True])
    assert team.begun("b") == ["Follow"], "it performs it already"
    team.perform("chief", "Retreat")
    team.ant("a", "chief", "scout")
    team.until(lambda: team.performs("a") == "Home")
    assert team.begun("a") == ["Home"]
    team.end("a")
    team.perform("chief", "Attack")
    team.ant("a", "chief", "scout")
    team.until(lambda: team.performs("a") == "Search")


def test_an_order_is_repeated_until_its_subordinate_reports_it(team):
    # DDS may lose an order at the moment in which a subordinate is found again.
    team.commander("chief", SQUAD, ["a"], roles=["scout"])
    reports = team.link.create_publisher(msg.Reports, f"/chief/{names.REPORTS}", qos.EVENTS)
    team.until(reports.get_subscription_count)
    given = team.orders["chief"]

    def report_until(reached, order):
        number = {"epoch": order.epoch, "sequence": order.sequence}
        one = msg.Report(agent="a", mode="performing", path=["Home"], **number)
        team.until(lambda: reports.publish(msg.Reports(reports=[one])) or reached())

    team.perform("chief", "Attack")
    team.until(lambda: given and given[-1].order == "Attack")
    first = given[-1]
    team.perform("chief", "Retreat")
    report_until(lambda: [one.order for one in given].count("Retreat") > 2, first)
    report_until(lambda: team.groups["chief"].subordinates[0].obeys, given[-1])


def test_an_old_or_repeated_order_changes_nothing(team):
    squad(team)
    team.ant("a", "chief", "scout")
    team.perform("chief", "Attack")
    team.perform("chief", "Retreat")
    team.until(lambda: team.begun("a") == ["Search", "Home"])
    attack = next(o for o in team.orders["chief"] if o.order == "Attack")
    retreat = next(o for o in team.orders["chief"] if o.order == "Retreat")
    again = team.link.create_publisher(msg.Order, f"/chief/{names.ORDER}", qos.LATCHED)
    team.until(lambda: again.get_subscription_count() > 1)
    fence = msg.Order(epoch=retreat.epoch, sequence=retreat.sequence + 1, order="Wait")
    fence.behaviors = TO_ALL
    for order in (retreat, attack, fence):
        again.publish(order)
        team.executor.spin_once(timeout_sec=0.1)
    team.until(lambda: team.performs("a") == "Wait")
    assert team.begun("a") == ["Search", "Home", "Wait"]


def test_the_orders_of_a_restarted_commander_are_newer_and_it_goes_on_where_it_was(team):
    squad(team)
    team.ant("a", "chief", "scout")
    team.perform("chief", "Retreat")
    team.until(lambda: team.performs("a") == "Home")
    before = team.orders["chief"][-1]
    team.end("chief")
    squad(team)
    team.until(lambda: team.orders["chief"][-1].epoch > before.epoch)
    now = team.orders["chief"][-1]
    assert (now.order, team.performs("chief")) == ("Retreat", "Retreat")
    team.until(lambda: team.obeying()[:1] == [True])
    assert team.begun("a") == ["Home"]
    team.perform("chief", "Attack")
    team.until(lambda: team.performs("a") == "Search")


def test_a_commander_that_cannot_remember_its_orders_gives_them_all_the_same(team):
    (team.folder / "file").touch()
    squad(team, state_dir=str(team.folder / "file" / "state"))
    team.ant("a", "chief", "scout")
    assert team.perform("chief", "Attack").success
    team.until(lambda: team.performs("a") == "Search")


def test_a_commander_that_ordered_nothing_leaves_its_subordinates_alone(team):
    team.ant("a", "chief", "scout", behavior="Wait")
    squad(team)
    team.until(lambda: [s.behavior for s in team.groups["chief"].subordinates][:1] == ["Wait"])
    assert team.begun("a") == ["Wait"]
    assert team.groups["chief"].order == ""


def test_the_demonstrator_wins_and_the_order_is_taken_up_afterwards(team):
    squad(team)
    team.ant("a", "chief", "scout")
    team.perceive("a", 0.0, 0.0, 0.0)
    team.train("a", "Mine", "X")
    team.command("a", "Wait")
    team.perform("chief", "Attack")
    team.until(lambda: team.statuses["a"].order.waits)
    status = team.statuses["a"]
    assert (status.mode, status.order.commander, status.order.behavior) == (
        "training",
        "chief",
        "Search",
    )
    assert team.begun("a") == ["Wait"]
    team.perform("chief", "Retreat")
    team.until(lambda: team.statuses["a"].order.behavior == "Home")
    assert team.do("a", SaveBehavior()).success
    team.until(lambda: team.performs("a") == "Home")
    team.until(lambda: not team.statuses["a"].order.waits)
    assert team.begun("a") == ["Wait", "Home"]


def test_an_order_is_passed_on_through_commanders_of_commanders_on_arrival(team):
    slow = "rate: 0.01\n"  # so that nothing happens by the clock
    top = "commander: Top\norders: {War: Attack, Peace: Retreat}\n" + slow
    team.commander("general", top, ["major"])
    middle = "commander: Middle\norders: {Attack: Attack, Retreat: Retreat}\n" + slow
    team.commander("major", middle, ["chief"], "general")
    team.commander("chief", SQUAD + slow, ANTS, "major", roles=["scout", "carrier"])
    team.ant("a", "chief", "scout")
    team.ant("b", "chief", "carrier")
    team.perform("general", "War")
    team.until(lambda: [team.performs(n) for n in ANTS] == ["Search", "Follow"], 5.0)
    team.perform("general", "Peace")
    team.until(lambda: [team.performs(n) for n in ANTS] == ["Home", "Home"], 5.0)


def test_an_order_can_be_about_one_subordinate(team):
    kind = (
        "commander: Squad\n"
        "orders:\n  Send(A): {A: Search, others: keep}\n  Rest: nothing\n"
        "targets:\n  foremost: {maximum: X}\nfeatures:\n  MeanX: {mean: X}\n"
    )
    team.commander("chief", kind, ANTS)
    for name in ANTS:
        team.ant(name, "chief", behavior="Wait")
        team.perceive(name, 1.0 if name == "b" else 0.0, 0.0, 0.0)
    team.until(lambda: team.sees("chief", "MeanX") == 0.5)
    assert team.perform("chief", "Send(foremost)").success
    team.until(lambda: team.performs("b") == "Search")
    assert team.begun("a") == ["Wait"]
    assert team.orders["chief"][-1].order == "Send(b)"
    team.perceive("a", 2.0, 0.0, 0.0)
    team.until(lambda: team.performs("a") == "Search")


def test_who_is_to_go_on_goes_on_though_all_others_get_an_order(team):
    kind = (
        "commander: Squad\n"
        "orders:\n  Home: {scout: keep, others: Home}\n  Spare(A): {A: keep, others: Wait}\n"
        "targets:\n  first: {number: 1}\n"
    )
    team.commander("chief", kind, ["a", "b", "c"], roles=["scout", "carrier", ""])
    for name, role in (("a", "scout"), ("b", "carrier"), ("c", "")):
        team.ant(name, "chief", role, behavior="Search")
    team.perform("chief", "Home")
    team.until(lambda: [team.performs(name) for name in "bc"] == ["Home", "Home"])
    team.perform("chief", "Spare(first)")
    team.until(lambda: [team.performs(name) for name in "bc"] == ["Wait", "Wait"])
    team.until(lambda: team.obeying() == [True, True, True])
    assert team.begun("a") == ["Search"]


def test_a_commander_that_was_made_idle_is_idle_after_a_restart(team):
    squad(team, behavior="Attack")
    team.ant("a", "chief", "scout")
    team.until(lambda: team.performs("a") == "Search")
    team.perform("chief", "")
    team.until(lambda: team.groups["chief"].mode == "idle")
    before = team.orders["chief"][-1]
    team.end("chief")
    squad(team, behavior="Attack")
    team.until(lambda: team.orders["chief"][-1].epoch > before.epoch)
    team.until(lambda: team.obeying()[:1] == [True])
    assert (team.performs("chief"), team.performs("a")) == ("", "Search")


def test_that_an_order_does_not_wait_any_more_is_told_though_nothing_else_has_changed(team):
    squad(team)
    team.ant("a", "chief", "scout")
    team.perceive("a", 0.0, 0.0, 0.0)
    team.train("a", "Search2", "X")
    team.perform("chief", "Attack")
    team.until(lambda: team.statuses["a"].order.waits)
    report = team.nodes["a"].superior.subordinate.report()
    body = team.nodes["chief"].agent.body
    waiting = replace(report, waits=True)
    body.hear(waiting, body.now)
    assert not body.hear(waiting, body.now)
    assert body.hear(replace(report, waits=False), body.now)


def test_an_order_that_waits_tells_why_as_long_as_it_does(team):
    kind = "commander: Squad\norders: {Sing: Sing, Retreat: Home}\n"
    team.commander("chief", kind, ["a"])
    team.ant("a", "chief")
    team.perceive("a", 0.0, 0.0, 0.0)
    team.train("a", "Mine", "X")
    team.perform("chief", "Sing")
    team.until(lambda: team.statuses["a"].order.waits)
    assert team.statuses["a"].last_error == ""
    why = 'cannot obey the order "Sing": unknown behavior "Sing"'
    team.perform("a", "")
    team.until(lambda: why in team.statuses["a"].last_error)
    team.do("a", LoadLibrary())
    team.until(lambda: team.statuses["a"].mode == "idle")
    assert why in team.statuses["a"].last_error
    team.perform("chief", "Retreat")
    team.until(lambda: team.statuses["a"].behavior == "Home")
    assert not team.statuses["a"].last_error


def test_an_order_that_could_not_be_begun_is_begun_with_a_later_percept(team):
    squad(team)
    body = team.ant("a", "chief", "scout").agent.body
    body.begun = None  # its Search cannot be begun like this
    team.perform("chief", "Attack")
    team.until(lambda: 'cannot obey the order "Attack"' in team.statuses["a"].last_error)
    body.begun = []
    team.perceive("a", 0.0, 0.0, 0.0)
    team.until(lambda: team.statuses["a"].behavior == "Search")
    team.until(lambda: team.obeying()[:1] == [True])
    assert body.begun == ["Search"]
    assert not team.statuses["a"].last_error


def test_an_order_that_is_described_otherwise_after_a_restart_means_what_it_does_now(team):
    kind = (
        "commander: Squad\norders:\n  Go: Search\n  Send(A): {A: Search, others: keep}\n"
        "targets:\n  first: {number: 1}\n"
    )
    team.commander("chief", kind, ["a"])
    team.ant("a", "chief")
    for order, given in (("Go", "Go"), ("Send(first)", "Send(a)")):
        team.perform("chief", order)
        team.until(lambda: team.performs("a") == "Search")
        team.end("chief")
        team.commander("chief", kind.replace("Search", "Follow"), ["a"])
        team.until(lambda: team.performs("a") == "Follow")
        assert team.orders["chief"][-1].order == given
        team.end("chief")
        team.commander("chief", kind, ["a"])
    team.end("chief")
    team.commander("chief", "commander: Squad\norders: {Stay: Wait}\n", ["a"])
    team.until(lambda: not team.orders["chief"][-1].sequence)
    assert team.performs("chief") == ""
    team.perform("chief", "Stay")
    team.until(lambda: team.performs("a") == "Wait")


def test_a_commander_of_no_kind_is_refused_with_the_way_out(team):
    with pytest.raises(HitabError, match="chief has no domain; give it -p dom"):
        CommanderNode(namespace="/chief", context=team.context, use_global_arguments=False)


def forge(team, **fields):
    """Order something in the chief's name."""
    publisher = team.link.create_publisher(msg.Order, f"/chief/{names.ORDER}", qos.LATCHED)
    team.until(lambda: publisher.get_subscription_count() > 0)
    order = msg.Order(commander="chief", order="Forged", behaviors=TO_ALL, **fields)
    # DDS may lose what is published at the moment of the match.
    heard = team.orders["chief"]
    team.until(lambda: publisher.publish(order) or any(o.order == "Forged" for o in heard))
    return publisher


def test_the_real_commander_is_obeyed_after_somebody_has_ordered_in_its_name(team):
    # With the forged number all that the commander orders later would be older.
    squad(team)
    team.ant("a", "chief", "scout")
    team.perform("chief", "Attack")
    team.until(lambda: team.performs("a") == "Search")
    real = team.orders["chief"][-1]
    forged = forge(team, epoch=real.epoch + 10**9, sequence=2**63)
    team.until(lambda: "Wait" in team.begun("a"))
    team.until(lambda: team.performs("a") == "Search")
    team.perform("chief", "Retreat")
    team.until(lambda: team.performs("a") == "Home")
    team.until(lambda: team.obeying() == [True, False])
    team.link.destroy_publisher(forged)


def test_an_order_from_the_far_future_is_not_heard(team):
    # No clock is wrong by years: whoever obeyed it could be ordered nothing else for ever.
    squad(team)
    team.ant("a", "chief", "scout")
    team.perform("chief", "Attack")
    team.until(lambda: team.performs("a") == "Search")
    forged = forge(team, epoch=2**63, sequence=1)
    team.perform("chief", "Retreat")
    team.until(lambda: team.performs("a") == "Home")
    assert "Wait" not in team.begun("a")
    team.link.destroy_publisher(forged)


def test_what_is_wrong_with_a_commander_is_shown_with_its_group(team):
    chief = squad(team)
    team.ant("a", "chief", "scout")
    chief.guard.failed("hearing", RuntimeError("the wire is cut"))
    team.until(lambda: any("the wire is cut" in f for f in team.groups["chief"].faults))
    team.until(lambda: any("the wire is cut" in f for f in team.statuses["chief"].faults))
    chief.guard.faults.clear("hearing")
    team.until(lambda: not team.groups["chief"].faults and not team.statuses["chief"].faults)


def test_who_is_stopped_or_out_of_reach_is_not_counted_among_those_that_perform(team):
    squad(team)
    a, b = (team.ant(name, "chief") for name in ANTS)
    team.perform("chief", "Retreat")
    team.until(lambda: team.obeying() == [True, True])
    a.stop = SimpleNamespace(why="stopped: a dog", is_emergency=True, cause=lambda why: None)
    a.stop_changed()
    team.until(lambda: team.obeying() == [False, True])
    first, second = team.groups["chief"].subordinates
    assert (first.stopped, first.behavior, second.stopped) == (True, "", False)
    a.stop.why = ""
    a.stop_changed()
    team.until(lambda: team.obeying() == [True, True])
    team.end("b")
    team.until(lambda: team.obeying() == [True, False])
    assert team.groups["chief"].subordinates[1].silent
    assert b.agent.behavior == "Home"


def test_a_subordinate_that_is_to_halt_does_nothing_while_its_commander_is_out_of_reach(team):
    team.gives_signs = False
    chief = squad(team)
    settings = {"when_out_of_reach": "halt", "out_of_reach_after": 1.5}
    ant = team.ant("a", "chief", "scout", **settings)
    signs = team.link.create_publisher(msg.Alive, f"/{names.ALIVE}", qos.SIGNS_OF_LIFE)
    team.until(signs.get_subscription_count)
    give = signs.publish
    team.perform("chief", "Retreat")
    team.until(lambda: team.performs("a") == "Home")

    def acts() -> bool:
        return bool(ant.answer(msg.Percept())[0])

    team.perceive("a", 0.0, 0.0, 0.0)
    assert acts()
    give(msg.Alive(process="chief"))
    team.until(lambda: "chief is out of reach" in "".join(team.statuses["a"].faults))
    assert not acts()
    give(msg.Alive(process="major"))  # which is not its commander
    rosters = team.link.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    rosters.publish(msg.HostRoster(host="host", number=1, agents=["chief"], swarm="team"))
    team.until(rosters.get_subscription_count)
    assert not acts()
    team.until(lambda: give(msg.Alive(process="host")) or acts())
    team.until(lambda: not acts())
    rosters.publish(msg.HostRoster(host="host", number=2, swarm="team"))
    give_signs_of_life(chief)
    team.until(acts)
    assert ant.agent.behavior == "Home", "it goes on by itself"
