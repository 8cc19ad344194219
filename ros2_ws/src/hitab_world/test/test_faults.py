"""A world whose own code fails says so and pauses or goes on; it does not end."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from hitab_msgs import msg, srv

from hitab_ros import EmergencySwitch, names, qos
from hitab_ros.nodes.diagnostics import Level


def test_a_world_whose_step_fails_pauses_and_says_why_until_a_step_succeeds(running):
    running.plays()
    running.world.broken.add("step")
    running.until(lambda: running.status.mode == "paused")
    running.until(lambda: any("ZeroDivisionError" in f for f in running.status.faults))
    assert "the physics" in running.status.last_error
    running.control("resume")  # which does not help yet
    running.until(lambda: running.status.mode == "paused" and running.status.faults)
    running.world.broken.clear()
    running.control("resume")
    running.plays()
    running.until(lambda: not running.status.faults)


def test_a_world_of_hosts_does_not_play_before_they_are_there(running_world):
    with running_world("--ros-args", "-p", "hosts:=1") as running:
        peer, world = running.peer, running.node
        world.control.pace = "realtime"
        running.until(lambda: running.status.agents)
        stamp = running.status.stamp
        running.until(lambda: running.status.cycle or running.status.stamp is not stamp)
        assert running.world.cycle == 0
        peer.create_subscription(msg.PerceptBatch, "/crew/percepts", lambda batch: None, qos.CYCLE)
        rosters = peer.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
        rosters.publish(msg.HostRoster(host="crew", number=1, agents=["a"]))
        running.until(lambda: running.world.cycle)


def test_who_cannot_be_shown_the_world_is_left_out_and_the_others_play(running):
    running.plays()
    running.world.broken.add("b")
    running.until(lambda: any("no percept for b" in f for f in running.status.faults))
    begun = running.world.cycle
    running.until(lambda: running.world.cycle > begun + 10 and running.world.acted == {"a"})
    assert running.status.missed_deadlines == 0  # nobody waits for its answer
    running.world.broken.clear()
    running.plays()
    running.until(lambda: not running.status.faults)


def test_a_world_that_cannot_be_drawn_goes_on(running):
    shown: list[msg.WorldState] = []
    running.peer.create_subscription(msg.WorldState, f"/{names.STATE}", shown.append, qos.LATCHED)
    running.world.broken.add("entities")
    running.until(lambda: any("KeyError" in f for f in running.status.faults))
    running.plays()
    running.world.broken.clear()
    running.until(lambda: not running.status.faults)


def test_refused_actions_are_a_fault_as_long_as_they_come(running):
    running.plays()
    running.world.refused = {"a": "a: 3 values are no action"}
    running.until(lambda: "a: 3 values are no action" in running.status.faults)
    running.world.refused = {}
    running.until(lambda: not running.status.faults)


def test_a_run_that_begins_in_another_one_is_marked_if_a_commander_is_dead(running):
    running.plays()
    running.waiting.add("b")
    running.plays()
    assert running.status.missed_deadlines == 0
    running.call(srv.Play, names.PLAY, srv.Play.Request(seed=3))
    running.until(lambda: running.status.missed_deadlines == 1)
    running.plays()
    assert (running.status.seed, running.status.reproducible) == (3, False)


def test_a_request_that_comes_before_the_agents_have_answered_makes_nobody_late(running):
    running.plays()
    running.slow = True
    for _ in range(3):  # each shows the world once more, and interrupts that
        assert running.control("pause").success
        assert running.control("pace", pace="lockstep").success
    assert running.node.round_answers.missing == []
    assert running.control("step", cycles=1).success


def test_the_diagnosis_tells_missed_deadlines_and_what_stops_the_world(running):
    arrays: list[DiagnosticArray] = []
    running.peer.create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 10)

    def shows(level: Level, text: str) -> bool:
        one = arrays[-1].status[0] if arrays else DiagnosticStatus()
        return one.level == bytes([level]) and text in one.message

    running.plays()
    running.until(lambda: shows(Level.OK, "running"))
    answers = dict(running.answers)
    running.answers["b"] = running.answers["mute"] = running.peer.create_publisher(
        msg.Action, "nowhere", qos.CYCLE
    )
    running.until(lambda: shows(Level.WARN, "no answer in time from b"))
    values = {value.key: value.value for value in arrays[-1].status[0].values}
    assert values["missing agents"] == "1"
    running.until(lambda: int(value_of(arrays[-1], "missed deadlines")) > 0)
    running.answers.update(answers)
    running.world.broken.add("step")
    running.until(lambda: shows(Level.ERROR, "the physics"))


def value_of(array: DiagnosticArray, key: str) -> str:
    return next(value.value for value in array.status[0].values if value.key == key)


def test_an_emergency_stop_pauses_the_world_until_it_is_released(running):
    told: list[msg.StopState] = []
    running.peer.create_subscription(
        msg.StopState, f"/{names.STOP_STATE}", told.append, qos.STREAM
    )
    running.until(lambda: running.world.cycle > 2)
    switch = EmergencySwitch(running.peer)
    running.until(lambda: told)
    switch.set(True, "ann", "a dog")
    running.until(lambda: running.status.mode == "paused")
    running.until(lambda: told[-1].state == msg.StopState.STOPPED)
    assert told[-1].emergencies == [*switch.known.stops]
    assert running.status.faults == ["stopped: emergency stop by ann (a dog)"]
    assert [remedy.code for remedy in running.status.remedies] == ["GO"]
    cycle = running.world.cycle
    assert "emergency stop by ann (a dog)" in running.control("resume").message
    told.clear()
    running.until(lambda: len(told) > 2)
    assert running.world.cycle == cycle
    switch.set(False, "ann")
    running.until(lambda: running.world.cycle > cycle + 2 and not running.status.faults)
