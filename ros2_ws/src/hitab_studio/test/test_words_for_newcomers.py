"""What the page says explains itself: numbers, counts, who decides, and what was taken out."""

import asyncio
from types import MappingProxyType
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from hitab_msgs.msg import AgentStatus, EmergencyStop

from hitab_core import Example
from hitab_core.example import ExampleKind
from hitab_studio.known import Known
from hitab_studio.session import Session
from hitab_studio.studio import Studio
from hitab_studio.swarm_finder import Target
from hitab_studio.views import render

ONE = "keeper_1"


def example(number: int, kind: str) -> Example:
    return Example("Start", (), "Stop", ExampleKind(kind), number, number)


@pytest.fixture
def page() -> Any:
    """Return a function that renders a panel for what a keeper performs."""

    async def made(panel: str, **known: Any) -> str:
        studio = Studio(lambda: Target(0))
        session: Session = studio.open()
        session.shared.store.known = Known(Target(0, "keepers", (ONE,)), **known)
        session.agent, session.tab = ONE, "learned"
        return render(panel, session)

    return lambda panel, **known: asyncio.run(made(panel, **known))


# -- the emergency stop -----------------------------------------------------------------------


def test_the_emergency_stop_is_large_where_robots_may_do_harm_and_when_it_is_engaged(page):
    status = {"statuses": MappingProxyType({ONE: AgentStatus(agent=ONE, mode="idle")})}
    assert "large" in page("emergency", **status)
    assert "large" not in page("emergency", world=object(), **status)
    assert "large" not in page("emergency")
    stop = EmergencyStop(stamp=Time(sec=5), engaged=True, by="Anna", reason="a dog")
    assert "large" in page("emergency", world=object(), emergency=stop)
    assert 'data-test="release"' in page("emergency", emergency=stop)
    assert "Anna has stopped them (a dog)" in page("top", emergency=stop)
    released = EmergencyStop(stamp=Time(sec=6), engaged=False, by="Ben")
    assert 'data-test="stop-robots"' in page("emergency", emergency=released)
