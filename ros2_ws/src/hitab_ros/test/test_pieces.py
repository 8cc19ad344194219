"""Pieces of a cycle are sent twice, and read once."""

from array import array

from hitab_msgs.msg import ActionBatch
from rclpy.serialization import deserialize_message

from hitab_ros.messages.pieces import PieceReader, publish_pieces


class Network:
    """A publisher that keeps what is published."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def publish(self, data: bytes) -> None:
        self.sent.append(data)


def _piece(number: int) -> ActionBatch:
    return ActionBatch(host="ants", sequence=7, agents=array("I", [number]))


def test_each_piece_is_sent_twice_with_the_others_in_between_and_read_once():
    network = Network()
    publish_pieces(network, map(_piece, range(3)))
    numbers = [deserialize_message(data, ActionBatch).agents[0] for data in network.sent]
    assert numbers == [0, 1, 2, 0, 1, 2]

    for lost in (set(), {0}, {4}, {0, 4, 5}):
        read = PieceReader(ActionBatch)
        found = [read(data) for place, data in enumerate(network.sent) if place not in lost]
        assert sorted(one.agents[0] for one in found if one is not None) == [0, 1, 2]
