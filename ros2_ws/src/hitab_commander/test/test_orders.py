"""Orders over topics: latched, numbered, obeyed on arrival, by role, to any depth."""

from dataclasses import replace

import pytest
from hitab_msgs import msg, srv

from hitab_commander.commander_node import CommanderNode
from hitab_core.errors import HitabError
from hitab_ros import names, qos

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


def squad(troop, **settings):
    return troop.commander("chief", SQUAD, ANTS, roles=["scout", "carrier"], **settings)


def test_an_order_has_each_subordinate_perform_what_it_means_for_its_role(troop):
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.ant("b", "chief", "carrier")
    assert troop.perform("chief", "Attack").success
    troop.until(lambda: [troop.performs(name) for name in ANTS] == ["Search", "Follow"])
    troop.perform("chief", "Rest")
    troop.until(lambda: [troop.performs(name) for name in ANTS] == ["", ""])


def test_who_joins_late_performs_the_current_order(troop):
    squad(troop)
    troop.perform("chief", "Attack")
    troop.perform("chief", "Retreat")
    troop.ant("a", "chief", "scout")
    troop.until(lambda: troop.performs("a") == "Home")
    assert troop.begun("a") == ["Home"]


def test_who_is_restarted_performs_the_current_order(troop):
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.perform("chief", "Attack")
    troop.until(lambda: troop.performs("a") == "Search")
    troop.end("a")
    troop.perform("chief", "Retreat")
    troop.ant("a", "chief", "scout")
    troop.until(lambda: troop.performs("a") == "Home")


def test_an_old_or_repeated_order_changes_nothing(troop):
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.perform("chief", "Attack")
    troop.perform("chief", "Retreat")
    troop.until(lambda: troop.begun("a") == ["Search", "Home"])
    attack = next(o for o in troop.orders["chief"] if o.order == "Attack")
    retreat = next(o for o in troop.orders["chief"] if o.order == "Retreat")
    again = troop.link.create_publisher(msg.Order, f"/chief/{names.ORDER}", qos.LATCHED)
    troop.until(lambda: again.get_subscription_count() > 1)
    fence = msg.Order(epoch=retreat.epoch, sequence=retreat.sequence + 1, order="Wait")
    fence.receivers, fence.behaviors = [""], ["Wait"]
    for order in (retreat, attack, fence):
        again.publish(order)
        troop.executor.spin_once(timeout_sec=0.1)
    troop.until(lambda: troop.performs("a") == "Wait")
    assert troop.begun("a") == ["Search", "Home", "Wait"]


def test_who_performs_the_ordered_behavior_already_is_not_restarted(troop):
    squad(troop)
    troop.ant("b", "chief", "carrier", behavior="Follow")
    troop.perform("chief", "Attack")
    troop.until(lambda: troop.statuses["b"].ordered == "Follow")
    troop.until(lambda: troop.groups["chief"].obeying == [False, True])
    assert troop.begun("b") == ["Follow"]


def test_the_orders_of_a_restarted_commander_are_newer_and_it_goes_on_where_it_was(troop):
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.perform("chief", "Retreat")
    troop.until(lambda: troop.performs("a") == "Home")
    before = troop.orders["chief"][-1]
    troop.end("chief")
    squad(troop)
    troop.until(lambda: troop.orders["chief"][-1].epoch > before.epoch)
    now = troop.orders["chief"][-1]
    assert (now.order, troop.performs("chief")) == ("Retreat", "Retreat")
    troop.until(lambda: list(troop.groups["chief"].obeying)[:1] == [True])
    assert troop.begun("a") == ["Home"]
    troop.perform("chief", "Attack")
    troop.until(lambda: troop.performs("a") == "Search")


def test_a_commander_that_cannot_remember_its_orders_gives_them_all_the_same(troop):
    (troop.folder / "file").touch()
    squad(troop, state_dir=str(troop.folder / "file" / "state"))
    troop.ant("a", "chief", "scout")
    assert troop.perform("chief", "Attack").success
    troop.until(lambda: troop.performs("a") == "Search")


