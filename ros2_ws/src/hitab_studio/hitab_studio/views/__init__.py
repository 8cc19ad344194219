"""Views of the page: a function and a template for each panel."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from jinja2.utils import markupsafe

from hitab_client.terminal.cli_remedies import called
from hitab_core import quantity, unbroken
from hitab_studio.pages import unavailable
from hitab_studio.pages.page import Page
from hitab_studio.tutorial import progress
from hitab_studio.views import agents, dialog, overlay, side, top
from hitab_studio.views.numbers import counted, duration, measure, measured
from hitab_studio.views.tab_swarm import since

Context = dict[str, Any]
PANELS: dict[str, Callable[[Page], Context]] = {
    "top": top.context,
    "emergency": top.emergency,
    "agents": agents.context,
    "overlay": overlay.context,
    "side": side.context,
    "dialog": dialog.context,
    "messages": lambda page: {"messages": page.messages.shown},
    "tutorial": progress.context,
}


def curve(values: Sequence[float], width: float = 88.0, height: float = 20.0) -> str:
    """Return the points of an SVG polyline through the known values."""
    known = [v for v in values if not math.isnan(v)]
    if len(known) < 2:
        return ""
    low, high = min(known), max(known)
    span = (high - low) or 1.0
    step = width / max(len(values) - 1, 1)
    return " ".join(
        f"{i * step:.1f},{height - 2 - (v - low) / span * (height - 4):.1f}"
        for i, v in enumerate(values)
        if not math.isnan(v)
    )


def clock(seconds: float) -> str:
    """Return a time as minutes and seconds, such as ``3:20``."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


def breaks(name: str) -> markupsafe.Markup:
    """Return the name of a feature with line breaks allowed between the words."""
    parts = re.split(r"(?<=[a-z])(?=[A-Z(])", name)
    return markupsafe.Markup("<wbr>").join(parts)


_environment = Environment(
    loader=PackageLoader("hitab_studio"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
_environment.filters |= {
    "measure": measure,
    "duration": duration,
    "counted": counted,
    "curve": curve,
    "clock": clock,
    "quantity": quantity,
    "breaks": breaks,
    "since": since,
    "unbroken": unbroken,
}
_environment.globals |= {"off": unavailable.off, "unavailable": unavailable, "called": called}


def render(panel: str, page: Page) -> str:
    """Return the HTML of a panel."""
    common = {
        "page": page,
        "known": page.studio.known,
        "agent": page.agent,
        "status": page.status,
        "training": page.training,
        "player": page.player,
        "dialog": page.dialog,
        "agent_off": page.agent_off,
        "measured": partial(measured, page),
    }
    return _environment.get_template(f"{panel}.html").render(common, **PANELS[panel](page))
