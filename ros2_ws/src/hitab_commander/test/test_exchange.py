"""Orders and reports within a host, between hosts, and to and from processes of their own."""

from typing import Any

import pytest
from hitab_msgs import msg

from hitab_ros import Lease, names, qos
from hitab_ros.messages.conversions import pairs_message

SQUAD = """\
commander: Squad
orders: {Attack: Search, Retreat: Home, Rest: nothing}
"""
TOPICS = {names.ORDER, names.REPORTS}


def squad(team, host=None, *ants):
    return team.commander("chief", SQUAD, ants or ["a", "b"], host=host)


def two_hosts(team):
    """Return a chief with ant a in one host, and the host of ant b."""
    first, second = team.host("first"), team.host("second")
    team.ant("a", "chief", host=first)
    squad(team, first)
    team.ant("b", "chief", host=second)
    return first, second


def all_perform(team, order, behavior, *ants):
    team.perform("chief", order)
    team.until(lambda: {team.performs(name) for name in ants or "ab"} == {behavior})
    team.until(lambda: all(team.obeying()))


def topics_of(node) -> set[str]:
    ends = [*node.publishers, *node.subscriptions]
    return {end.topic_name.rpartition("/")[2] for end in ends} & TOPICS


def test_within_a_host_nothing_is_sent(team):
    host = team.host("first")
    for name in "ab":
        team.ant(name, "chief", host=host)
    chief = team.commander("chief", SQUAD, ["a", "b"], host=host, orders_are_shown=False)
    host.publish_roster()
    all_perform(team, "Attack", "Search")
    all_perform(team, "Retreat", "Home")
    assert not host.batches
    assert not topics_of(chief)


def test_hosts_send_one_another_batches_for_those_who_live_there(team):
    first, second = two_hosts(team)
    for host in (first, second, third := team.host("third")):
        host.publish_roster()
    all_perform(team, "Attack", "Search")
    all_perform(team, "Retreat", "Home")
    team.until(lambda: first.batches and second.batches)
    assert {report.agent for batch in first.batches for report in batch.reports} == {"b"}
    assert {order.commander for batch in second.batches for order in batch.orders} == {"chief"}
    assert not third.batches
    assert team.begun("b") == ["Search", "Home"]


def test_an_order_given_before_the_rosters_are_known_is_obeyed_afterwards(team):
    first, second = two_hosts(team)
    first.publish_roster()
    team.perform("chief", "Retreat")
    team.until(lambda: team.performs("a") == "Home")
    assert not team.performs("b")
    second.publish_roster()
    team.until(lambda: team.obeying() == [True, True])
    assert team.begun("b") == ["Home"]


def test_orders_that_a_wrong_roster_leads_astray_are_repeated(team):
    first, second = two_hosts(team)
    astray = team.link.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    astray.publish(msg.HostRoster(host="nowhere", number=1, agents=["b"], swarm="team"))
    first.publish_roster()
    team.perform("chief", "Retreat")
    team.until(lambda: team.performs("a") == "Home")
    second.publish_roster()
    team.until(lambda: team.obeying() == [True, True])


def test_a_roster_of_another_swarm_misleads_nobody(team):
    first, second = two_hosts(team)
    first.publish_roster()
    second.publish_roster()
    all_perform(team, "Attack", "Search")
    other = team.link.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    team.until(lambda: other.get_subscription_count() == 2)
    other.publish(msg.HostRoster(host="nowhere", number=1, agents=["b"], swarm="other"))
    all_perform(team, "Retreat", "Home")
    all_perform(team, "Attack", "Search")


def test_a_late_batch_of_old_orders_changes_nothing(team):
    first, second = two_hosts(team)
    first.publish_roster()
    second.publish_roster()
    all_perform(team, "Attack", "Search")
    all_perform(team, "Retreat", "Home")
    again = team.link.create_publisher(msg.Orders, f"/second/{names.ORDERS}", qos.EVENTS)
    team.until(lambda: again.get_subscription_count() > 1)
    epoch, sequence = team.nodes["chief"].agent.body.order.number
    for number, behavior in (
        (sequence - 1, "Search"),
        (sequence, "Search"),
        (sequence + 1, "Wait"),
    ):
        order = msg.Order(commander="chief", epoch=epoch, sequence=number, order="Attack")
        order.behaviors = pairs_message([("", behavior)])
        again.publish(msg.Orders(orders=[order]))
    team.until(lambda: team.performs("b") == "Wait")
    assert team.begun("b") == ["Search", "Home", "Wait"]


def test_a_host_that_was_restarted_gets_the_orders_in_force(team):
    first, second = two_hosts(team)
    first.publish_roster()
    second.publish_roster()
    all_perform(team, "Retreat", "Home")
    team.end_host("second")
    second = team.host("second")
    team.ant("b", "chief", host=second)
    second.publish_roster()
    team.until(lambda: team.performs("b") == "Home")
    team.until(lambda: team.obeying() == [True, True])
    all_perform(team, "Attack", "Search")


@pytest.mark.parametrize("hosted", ["chief", "ants"])
def test_who_has_a_process_of_its_own_obeys_and_commands(team, hosted):
    host = team.host("first")
    chief = squad(team, host if hosted == "chief" else None)
    team.ant("a", "chief", host=host)
    team.ant("b", "chief", host=host if hosted == "ants" else None)
    host.publish_roster()
    all_perform(team, "Attack", "Search")
    all_perform(team, "Retreat", "Home")
    assert topics_of(chief) == TOPICS


