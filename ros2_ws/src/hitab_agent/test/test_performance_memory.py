"""What an agent goes on with after a restart."""

import json

import pytest

from hitab_agent.performance_memory import FILE_NAME, PerformanceMemory

RUN, NEXT_RUN = "keepaway-1", "keepaway-2"


def test_what_is_performed_is_taken_up_by_the_same_swarm_only(tmp_path):
    PerformanceMemory(tmp_path / "keeper_1", RUN).keep("GoTo(ball)")
    after = PerformanceMemory(tmp_path / "keeper_1", RUN)
    assert after.first("Chase") == "GoTo(ball)"
    assert PerformanceMemory(tmp_path / "keeper_1", NEXT_RUN).first("Chase") == "Chase"
    assert PerformanceMemory(tmp_path / "keeper_1", "").first("Chase") == "Chase"


def test_an_agent_that_was_idle_does_not_begin_again_what_it_is_started_with(tmp_path):
    PerformanceMemory(tmp_path, RUN).keep("")
    assert PerformanceMemory(tmp_path, RUN).first("Chase") == ""


def test_an_agent_of_no_swarm_leaves_no_file(tmp_path):
    PerformanceMemory(tmp_path, "").keep("Chase")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "damaged", ["", "\0" * 30, "[]", '{"swarm": "keepaway-1", "behavior"', "{}", "\xff\xfe"]
)
def test_a_damaged_file_is_ignored_and_replaced(tmp_path, damaged):
    file = tmp_path / FILE_NAME
    file.write_bytes(damaged.encode("latin-1"))
    memory = PerformanceMemory(tmp_path, RUN)
    assert memory.first("Chase") == "Chase"
    assert (str(file) in memory.damage) == (damaged != "{}")
    memory.keep("Pass")
    assert PerformanceMemory(tmp_path, RUN).performed == "Pass"


def test_a_behavior_that_is_no_text_is_ignored(tmp_path):
    (tmp_path / FILE_NAME).write_text(json.dumps({"swarm": RUN, "behavior": 3}))
    assert PerformanceMemory(tmp_path, RUN).performed is None


@pytest.mark.parametrize(
    ("before", "told"),
    [
        ("Chase", 'was restarted; it performs "Chase" again, as before'),
        ("", "was restarted; it was idle before, too"),
    ],
)
def test_a_restarted_agent_says_what_it_did_before(tmp_path, before, told):
    assert PerformanceMemory(tmp_path, RUN).restarted() == ""
    PerformanceMemory(tmp_path, RUN).keep(before)
    assert PerformanceMemory(tmp_path, RUN).restarted() == told
    assert PerformanceMemory(tmp_path, NEXT_RUN).restarted() == ""
