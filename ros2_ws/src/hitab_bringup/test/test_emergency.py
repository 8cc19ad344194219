"""The emergency stop from the command line reaches whoever listens, with no agents there."""

import threading

import pytest
import rclpy
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from hitab_bringup.main import make_app
from hitab_bringup.verbs import emergency
from hitab_client import domain_ids
from hitab_ros import EmergencySwitch, make_node


@pytest.fixture(autouse=True)
def domain_id(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield number


def hitab(capfd, *arguments):
    """Run the command; return its exit status and what it prints."""
    capfd.readouterr()
    with pytest.raises(SystemExit) as ended:
        make_app()(list(arguments))
    told = capfd.readouterr()
    return ended.value.code, told.out, told.err


@pytest.fixture
def relay(domain_id):
    """The switch of a robot's relay, which is spun in the background."""
    context = Context()
    rclpy.init(
        context=context, domain_id=domain_id, signal_handler_options=SignalHandlerOptions.NO
    )
    executor = EventsExecutor(context=context)
    node = make_node("velocity_relay", namespace="/robot_1", context=context)
    executor.add_node(node)
    ends = threading.Event()

    def spin():
        while not ends.is_set():
            executor.spin_once(timeout_sec=0.05)

    switch = EmergencySwitch(node, hands_on=True)
    thread = threading.Thread(target=spin)
    thread.start()
    yield switch
    ends.set()
    thread.join()
    executor.remove_node(node)
    node.destroy_node()
    executor.shutdown()
    context.try_shutdown()


def test_a_relay_is_stopped_and_released_though_there_is_no_agent(
    relay, domain_id, capfd, monkeypatch
):
    monkeypatch.setattr(emergency, "LOOK_S", 60.0)  # a busy machine takes its time
    monkeypatch.setattr(emergency, "DELIVER_S", 60.0)
    sent = f"sent in ROS domain {domain_id}; waiting until the robots have confirmed\n"
    assert hitab(capfd, "stop", "--reason", "a dog") == (0, "stopped: robot_1\n", sent)
    assert (relay.engaged, relay.state.reason) == (True, "a dog")
    assert hitab(capfd, "go") == (0, "released: robot_1\n", sent)
    assert not relay.engaged


def test_a_stop_that_nobody_heard_is_an_error(domain_id, capfd, monkeypatch):
    monkeypatch.setattr(emergency, "LOOK_S", 0.1)
    status, out, err = hitab(capfd, "stop")
    assert (status, out) == (1, "")
    assert f"nobody heard it: no robot's relay runs in ROS domain {domain_id};" in err
    assert "for a simulated world, use `hitab world pause`" in " ".join(err.split())
