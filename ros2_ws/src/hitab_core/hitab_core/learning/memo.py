"""A cache of learned functions, so that the same examples are learned from only once.

Saving a behavior learns from the same examples repeatedly: to show it, trim it, read its file back
and perform it. A learned function depends only on its examples and never changes.
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
"""How many functions are kept after their last user is gone."""


class LearningMemo:
    """Transition functions by what they were learned from, as long as they are in use.

    The most recent ones are kept a little longer, since they are often learned again soon.
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
        """Return what ``learn`` learns from these examples; call it only if that is not cached.

        Args:
            classifier: its name and parameters.
            scales: how the values of each of the m features compare.
            X: shape (n, m), feature values.
            y: labels of the next states, n of them.
            default: whether each example is a default one.
            learn: learns from them; its exceptions propagate.
        """
        text = repr((classifier, tuple(scales), X.shape, tuple(y), tuple(default)))
        values = np.ascontiguousarray(X, np.float64).tobytes()
        key = hashlib.sha256(text.encode() + b"\0" + values).digest()
        function = self._known.get(key)
        if function is None:
            function = self._known[key] = learn()
            self._last.append(function)
        return function
