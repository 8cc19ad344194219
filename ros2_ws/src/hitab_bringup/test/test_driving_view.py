"""The screen of `hitab drive`."""

from types import SimpleNamespace

import pytest
from hitab_msgs.msg import AgentStatus

from hitab_bringup.driving_view import lines


def header(training: str = "", **status: object) -> str:
    words = SimpleNamespace(training=training, keys=())
    demonstrator = SimpleNamespace(
        status=AgentStatus(**status),
        agent="ann",
        words=words,
        switch=SimpleNamespace(state=None),
        steering=SimpleNamespace(velocity=(0.0, 0.0, 0.0)),
        failed=False,
        said="",
        asked=None,
    )
    return next(iter(lines(demonstrator, {}, help_wanted=False))).plain


@pytest.mark.parametrize(
    ("status", "shown"),
    [
        ({"mode": "idle"}, "ann  idle"),
        ({"mode": "performing", "active_path": ["Go", "Turn"]}, "ann  performing: Go > Turn"),
        (
            {"mode": "training", "behavior": "GoTo", "active_path": ["Start"]},
            'ann  training "GoTo": 0 examples (0 default); performs nothing yet',
        ),
        (
            {"mode": "idle", "examples": 4, "training": "GoTo"},
            'ann  idle; the training of "GoTo" (4 examples) is kept: t continues it',
        ),
    ],
)
def test_the_first_line_says_what_the_agent_does_and_what_is_kept(status, shown):
    assert header(**status) == shown
