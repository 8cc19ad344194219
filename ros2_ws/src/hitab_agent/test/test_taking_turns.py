"""What a host does for many agents is done in turns, and what many need is heard once."""

from collections import Counter
from types import SimpleNamespace
from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.endpoints import OfferedService
from hitab_agent.endpoints_on_demand import EndpointsOnDemand
from hitab_agent.links.order_exchange import Exchange
from hitab_agent.scheduler import JobQueue, Scheduler
from hitab_ros import names, qos
from hitab_ros.nodes.guarded_node import GuardedNode


def test_what_is_put_off_is_done_in_order_with_room_for_something_else_in_between(process):
    done: list[Any] = []
    later = JobQueue(process.node, 0.02, at_most=10)
    for number in range(40):
        later.call(lambda number=number: done.append(number))
    process.meanwhile(done)
    process.until(lambda: 39 in done)
    assert [what for what in done if what != "something else"] == list(range(40))
    for turn in range(3):
        last, first = done.index(10 * turn + 9), done.index(10 * turn + 10)
        assert "something else" in done[last:first]


def test_many_functions_of_one_rate_are_called_equally_often_in_turns(process):
    done: list[Any] = []
    scheduler = Scheduler(process.node)
    for number in range(50):
        scheduler.every(0.2, lambda number=number: done.append(number))
    process.meanwhile(done)
    process.until(lambda: done.count(49) == 4)
    counts = Counter(done)
    assert {counts[number] for number in range(50)} <= {3, 4, 5}
    assert "something else" in done[done.index(10) : done.index(40)]


def fails() -> None:
    raise IndexError("it is broken")


def test_all_who_are_under_a_commander_hear_it_through_one_subscription(process):
    node = process.node
    topic = f"/chief/{names.ORDER}"
    publisher = node.create_publisher(msg.Order, topic, qos.LATCHED)
    exchange, heard = Exchange(node, Scheduler(node)), []
    before = len(list(node.subscriptions))
    exchange.obey(node, "chief", lambda order: fails())
    for who in ("a", "b"):
        exchange.obey(node, "chief", lambda order, who=who: heard.append((who, order.name)))
    assert len(list(node.subscriptions)) == before + 1
    publisher.publish(msg.Order(commander="chief", epoch=1, sequence=1, order="Attack"))
    process.until(lambda: len(heard) == 2)
    assert heard == [("a", "Attack"), ("b", "Attack")]
    exchange.obey(node, "chief", lambda order: heard.append(("late", order.name)))
    assert heard[-1] == ("late", "Attack")


def test_what_fails_among_many_touches_no_other_and_is_shown_by_whose_it_is(process):
    # Unguarded, the first that fails takes the rest of its turn with it, and the process.
    node, other = process.node, GuardedNode("other", context=process.node.context)
    process.add(other)
    done: list[Any] = []
    later, scheduler = JobQueue(node, 0.02), Scheduler(node)
    later.call(fails, other.guard)
    later.call(lambda: done.append("later"))
    scheduler.every(0.05, fails, other.guard)
    scheduler.every(0.05, lambda: done.append("every"))
    process.until(lambda: {"later", "every"} <= {*done})
    process.until(lambda: other.guard.faults)
    assert "fails failed: IndexError" in other.guard.faults.texts()[0]
    assert not node.guard.faults


def test_who_cannot_offer_its_services_does_not_keep_others_from_it(process):
    node, other = process.node, GuardedNode("agent", namespace="/a", context=process.node.context)
    another = GuardedNode("agent", namespace="/b", context=process.node.context)
    process.add(other)
    process.add(another)
    offered: list[str] = []
    services = EndpointsOnDemand(node, Scheduler(node))
    for one, create in ((other, fails), (another, lambda: offered.append("b"))):
        service = OfferedService(one, srv.Perform, "perform", lambda *rest: None)
        one.create_service = lambda *rest, create=create: create()
        one.endpoints = SimpleNamespace(find=lambda *rest, service=service, **more: [service])
        services.add(one)
    for name in ("/a/perform", "/b/perform"):
        node.create_client(srv.Perform, name)
    process.until(lambda: offered and other.guard.faults)
    assert not another.guard.faults
