"""Results that are kept while nothing has changed."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def while_same(function: Callable[P, T]) -> Callable[P, T]:
    """Keep a function's last result for as long as its arguments are the same objects.

    For functions of the known state, whose parts are replaced as a whole when they change.
    """
    last: list[Any] = [None, None]

    @functools.wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> T:
        now = (*args, *kwargs.values())
        before = last[0]
        if before is None or len(before) != len(now) or any(map(_differ, before, now)):
            last[:] = [now, function(*args, **kwargs)]
        result: T = last[1]
        return result

    return called


def _differ(one: object, other: object) -> bool:
    return one is not other