def test_who_cannot_take_an_order_keeps_no_other_from_it(team):
    host = team.host("first")
    ants = {name: team.ant(name, "chief", host=host) for name in "ab"}
    squad(team, host)
    host.publish_roster()
    all_perform(team, "Attack", "Search")

    def fails(order: Any) -> bool:
        raise IndexError("it is broken")

    ants["a"].superior.subordinate.take = fails
    team.perform("chief", "Retreat")
    team.until(lambda: team.performs("b") == "Home")
    team.until(lambda: ants["a"].guard.faults)
    assert "it is broken" in ants["a"].guard.faults.texts()[0]
    assert not ants["b"].guard.faults
    assert not host.desk.guard.faults


def test_signs_of_life_tell_the_cycle_while_nothing_else_changes(team):
    first, second = two_hosts(team)
    first.publish_roster()
    second.publish_roster()
    all_perform(team, "Attack", "Search")
    chief = team.nodes["chief"].agent

    for host in (first, second):
        host.play(1)
    team.until(lambda: chief.cycle == 1)
    before = len(first.batches)
    for _ in range(3):
        cycle = first.play(1)
        assert second.play(1) == cycle
        team.until(lambda cycle=cycle: chief.cycle == cycle)
    assert not first.batches[before:]

    # A paused world shows no other cycle, so there is nothing to decide and time stands still.
    link, signs = team.nodes["chief"]._link, []
    hear = link.body.hear_sign
    link.body.hear_sign = lambda *sign: signs.append(hear(*sign)) or signs[-1]
    decided, seconds = link.decide, link.seconds
    link.decide = lambda **more: signs.append("decided") or decided(**more)
    team.until(lambda: len(signs) > 5)
    assert not any(signs)
    assert link.seconds == seconds


def test_agents_of_different_cycles_report_them_themselves(team):
    first, second = team.host("first"), team.host("second")
    squad(team, first)
    for name in "ab":
        team.ant(name, "chief", host=second)
    for host in (first, second):
        host.publish_roster()
    all_perform(team, "Attack", "Search")
    second.play(2)
    second.play(1)
    before = len(first.batches)
    cycle = second.play(1)
    body = team.nodes["chief"].agent.body
    team.until(lambda: body.members["a"].cycle == cycle)
    team.until(lambda: first.batches[before:])
    assert body.members["b"].cycle == 1


def test_an_observer_finds_the_reports_of_all_hosts_on_the_commanders_topic(team):
    first, second = two_hosts(team)
    shown: list[msg.Report] = []
    team.link.create_subscription(
        msg.Reports, f"/chief/{names.REPORTS}", lambda m: shown.extend(m.reports), qos.EVENTS
    )
    first.publish_roster()
    second.publish_roster()
    all_perform(team, "Attack", "Search")
    team.until(lambda: "/chief/reports" in {p.topic_name for p in team.nodes["chief"].publishers})
    all_perform(team, "Retreat", "Home")
    team.until(lambda: {r.agent for r in shown if r.path[:1] == ["Home"]} == {"a", "b"})
    assert not team.statuses["chief"].faults


@pytest.mark.parametrize(
    ("host", "agents"), [("nowhere", ["b", "chief"]), ("second", []), ("first", ["stranger"])]
)
def test_a_wrong_roster_misleads_nobody_for_longer_than_it_is_sent(team, host, agents):
    first, second = two_hosts(team)
    first.publish_roster()
    second.publish_roster()
    all_perform(team, "Attack", "Search")
    wrong = team.link.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    team.until(lambda: wrong.get_subscription_count() == 2)
    number = second.shared.roster.number + 10**9
    wrong.publish(msg.HostRoster(host=host, number=number, agents=agents, swarm="team"))
    # Nobody is there who could say whether it was received.
    team.holds(lambda: False, 0.5)
    team.link.destroy_publisher(wrong)
    all_perform(team, "Retreat", "Home")
    all_perform(team, "Attack", "Search")


def test_after_a_move_the_new_host_gets_the_orders_and_reports_of_the_old_one_do_not_count(team):
    first, old = team.host("first", Lease("lab_1", 1)), team.host("old", Lease("lab_2", 1))
    team.ant("a", "chief", host=first)
    squad(team, first)
    stale = team.ant("b", "chief", host=old)
    for host in (first, old):
        host.publish_roster()
    all_perform(team, "Retreat", "Home")
    team.nodes.pop("b")  # it goes on, since its machine does not hear of the move
    new = team.host("new", Lease("lab_3", 2))
    team.ant("b", "chief", host=new)
    new.publish_roster()
    team.until(lambda: old.yielded)
    team.until(lambda: team.performs("b") == "Home")
    chief = team.nodes["chief"].agent.body
    team.until(lambda: chief.members["b"].process == "new")
    old.batches.clear()
    all_perform(team, "Attack", "Search")
    assert not [batch for batch in old.batches if isinstance(batch, msg.Orders)]
    report = msg.Report(agent="b", commander="chief", cycle=7)
    reports = team.link.create_publisher(msg.Reports, f"/first/{names.REPORTS}", qos.EVENTS)
    team.until(lambda: reports.get_subscription_count() > 1)
    seen = len(first.batches)
    reports.publish(msg.Reports(process="old", reports=[report]))
    team.until(lambda: len(first.batches) > seen)
    assert chief.members["b"].process == "new"
    assert chief.members["b"].cycle != 7
    assert not new.yielded
    assert stale.agent.behavior == "Home"
    moved, team.nodes["b"] = team.nodes["b"], stale
    team.end_host("old")
    team.nodes["b"] = moved