def test_a_commander_that_ordered_nothing_leaves_its_subordinates_alone(troop):
    troop.ant("a", "chief", "scout", behavior="Wait")
    squad(troop)
    troop.until(lambda: list(troop.groups["chief"].behaviors)[:1] == ["Wait"])
    assert troop.begun("a") == ["Wait"]
    assert troop.groups["chief"].order == ""


def test_the_demonstrator_wins_and_the_order_is_taken_up_afterwards(troop):
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.perceive("a", 0.0, 0.0, 0.0)
    troop.ask(srv.BeginTraining, "a", names.BEGIN, automaton="Mine", features=["X"])
    troop.command("a", "Wait")
    troop.perform("chief", "Attack")
    troop.until(lambda: troop.statuses["a"].order_waits)
    status = troop.statuses["a"]
    assert (status.mode, status.superior, status.ordered) == ("training", "chief", "Search")
    assert troop.begun("a") == ["Wait"]
    troop.perform("chief", "Retreat")
    troop.until(lambda: troop.statuses["a"].ordered == "Home")
    assert troop.ask(srv.SaveBehavior, "a", names.SAVE).success
    troop.until(lambda: troop.performs("a") == "Home")
    troop.until(lambda: not troop.statuses["a"].order_waits)
    assert troop.begun("a") == ["Wait", "Home"]


def test_an_order_that_cannot_be_obeyed_waits_and_tells_why(troop):
    kind = "commander: Squad\norders: {Sing: Sing, Retreat: Home}\n"
    troop.commander("chief", kind, ["a"])
    troop.ant("a", "chief")
    troop.perform("chief", "Sing")
    troop.until(lambda: troop.statuses["a"].order_waits)
    assert 'cannot obey the order "Sing": unknown behavior "Sing" (has: Follow, Home' in (
        troop.statuses["a"].last_error
    )
    troop.perform("chief", "Retreat")
    troop.until(lambda: troop.performs("a") == "Home")


def test_an_order_is_passed_on_through_commanders_of_commanders_on_arrival(troop):
    slow = "rate: 0.01\n"  # so that nothing happens by the clock
    top = "commander: Top\norders: {War: Attack, Peace: Retreat}\n" + slow
    troop.commander("general", top, ["major"])
    middle = "commander: Middle\norders: {Attack: Attack, Retreat: Retreat}\n" + slow
    troop.commander("major", middle, ["chief"], "general")
    troop.commander("chief", SQUAD + slow, ANTS, "major", roles=["scout", "carrier"])
    troop.ant("a", "chief", "scout")
    troop.ant("b", "chief", "carrier")
    troop.perform("general", "War")
    troop.until(lambda: [troop.performs(n) for n in ANTS] == ["Search", "Follow"], 5.0)
    troop.perform("general", "Peace")
    troop.until(lambda: [troop.performs(n) for n in ANTS] == ["Home", "Home"], 5.0)


def test_an_order_can_be_about_one_subordinate(troop):
    kind = (
        "commander: Squad\n"
        "orders:\n  Send(A): {A: Search, others: keep}\n  Rest: nothing\n"
        "targets:\n  foremost: {maximum: X}\nfeatures:\n  MeanX: {mean: X}\n"
    )
    troop.commander("chief", kind, ANTS)
    for name in ANTS:
        troop.ant(name, "chief", behavior="Wait")
        troop.perceive(name, 1.0 if name == "b" else 0.0, 0.0, 0.0)
    troop.until(lambda: troop.sees("chief", "MeanX") == 0.5)
    assert troop.perform("chief", "Send(foremost)").success
    troop.until(lambda: troop.performs("b") == "Search")
    assert troop.begun("a") == ["Wait"]
    assert troop.orders["chief"][-1].order == "Send(b)"
    troop.perceive("a", 2.0, 0.0, 0.0)
    troop.until(lambda: troop.performs("a") == "Search")


