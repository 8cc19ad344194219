"""What a commander remembers across a restart of its process."""

import json

from hitab_commander.order_memory import ORDERS_FILE, OrderMemory, Remembered

LONG = Remembered(3, "Attack", "Send(scout_17)")
SHORT = Remembered(3, "Rest", "Rest")


def test_the_last_of_what_was_kept_is_remembered(tmp_path):
    memory = OrderMemory(tmp_path / "state" / "chief")
    assert memory.remembered == Remembered()
    for what in (SHORT, LONG, SHORT):
        memory.keep(what)
        assert OrderMemory(tmp_path / "state" / "chief").remembered == what


def test_a_process_started_again_has_a_later_epoch_even_when_the_clock_went_back(tmp_path):
    memory = OrderMemory(tmp_path)
    far = Remembered(memory.next_epoch() + 10**18, "Rest", "Rest")
    memory.keep(far)
    assert OrderMemory(tmp_path).next_epoch() > far.epoch


def test_what_cannot_be_read_is_taken_for_a_commander_that_has_ordered_nothing(tmp_path):
    file = tmp_path / ORDERS_FILE
    whole = json.dumps({"epoch": 1, "behavior": "A", "label": "A"})
    for text in ("", "\0" * 40, whole[:-9], '{"epoch": "one"}', "[]", "\xff\xfe"):
        file.write_bytes(text.encode("latin-1"))
        memory = OrderMemory(tmp_path)
        assert memory.remembered == Remembered()
        memory.keep(SHORT)
        assert OrderMemory(tmp_path).remembered == SHORT
