"""A robot that has stopped acts only after a person has re-armed it, whatever happens."""

import itertools

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, rule

from hitab_ros import StopMachine, StopState, why_stopped

CAUSES = ("emergency stop", "silence", "agent")


class Robot(RuleBasedStateMachine):
    """One robot; its process is killed, and messages are lost, come late or out of order.

    A person re-arms it after looking at a report, which may be old, as the request may come late.
    """

    requests = Bundle("requests")

    def __init__(self):
        super().__init__()
        self.numbers = itertools.count(1)
        self.may_act = False  # by the model
        self.start()

    def start(self):
        self.machine = StopMachine(number=lambda: next(self.numbers))
        self.causes = {}

    @rule()
    def is_killed_and_starts_again(self):
        self.start()
        self.may_act = False

    @rule(name=st.sampled_from(CAUSES))
    def has_to_stand_still(self, name):
        self.machine.cause(name, f"{name}, told again or not")
        self.causes[name] = True
        self.may_act = False

    @rule(name=st.sampled_from(CAUSES))
    def a_cause_is_over(self, name):
        self.machine.cause(name, "")
        self.causes.pop(name, None)

    @rule(stands=st.booleans())
    def is_looked_at(self, stands):
        self.machine.look(stands=stands)

    @rule(target=requests)
    def a_person_decides_to_re_arm_it(self):
        return self.machine.stop

    @rule(request=requests)
    def the_request_comes(self, request):
        may = not self.causes and self.machine.stands and request == self.machine.stop
        was = self.may_act
        refusal = self.machine.arm(request)
        self.may_act = was or may
        assert bool(refusal) is not self.may_act

    @invariant()
    def acts_only_if_re_armed_after_the_last_stop(self):
        assert (self.machine.state is StopState.ARMED) is self.may_act
        assert bool(self.machine.why) is not self.may_act

    @invariant()
    def is_stopped_only_when_it_stands(self):
        if self.machine.state is StopState.STOPPED:
            assert self.machine.stands


Robot.TestCase.settings = settings(max_examples=300, stateful_step_count=40, deadline=None)
test_a_robot_that_stopped_acts_only_once_re_armed = Robot.TestCase


def test_one_that_re_arms_itself_waits_until_it_stands_and_all_causes_are_over():
    changes = []
    machine = StopMachine(rearms=True, changed=lambda: changes.append(1))
    machine.cause("agent", "no scan")
    machine.look(stands=True)
    assert machine.state is StopState.STOPPED
    machine.cause("agent", "")
    machine.look(stands=False)
    assert machine.state is StopState.STOPPING
    machine.look(stands=True)
    assert machine.state is StopState.ARMED
    assert changes


def test_a_refusal_to_re_arm_says_why():
    machine = StopMachine()
    assert machine.arm() == "it still moves"
    machine.look(stands=True)
    seen = machine.stop
    machine.cause("agent", "no scan")
    assert machine.arm() == "no scan"
    machine.cause("agent", "")
    assert machine.arm(seen) == "it has stopped once more meanwhile: no scan"
    assert machine.arm() == ""


def test_a_robot_that_never_acted_waits_to_be_armed_whatever_has_passed():
    machine = StopMachine()
    for cause in ("silence", "agent"):
        machine.cause(cause, "no sign of life")
        assert why_stopped(machine.why, machine.causes.values()) == "stopped: no sign of life"
        machine.cause(cause, "")
        machine.look(stands=True)
        assert why_stopped(machine.why, ()) == "waits to be armed: it has just started"
    assert machine.arm() == ""
    machine.cause("agent", "no scan")
    machine.cause("agent", "")
    assert why_stopped(machine.why, ()) == "waits to be armed: no scan; that is over"
