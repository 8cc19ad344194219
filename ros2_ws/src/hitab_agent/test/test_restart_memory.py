"""What an agent goes on with after a restart."""

import pytest

from hitab_agent.node.restart_memory import FILE_NAME, RestartMemory

RUN, NEXT_RUN = "keepaway-1", "keepaway-2"


def test_what_is_performed_is_resumed_by_the_same_swarm_only(tmp_path):
    folder = tmp_path / "state" / "keeper_1"
    assert RestartMemory(folder, RUN).performed is None
    for behavior in ("GoTo(ball)", "", "GoTo(the_far_corner)", "Go"):
        RestartMemory(folder, RUN).keep({"behavior": behavior})
        RestartMemory(folder, RUN).keep({"epoch": 3})
        after = RestartMemory(folder, RUN)
        assert (after.performed, after.values["epoch"]) == (behavior, 3)
    assert RestartMemory(folder, NEXT_RUN).performed is None
    assert RestartMemory(folder, "").performed is None


@pytest.mark.parametrize("damaged", ["", "\0" * 30, "3", '{"swarm": "keepaway-1", "b', "\xff\xfe"])
def test_a_damaged_file_is_ignored_and_replaced(tmp_path, damaged):
    (tmp_path / FILE_NAME).write_bytes(damaged.encode("latin-1"))
    memory = RestartMemory(tmp_path, RUN)
    assert memory.performed is None
    assert FILE_NAME in memory.damage
    memory.keep({"behavior": "Pass"})
    assert RestartMemory(tmp_path, RUN).performed == "Pass"
