"""What all benchmarks share: how they repeat, print and write their figures."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median
from typing import Any


def seconds_of(work: Callable[[], object], repeats: int) -> float:
    """Return the median time of some work, s."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return median(times)


def tell(title: str, figures: Mapping[str, Any], path: str = "") -> None:
    """Print figures and, if a path is given, write them as JSON."""
    print(title)
    width = max(len(name) for name in figures)
    for name, value in figures.items():
        shown = f"{value:,.3g}" if isinstance(value, float) and value < 1000 else f"{value:,}"
        print(f"  {name.replace('_', ' '):{width}}  {shown}")
    if path:
        Path(path).write_text(json.dumps(dict(figures), indent=2) + "\n", encoding="utf-8")


def progress(text: str) -> None:
    """Show what is going on, in a terminal; empty: nothing."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def prefixed(say: Callable[[str], None], prefix: str) -> Callable[[str], None]:
    """Return what says a text after a prefix."""
    return lambda text: say(prefix + text)
