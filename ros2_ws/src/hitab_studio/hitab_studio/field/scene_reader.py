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
        swarm: identity of the world's swarm.
    """

    header: Header
    cycle: int
    change: int
    scene: Scene
    swarm: str = ""


class _Layout:
    """Places of the numbers in the bytes of a state, in words.

    Args:
        data: the bytes.
        state: the `WorldState`.
        scene: its scene.
    """

    def __init__(self, data: bytes, state: Any, scene: Scene) -> None:
        self._scene, self._frame_id, self._swarm = scene, state.header.frame_id, state.swarm
        self._size = len(data)
        self._at = 0
        # What must not change; neither the numbers nor the bytes between fields, which vary.
        self._same = np.zeros(len(data) + WORD, dtype=np.uint8)
        self._skip(WORD)  # the stamp
        for text in (state.header.frame_id, state.world, state.mode):
            self._keep_text(text)
        self._cycle = self._skip(3 * WORD) // WORD  # then the episode and its cycle
        self._keep(2 * WORD, WORD)
        self._keep(4, 4)
        begins = []
        for entity in state.entities:
            self._keep_text(entity.name)
            self._keep_text(entity.kind)
            begins.append(self._skip(len(KNOWN_FIELDS) * WORD) // WORD)
            self._keep(WORD, WORD)
            self._keep_text(entity.say)
        self._places = np.array(begins, dtype=int)[:, None] + np.arange(len(KNOWN_FIELDS))
        self._keep(4, 4)
        for look in state.looks:
            for text in (look.kind, look.color, look.shape):
                self._keep_text(text)
            self._keep(2, 1)
            self._keep(5, 4)
        self._change = self._skip(WORD) // WORD
        for text in (state.note, state.swarm):
            self._keep_text(text)
        words = _words(data)
        self._mask = self._same[: words.nbytes].view(np.uint64)
        self._others = self._without_numbers(words)

    def _skip(self, size: int) -> int:
        """Skip numbers that may change; return where they begin."""
        begin = self._at + -self._at % WORD
        self._at = begin + size
        return begin

    def _keep(self, size: int, alignment: int) -> None:
        self._at += -self._at % alignment
        self._same[self._at : self._at + size] = 255
        self._at += size

    def _keep_text(self, text: str) -> None:
        self._keep(4 + len(text.encode()) + 1, 4)

    def _without_numbers(self, words: NDArray[np.uint64]) -> bytes:
        return (words & self._mask).tobytes()

    def read(self, data: bytes) -> SceneState | None:
        """Return the state with these bytes; None if not only numbers have changed."""
        words = _words(data)
        if len(data) != self._size or self._without_numbers(words) != self._others:
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
        header = Header(stamp=stamp, frame_id=self._frame_id)
        return SceneState(header, cycle, change, scene, self._swarm)


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
        header, scene = message.header, scene_of(message)
        read = SceneState(header, message.cycle, message.change, scene, message.swarm)
        self._layout = _Layout(data, message, read.scene)
        # Another machine's encoding may differ; then every state is converted.
        if not _same(self._layout.read(data), read):
            self._layout = None
        return read


def _same(one: SceneState | None, other: SceneState) -> bool:
    """Whether the numbers of two states are equal, NaN included."""
    return one is not None and all(
        (
            (one.header, one.change, one.swarm) == (other.header, other.change, other.swarm),
            all(getattr(one.scene, name) == getattr(other.scene, name) for name in AS_IN_STATE),
            one.scene.places.tobytes() == other.scene.places.tobytes(),
        )
    )


def _words(data: bytes) -> NDArray[np.uint64]:
    """Return the fields of a state, and what fills the last word."""
    return np.frombuffer(data[BEGIN:] + bytes(-(len(data) - BEGIN) % WORD), dtype=np.uint64)
