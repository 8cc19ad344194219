"""A client that could not run has not waited: on a busy machine others are late, too."""

import time

from hitab_client.ros_link import RosLink
from hitab_ros.patience import BUSY_FACTOR


class Late(RosLink):
    """A client whose waits end late; no node is behind it."""

    def __init__(self, late: float) -> None:
        self.late = late

    def spin(self, seconds: float = 0.1) -> None:
        time.sleep(seconds + self.late)


def looks(link: RosLink, seconds: float, work: float = 0.0) -> int:
    """Return how often a condition is looked at in this time.

    Args:
        link: to wait with.
        seconds: how long.
        work: what a look costs, s of the processor.
    """
    count = 0

    def never() -> bool:
        nonlocal count
        count += 1
        end = time.process_time() + work
        while time.process_time() < end:
            pass
        return False

    assert not link.spin_until(never, seconds, each=0.05)
    return count


def test_time_in_which_it_could_not_run_does_not_count():
    assert looks(Late(0.1), 0.2) >= 4  # in three times the time


def test_there_is_an_end_to_that():
    assert looks(Late(0.4 * BUSY_FACTOR), 0.2) == 2


def test_its_own_work_counts():
    assert looks(Late(0.0), 0.4, work=0.05) <= 5
