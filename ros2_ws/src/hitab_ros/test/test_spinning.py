"""Processes of nodes end as they should."""

import signal
from typing import Any

import pytest

from hitab_ros import GuardedNode, Spinner, run


def test_a_second_signal_to_end_does_not_cut_off_the_end() -> None:
    steps: list[str] = []

    class Node(GuardedNode):
        def destroy_node(self, *arguments: Any) -> None:
            signal.raise_signal(signal.SIGINT)
            steps.append("destroyed")
            super().destroy_node(*arguments)

    def start(spinning: Spinner) -> None:
        spinning.executor.add_node(Node("ending"))
        signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    assert run(start, []) == 0
    assert steps == ["destroyed"]
    assert signal.getsignal(signal.SIGINT) is before


def test_a_node_says_farewell_before_its_process_stops_receiving(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    steps: list[str] = []

    class Node(GuardedNode):
        def farewell(self) -> None:
            steps.append("farewell")

    monkeypatch.setattr("hitab_ros.nodes.spinning.stop_receiving", lambda _: steps.append("deaf"))

    def start(spinning: Spinner) -> None:
        spinning.executor.add_node(Node("ending"))
        spinning.stop()

    assert run(start, []) == 0
    assert steps == ["farewell", "deaf"]
