"""Percepts of many agents in messages, of which each fits into a frame if it has to."""

from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from hitab_ros.messages.pieces import PIECE_BYTES
from hitab_ros.messages.stamps import time_of
from hitab_world.node.percept_batches import percept_batches

HEADER_BYTES = 150
COMMON = {"stamp": time_of(1.0), "sequence": 7, "cycle": 3, "episode": 1, "seed": 1}

percepts = st.tuples(
    st.lists(st.floats(-9.0, 9.0), max_size=60), st.lists(st.text("abü", max_size=9), max_size=3)
)


def _agents(batches):
    """Return the percept of each agent by its index."""
    found = {}
    for batch in batches:
        values, heard = list(batch.values), list(batch.heard)
        assert batch.sequence == 7
        counts = batch.heard_counts or [0] * len(batch.agents)
        for index, seen, said in zip(batch.agents, batch.value_counts, counts, strict=True):
            found[index] = values[:seen], heard[:said]
            del values[:seen], heard[:said]
        assert not values
        assert not heard
    return found


@given(st.lists(st.none() | percepts, max_size=40))
def test_pieces_fit_into_a_frame_and_have_all_percepts(sensed):
    meant = {index: one for index, one in enumerate(sensed) if one is not None}
    (whole,) = percept_batches(5, COMMON, enumerate(sensed))
    pieces = list(percept_batches(5, COMMON, enumerate(sensed), PIECE_BYTES))
    assert _agents([whole]) == _agents(pieces) == meant
    assert all(len(serialize_message(one)) <= PIECE_BYTES + HEADER_BYTES for one in pieces)
    assert sum(len(one.agents) for one in pieces) == len(meant)
