"""Tests of nodes have a ROS domain of their own."""

import rclpy
from rclpy.context import Context

from hitab_ros.testing import context_of_its_own


def test_a_domain_that_others_use_is_passed_over():
    with context_of_its_own() as first:
        free = first.get_domain_id()
    stranger = Context()
    rclpy.init(context=stranger, domain_id=free)  # reserves nothing, as most programs
    node = rclpy.create_node("stranger", context=stranger)
    try:
        with context_of_its_own() as other:
            assert other.get_domain_id() != free
    finally:
        node.destroy_node()
        rclpy.shutdown(context=stranger)