def test_who_is_to_go_on_goes_on_though_all_others_get_an_order(troop):
    kind = (
        "commander: Squad\n"
        "orders:\n  Home: {scout: keep, others: Home}\n  Spare(A): {A: keep, others: Wait}\n"
        "targets:\n  first: {number: 1}\n"
    )
    troop.commander("chief", kind, ["a", "b", "c"], roles=["scout", "carrier", ""])
    for name, role in (("a", "scout"), ("b", "carrier"), ("c", "")):
        troop.ant(name, "chief", role, behavior="Search")
    troop.perform("chief", "Home")
    troop.until(lambda: [troop.performs(name) for name in "bc"] == ["Home", "Home"])
    troop.perform("chief", "Spare(first)")
    troop.until(lambda: [troop.performs(name) for name in "bc"] == ["Wait", "Wait"])
    troop.until(lambda: list(troop.groups["chief"].obeying) == [True, True, True])
    assert troop.begun("a") == ["Search"]


def test_a_commander_that_was_made_idle_is_idle_after_a_restart(troop):
    squad(troop, behavior="Attack")
    troop.ant("a", "chief", "scout")
    troop.until(lambda: troop.performs("a") == "Search")
    troop.perform("chief", "")
    troop.until(lambda: troop.groups["chief"].mode == "idle")
    before = troop.orders["chief"][-1]
    troop.end("chief")
    squad(troop, behavior="Attack")
    troop.until(lambda: troop.orders["chief"][-1].epoch > before.epoch)
    troop.until(lambda: list(troop.groups["chief"].obeying)[:1] == [True])
    assert (troop.performs("chief"), troop.performs("a")) == ("", "Search")


def test_that_an_order_does_not_wait_any_more_is_told_though_nothing_else_has_changed(troop):
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.perceive("a", 0.0, 0.0, 0.0)
    troop.ask(srv.BeginTraining, "a", names.BEGIN, automaton="Search2", features=["X"])
    troop.perform("chief", "Attack")
    troop.until(lambda: troop.statuses["a"].order_waits)
    report = troop.nodes["a"].superior.subordinate.report()
    body = troop.nodes["chief"].agent.body
    waiting = replace(report, waits=True)
    body.hear(waiting, body.now)
    assert not body.hear(waiting, body.now)
    assert body.hear(replace(report, waits=False), body.now)


def test_an_order_that_waits_tells_why_as_long_as_it_does(troop):
    kind = "commander: Squad\norders: {Sing: Sing, Retreat: Home}\n"
    troop.commander("chief", kind, ["a"])
    troop.ant("a", "chief")
    troop.perceive("a", 0.0, 0.0, 0.0)
    troop.ask(srv.BeginTraining, "a", names.BEGIN, automaton="Mine", features=["X"])
    troop.perform("chief", "Sing")
    troop.until(lambda: troop.statuses["a"].order_waits)
    assert troop.statuses["a"].last_error == ""
    why = 'cannot obey the order "Sing": unknown behavior "Sing"'
    troop.ask(srv.SetMode, "a", names.SET_MODE, mode="idle")
    troop.until(lambda: why in troop.statuses["a"].last_error)
    troop.ask(srv.LoadLibrary, "a", names.LOAD_LIBRARY)
    troop.until(lambda: troop.statuses["a"].mode == "idle")
    assert why in troop.statuses["a"].last_error
    troop.perform("chief", "Retreat")
    troop.until(lambda: troop.statuses["a"].behavior == "Home")
    assert not troop.statuses["a"].last_error


def test_an_order_that_could_not_be_begun_is_begun_with_a_later_percept(troop):
    squad(troop)
    body = troop.ant("a", "chief", "scout").agent.body
    body.begun = None  # its Search cannot be begun like this
    troop.perform("chief", "Attack")
    troop.until(lambda: 'cannot obey the order "Attack"' in troop.statuses["a"].last_error)
    body.begun = []
    troop.perceive("a", 0.0, 0.0, 0.0)
    troop.until(lambda: troop.statuses["a"].behavior == "Search")
    troop.until(lambda: list(troop.groups["chief"].obeying)[:1] == [True])
    assert body.begun == ["Search"]
    assert not troop.statuses["a"].last_error


