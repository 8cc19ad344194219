"""Runs nodes in a process: start, spin until stopped, clean up.

The experimental EventsExecutor handles a hundred times more subscriptions than the default one.
In rclpy 7.1 it dispatches nothing under `spin()`, hence the loop over `spin_once`.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

import rclpy
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from hitab_core import HitabError
from hitab_ros.busy_timeout import BusyTimeout
from hitab_ros.nodes.dds_sockets import stop_receiving, udp_sockets
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART, FINAL_AFTER
from hitab_ros.nodes.guard import Guard
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.presence import suspensions_noticed
from hitab_ros.timing import UPDATE_S


class FinalError(HitabError):
    """An error that a restart would not fix; the exit code is `DO_NOT_RESTART`."""


def make_node(name: str, **options: Any) -> GuardedNode:
    """Return a guarded node without unused standard topics and services."""
    return GuardedNode(name, **options)


class Spinner:
    """Spins an executor until `stop` is called or the process gets a signal to end.

    Attributes:
        stopped: whether the loop has to end.
        exit_code: exit code of the process, once stopped.
    """

    def __init__(self, executor: Executor) -> None:
        self.executor = executor
        self.exit_code = 0
        self.stopped = False
        self._guard = Guard(rclpy.logging.get_logger("executor").error)

    def stop(self, exit_code: int = 0) -> None:
        """End the loop after the current callback; safe in a signal handler."""
        self.stopped = True
        self.exit_code = self.exit_code or exit_code

    def stop_forgotten(self, seconds: float) -> None:
        """End with a restart by the supervisor, since others may have dropped this process."""
        print(
            f"error: this process was suspended for {seconds:.0f} s, so others may have forgotten "
            "it; it ends, and has to be started again, which a swarm's supervisor does",
            file=sys.stderr,
            flush=True,
        )
        self.stop(1)

    def spin_once(self, timeout_sec: float = UPDATE_S) -> None:
        """Handle pending events, or wait up to ``timeout_sec`` for one.

        Nodes guard their callbacks; a failure between the middleware and a callback, such as an
        unreadable message, is only logged.
        """
        self._guard.run("handling an event", self.executor.spin_once, timeout_sec)

    def spin(self) -> int:
        """Handle events until stopped; return the exit code."""
        while not self.stopped:
            self.spin_once()
        return self.exit_code

    def spin_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Handle events until a condition holds; return whether it did in time.

        The timeout is longer on a busy machine, see `BusyTimeout`.
        """
        patience = BusyTimeout(timeout_s)
        while not self.stopped:
            if condition():
                return True
            step = patience.step(UPDATE_S)
            if not step:
                return False
            self.spin_once(step)
        return condition()


@contextmanager
def spinner(arguments: Sequence[str] | None = None) -> Iterator[Spinner]:
    """Start ROS, yield a spinner for nodes, and shut everything down at the end.

    SIGINT and SIGTERM stop the spinning after the current callback, so that no write is cut off.
    """
    given = None if arguments is None else list(arguments)
    sockets = udp_sockets()
    rclpy.init(args=given, signal_handler_options=SignalHandlerOptions.NO)
    spinning = Spinner(EventsExecutor())
    rclpy.get_default_context().on_shutdown(spinning.stop)
    before = {}

    def on_signal(number: int, frame: FrameType | None) -> None:
        spinning.stop()

    for number in (signal.SIGINT, signal.SIGTERM):
        before[number] = signal.signal(number, on_signal)
    try:
        yield spinning
    finally:
        nodes = list(spinning.executor.get_nodes())
        for node in nodes:
            spinning.executor.remove_node(node)
            if isinstance(node, GuardedNode):
                node.leave()
        stop_receiving(udp_sockets() - sockets)
        for node in nodes:
            node.destroy_node()
        spinning.executor.shutdown()
        rclpy.try_shutdown()
        # Last: under `ros2 launch`, Ctrl-C arrives twice, from the terminal and the launcher.
        for number, handler in before.items():
            signal.signal(number, handler)


Loop = Callable[["Spinner"], int]


def run(start: Callable[[Spinner], Loop | None], arguments: Sequence[str] | None = None) -> int:
    """Run the main function of a node's process.

    Args:
        start: creates nodes and adds them to the spinner's executor. It may return a main loop
            that replaces the default one, which handles one event after the other.
        arguments: command line with ROS arguments; None for the process's own.

    Returns:
        The exit code: 1 after an error that a user can fix, which is printed in one line;
        `DO_NOT_RESTART` if a restart would not help.
    """
    began = time.monotonic()
    try:
        with spinner(arguments) as spinning, suspensions_noticed(spinning.stop_forgotten):
            loop = start(spinning)
            return spinning.spin() if loop is None else loop(spinning)
    except FinalError as error:
        print(f"error: {error}", file=sys.stderr, flush=True)
        _stay_until(began + float(os.environ.get(FINAL_AFTER, "0")))
        return DO_NOT_RESTART
    except HitabError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except (NameValidationException, ParameterException) as error:
        why = " ".join(str(error).split())
        print(f"error: {why}; check the names and parameters given to the node", file=sys.stderr)
        return 1
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0


def _stay_until(moment: float) -> None:
    with contextlib.suppress(KeyboardInterrupt):
        while (left := moment - time.monotonic()) > 0:
            time.sleep(left)
