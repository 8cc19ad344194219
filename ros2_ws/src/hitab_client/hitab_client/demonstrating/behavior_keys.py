"""Keys of behaviors: a key stays with its behavior when others appear.

The keys are kept on this machine, so that `hitab drive`, `hitab joystick` and the studio agree on
them, today and tomorrow.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from hitab_client.run_folder import state_home
from hitab_core import FLAGS, Term
from hitab_core.library.durable_files import write_durably

if TYPE_CHECKING:
    from hitab_client.learned import Learned

KEYS = "1234567890qweiopsghjkcvm"
"""Keys of behaviors, in the order in which they are given; other keys have other meanings."""

FLAG_KEYS = dict(zip(FLAGS, "dx", strict=True))
"""Keys of the flags, which every training has."""


def file() -> Path:
    """Return the file that holds the keys."""
    return state_home() / "behavior_keys.yaml"


def in_order(behaviors: Iterable[str], trained: Container[str]) -> list[str]:
    """Return behaviors in the order in which they get keys: those of the domain first.

    Among these, those with parameters come last, since a gamepad's button cannot name a target.

    Args:
        behaviors: with parameters, such as ``GoTo(A)``.
        trained: names of those that were trained.
    """

    def place(behavior: str) -> tuple[bool, bool, str]:
        term = Term.parse(behavior)
        return term.name in trained, bool(term.arguments), behavior

    return sorted(behaviors, key=place)


class Keys:
    """The keys of the behaviors of each domain.

    Args:
        path: of the file that keeps them for all processes; None if they are this process's. If
            it cannot be read or written, the keys last as long as the process.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._given: dict[str, dict[str, str]] = {}
        self._path = path

    def give(self, domain: str, behaviors: Iterable[str]) -> None:
        """Give each behavior that has no key the next one, as long as there are any."""
        given = self._given.setdefault(domain, {})
        new = [b for b in dict.fromkeys(behaviors) if b not in given and b not in FLAG_KEYS]
        if not new or len(given) == len(KEYS):
            return
        if self._path is None:
            _give(given, new, {})
            return
        kept = _read(self._path)
        left = _give(given, new, kept.pop(domain, {}))
        text = "# The key of each behavior in `hitab drive` and the studio, by domain.\n"
        text += yaml.safe_dump(kept | {domain: left}, sort_keys=False)
        with suppress(OSError):
            write_durably(self._path, text.encode(), sync=False)

    def of(self, domain: str, behavior: str) -> str:
        """Return the key of a behavior; "" if it has none."""
        return FLAG_KEYS.get(behavior) or self._given.get(domain, {}).get(behavior, "")

    def commandable(
        self,
        domain: str,
        behaviors: Sequence[str],
        trained: Container[str],
        training: Learned | None = None,
    ) -> list[str]:
        """Return what an agent can be commanded, in the order of the keys, which it gives.

        Args:
            domain: of the agent.
            behaviors: of the agent, with parameters.
            trained: names of those that were trained.
            training: of the agent; None if it is not in training.
        """
        there = in_order(behaviors, trained)
        self.give(domain, there)
        if training is not None:
            bound = [state for state in training.states if state not in there]
            there = [b for b in [*there, *bound] if Term.parse(b).name != training.name]
            there = [b for b in training.chosen or there if b not in FLAGS]
            self.give(domain, there)
        there.sort(key=lambda b: KEYS.index(key) if (key := self.of(domain, b)) else len(KEYS))
        return there if training is None else [*there, *FLAGS]


def _give(given: dict[str, str], new: Iterable[str], kept: dict[str, str]) -> dict[str, str]:
    """Give keys to new behaviors; return what is to be kept.

    If no key is left, that of a behavior is given which was kept and has not been met since.

    Args:
        given: the keys that this process shows; they do not change.
        new: behaviors without one.
        kept: by behavior.
    """
    others = {b: k for b, k in kept.items() if b not in given and k not in given.values()}
    given |= {behavior: others.pop(behavior) for behavior in new if behavior in others}
    taken = {*given.values(), *others.values()}
    free = [*(key for key in KEYS if key not in taken), *others.values()]
    given |= dict(zip((b for b in new if b not in given), free, strict=False))
    return {b: k for b, k in others.items() if k not in given.values()} | given


def _read(path: Path) -> dict[str, dict[str, str]]:
    """Return the keys by domain and behavior; what is no key is left out."""
    with suppress(OSError, ValueError, AttributeError, yaml.YAMLError):
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        of_keys = {str(d): {str(k): str(b) for b, k in ks.items()} for d, ks in content.items()}
        return {d: {b: k for k, b in ks.items() if k in {*KEYS}} for d, ks in of_keys.items()}
    return {}
