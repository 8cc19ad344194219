"""Remembering what was learned, so that the same examples are learned from once.

To save a behavior is to learn from the same examples again and again: to show it, to trim it, to
read its file back, to perform it. What is learned depends on nothing but what it is learned from,
and is not changed afterwards.
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable, Sequence
from weakref import WeakValueDictionary

import numpy as np

from hitab_core.arrays import Floats
from hitab_core.domain import Scale
from hitab_core.transition_function import LearnedTransition

KEPT = 64
"""How many functions are remembered although nobody has them any more."""


class LearningMemo:
    """Transition functions by what they were learned from, as long as somebody has them.

    The last ones are kept a little longer, since one who has learned may learn again soon.
    """

    def __init__(self, kept: int = KEPT) -> None:
        self._known: WeakValueDictionary[bytes, LearnedTransition] = WeakValueDictionary()
        self._last: deque[LearnedTransition] = deque(maxlen=kept)

    def learned(
        self,
        classifier: str,
        scales: Sequence[Scale],
        X: Floats,
        y: Sequence[str],
        default: Sequence[bool],
        learn: Callable[[], LearnedTransition],
    ) -> LearnedTransition:
        """Return what ``learn`` would learn from these examples; call it if that is not known.

        Args:
            classifier: which, with its parameters.
            scales: for each of the m features how its values compare.
            X: shape (n, m), feature values.
            y: labels of the next states, n of them.
            default: whether each example is a default one.
            learn: learns from them; what it raises is raised.
        """
        text = repr((classifier, tuple(scales), X.shape, tuple(y), tuple(default)))
        values = np.ascontiguousarray(X, np.float64).tobytes()
        key = hashlib.sha256(text.encode() + b"\0" + values).digest()
        function = self._known.get(key)
        if function is None:
            function = self._known[key] = learn()
            self._last.append(function)
        return function
