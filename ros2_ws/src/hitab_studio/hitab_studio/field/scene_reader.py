"""Reads scenes from the bytes of a world's states.

To convert the message of ten thousand things takes half a cycle. From one cycle to the next, only
numbers change, so the other parts of a scene are taken from the last conversion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from hitab_msgs.msg import WorldState
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message
from std_msgs.msg import Header

from hitab_core import CYCLE_MAX
from hitab_ros.messages.checks import check
from hitab_ros.messages.stamps import seconds_of
from hitab_studio.field.scene import AS_IN_STATE, KNOWN_FIELDS, Scene, scene_of

BEGIN = 4
"""Size of the header before the fields in the encoding of DDS (CDR)."""

WORD = 8
"""Size and alignment of a number, bytes."""


@dataclass(frozen=True)
class SceneState:
    """A world's state as the studio needs it.

    Attributes:
        header, cycle, change: as in `WorldState`.
        scene: the scene.
    """

    header: Header
    cycle: int
    change: int
    scene: Scene


class _Layout:
    """Places of the numbers in the bytes of a state, in words.

    Args:
        data: the bytes.
        state: the `WorldState`.
        scene: its scene.
    """

    def __init__(self, data: bytes, state: Any, scene: Scene) -> None:
        self._frame_id, self._scene = state.header.frame_id, scene
        at = _after_text(8, state.header.frame_id)
        at = _aligned(_after_text(_after_text(at, state.world), state.mode))
        self._cycle = at // WORD  # then the episode and its cycle
        at += 5 * WORD + 4
        begins = []
        for entity in state.entities:
            begins.append(at := _aligned(_after_text(_after_text(at, entity.name), entity.kind)))
            at = _after_text(at + (len(KNOWN_FIELDS) + 1) * WORD, entity.say)
        self._places = np.array(begins, dtype=int)[:, None] // WORD + np.arange(len(KNOWN_FIELDS))
        self._change = (len(data) - BEGIN - 4 - len(state.note.encode()) - 1) // WORD - 1
        self._others = self._without_numbers(data, _words(data))

    def _without_numbers(self, data: bytes, words: NDArray[np.uint64]) -> bytes:
        """Return the bytes of a state of this size with zeros in place of the numbers."""
        words = words.copy()
        words[[0, self._cycle, self._cycle + 1, self._cycle + 2, self._change]] = 0
        words[self._places] = 0
        return data[:BEGIN] + words.tobytes() + data[BEGIN + words.nbytes :]

    def read(self, data: bytes) -> SceneState | None:
        """Return the state with these bytes; None if not only numbers have changed."""
        if len(data) != len(self._others):
            return None
        words = _words(data)
        if self._without_numbers(data, words) != self._others:
            return None
        first = self._cycle
        cycle, episode, episode_cycle, change = map(
            int, (*words[first : first + 3], words[self._change])
        )
        if max(cycle, episode_cycle) > CYCLE_MAX:
            return None
        first_word = words[:1]
        stamp = Time(
            sec=int(first_word.view(np.int32)[0]), nanosec=int(first_word.view(np.uint32)[1])
        )
        places = words.view(np.float64)[self._places]
        places.setflags(write=False)
        scene = replace(
            self._scene,
            cycle=cycle,
            episode=episode,
            episode_cycle=episode_cycle,
            seconds=seconds_of(stamp),
            places=places,
        )
        return SceneState(Header(stamp=stamp, frame_id=self._frame_id), cycle, change, scene)


class SceneReader:
    """Reads one state after the other."""

    def __init__(self) -> None:
        self._layout: _Layout | None = None

    def __call__(self, data: bytes) -> SceneState:
        """Return the state with these bytes.

        Raises:
            BadMessage: if a field is invalid.
            RuntimeError: if the bytes are no state.
        """
        if self._layout is not None and (state := self._layout.read(data)) is not None:
            return state
        message = deserialize_message(data, WorldState)
        check(message)
        read = SceneState(message.header, message.cycle, message.change, scene_of(message))
        self._layout = _Layout(data, message, read.scene)
        # Another machine's encoding may differ; then every state is converted.
        if not _same(self._layout.read(data), read):
            self._layout = None
        return read


def _same(one: SceneState | None, other: SceneState) -> bool:
    """Whether the numbers of two states are equal, NaN included."""
    return one is not None and all(
        (
            (one.header, one.change) == (other.header, other.change),
            all(getattr(one.scene, name) == getattr(other.scene, name) for name in AS_IN_STATE),
            one.scene.places.tobytes() == other.scene.places.tobytes(),
        )
    )


def _words(data: bytes) -> NDArray[np.uint64]:
    body = data[BEGIN : len(data) - (len(data) - BEGIN) % WORD]
    return np.frombuffer(body, dtype=np.uint64)


def _aligned(at: int) -> int:
    return at + -at % WORD


def _after_text(at: int, text: str) -> int:
    return at + -at % 4 + 4 + len(text.encode()) + 1