def test_an_order_that_is_described_otherwise_after_a_restart_means_what_it_does_now(troop):
    kind = (
        "commander: Squad\norders:\n  Go: Search\n  Send(A): {A: Search, others: keep}\n"
        "targets:\n  first: {number: 1}\n"
    )
    troop.commander("chief", kind, ["a"])
    troop.ant("a", "chief")
    for order, given in (("Go", "Go"), ("Send(first)", "Send(a)")):
        troop.perform("chief", order)
        troop.until(lambda: troop.performs("a") == "Search")
        troop.end("chief")
        troop.commander("chief", kind.replace("Search", "Follow"), ["a"])
        troop.until(lambda: troop.performs("a") == "Follow")
        assert troop.orders["chief"][-1].order == given
        troop.end("chief")
        troop.commander("chief", kind, ["a"])
    troop.end("chief")
    troop.commander("chief", "commander: Squad\norders: {Stay: Wait}\n", ["a"])
    troop.until(lambda: not troop.orders["chief"][-1].sequence)
    assert troop.performs("chief") == ""
    troop.perform("chief", "Stay")
    troop.until(lambda: troop.performs("a") == "Wait")


def test_a_commander_of_no_kind_is_refused_with_the_way_out(troop):
    with pytest.raises(HitabError, match="chief was not told of what kind it is; give it -p dom"):
        CommanderNode(namespace="/chief", context=troop.context, use_global_arguments=False)


def forge(troop, **fields):
    """Order something in the chief's name."""
    publisher = troop.link.create_publisher(msg.Order, f"/chief/{names.ORDER}", qos.LATCHED)
    troop.until(lambda: publisher.get_subscription_count() > 0)
    publisher.publish(
        msg.Order(commander="chief", order="Forged", receivers=[""], behaviors=["Wait"], **fields)
    )
    return publisher


def test_the_real_commander_is_obeyed_after_somebody_has_ordered_in_its_name(troop):
    # With the forged number all that the commander orders later would be older.
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.perform("chief", "Attack")
    troop.until(lambda: troop.performs("a") == "Search")
    real = troop.orders["chief"][-1]
    forged = forge(troop, epoch=real.epoch + 10**9, sequence=2**63)
    troop.until(lambda: "Wait" in troop.begun("a"))
    troop.until(lambda: troop.performs("a") == "Search")
    troop.perform("chief", "Retreat")
    troop.until(lambda: troop.performs("a") == "Home")
    troop.until(lambda: list(troop.groups["chief"].obeying) == [True, False])
    troop.link.destroy_publisher(forged)


def test_an_order_from_the_far_future_is_not_heard(troop):
    # No clock is wrong by years: whoever obeyed it could be ordered nothing else for ever.
    squad(troop)
    troop.ant("a", "chief", "scout")
    troop.perform("chief", "Attack")
    troop.until(lambda: troop.performs("a") == "Search")
    forged = forge(troop, epoch=2**63, sequence=1)
    troop.perform("chief", "Retreat")
    troop.until(lambda: troop.performs("a") == "Home")
    assert "Wait" not in troop.begun("a")
    troop.link.destroy_publisher(forged)


def test_what_is_wrong_with_a_commander_is_shown_with_its_group(troop):
    chief = squad(troop)
    troop.ant("a", "chief", "scout")
    chief.guard.failed("hearing", RuntimeError("the wire is cut"))
    troop.until(lambda: any("the wire is cut" in f for f in troop.groups["chief"].faults))
    troop.until(lambda: any("the wire is cut" in f for f in troop.statuses["chief"].faults))
    chief.guard.faults.clear("hearing")
    troop.until(lambda: not troop.groups["chief"].faults and not troop.statuses["chief"].faults)
