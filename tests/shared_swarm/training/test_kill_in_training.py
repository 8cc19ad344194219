"""Killing an agent in the middle of training loses no example that it has acknowledged."""

import os
import signal

from hitab_msgs.srv import EditExamples
from waiting import pid_of

AGENT = "keeper_1"
FIRST = 1_000_000  # number of a command
RESTART_SECONDS = 60


def told(example):
    return (example.number, example.state, example.next_state, example.kind, list(example.values))


def test_no_acknowledged_example_is_lost_by_kill_9(keepers):
    agents, link = keepers.agents, keepers.link
    agents.begin(AGENT, "Near", features=["DistanceTo(ball)"])
    for number, behavior in enumerate(("GoFast", "GoSlow", "Stop", "Pass"), FIRST):
        status = agents.command(AGENT, behavior, sequence=number)
        keepers.world.step()
    assert status.examples == 7
    agents.undo(AGENT)
    before = agents.training(AGENT).examples
    assert len(before) == 6

    killed = pid_of(keepers, AGENT)
    agents.statuses.pop(AGENT)
    os.kill(killed, signal.SIGKILL)
    assert link.spin_until(lambda: AGENT in agents.statuses, RESTART_SECONDS, 0.2)
    assert pid_of(keepers, AGENT) not in (0, killed)
    assert agents.statuses[AGENT].mode == "training"
    assert agents.statuses[AGENT].behavior == "Near"
    assert agents.training(AGENT).examples == before

    # A command whose acknowledgement was lost in the crash is not obeyed twice.
    again = agents.command(AGENT, "GoFast", sequence=FIRST)
    assert again.examples == 6
    # And it goes on as if nothing had happened.
    keepers.world.step()
    assert agents.command(AGENT, "GoFast").examples == 8
    agents.set_mode(AGENT, "testing", restart=True)
    agents.save(AGENT)


def test_an_edit_whose_answer_was_lost_in_a_crash_is_not_made_twice(keepers):
    agents, link = keepers.agents, keepers.link
    agents.begin(AGENT, "Near", features=["DistanceTo(ball)"], discard=True)
    for behavior in ("GoFast", "GoSlow", "Stop"):
        agents.command(AGENT, behavior)

    def undo() -> None:
        request = EditExamples.Request(action=EditExamples.Request.UNDO, request=7, client="me")
        service = f"/{AGENT}/edit_examples"
        assert link.call(EditExamples, service, request, missing=AssertionError).success

    undo()
    before = agents.training(AGENT).examples
    killed = pid_of(keepers, AGENT)
    agents.statuses.pop(AGENT)
    os.kill(killed, signal.SIGKILL)
    assert link.spin_until(lambda: AGENT in agents.statuses, RESTART_SECONDS, 0.2)
    undo()
    assert agents.training(AGENT).examples == before
    agents.undo(AGENT)
    assert len(agents.training(AGENT).examples) < len(before)
