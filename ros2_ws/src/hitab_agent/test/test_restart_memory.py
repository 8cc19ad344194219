"""What an agent goes on with after a restart."""

import pytest

from hitab_agent.node.restart_memory import FOLDER, RestartMemory

RUN, NEXT_RUN = "keepaway-1", "keepaway-2"


def memory_in(state_dir, swarm):
    return RestartMemory(state_dir, "keeper_1", swarm)


def test_what_is_performed_is_resumed_by_the_same_swarm_only(tmp_path):
    folder = tmp_path / "state"
    assert memory_in(folder, RUN).performed is None
    for behavior in ("GoTo(ball)", "", "GoTo(the_far_corner)", "Go"):
        memory_in(folder, RUN).keep({"behavior": behavior})
        memory_in(folder, RUN).keep({"epoch": 3})
        after = memory_in(folder, RUN)
        assert (after.performed, after.values["epoch"]) == (behavior, 3)
    assert memory_in(folder, NEXT_RUN).performed is None
    assert memory_in(folder, "").performed is None


@pytest.mark.parametrize("damaged", ["", "\0" * 30, "3", '{"swarm": "keepaway-1", "b', "\xff\xfe"])
def test_a_damaged_file_is_ignored_and_replaced(tmp_path, damaged):
    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / "keeper_1.json").write_bytes(damaged.encode("latin-1"))
    memory = memory_in(tmp_path, RUN)
    assert memory.performed is None
    assert "keeper_1.json" in memory.damage
    memory.keep({"behavior": "Pass"})
    assert memory_in(tmp_path, RUN).performed == "Pass"
