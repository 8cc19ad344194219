"""Keys of behaviors: a key stays with its behavior when others appear.

The keys are stored on this machine, so that `hitab drive`, `hitab joystick` and the studio always
agree on them.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from hitab_client.runs.run_folder import state_home
from hitab_core import FLAGS, Term
from hitab_core.library.durable_files import write_durably

if TYPE_CHECKING:
    from hitab_client.learned import Learned

KEYS = "1234567890qweiopsghjkcvm"
"""Keys of behaviors, in the order in which they are assigned; other keys have other meanings."""

FLAG_KEYS = dict(zip(FLAGS, "dx", strict=True))
"""Keys of the flags, which every training has."""


def file() -> Path:
    """Return the file that holds the keys."""
    return state_home() / "behavior_keys.yaml"


def in_order(behaviors: Iterable[str], trained: Container[str]) -> list[str]:
    """Return behaviors in the order in which they get keys: behaviors of the domain first.

    Behaviors of the domain with parameters come after those without, since a gamepad's button
    cannot name a target.

    Args:
        behaviors: behaviors with parameters, such as ``GoTo(A)``.
        trained: names of the trained behaviors.
    """

    def place(behavior: str) -> tuple[bool, bool, str]:
        term = Term.parse(behavior)
        return term.name in trained, bool(term.arguments), behavior

    return sorted(behaviors, key=place)


class Keys:
    """The keys of the behaviors of each domain.

    Args:
        path: file that keeps the keys for all processes; None for keys of this process alone.
            If the file cannot be read or written, the keys last as long as the process.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._given: dict[str, dict[str, str]] = {}
        self._path = path

    def give(self, domain: str, behaviors: Iterable[str]) -> None:
        """Assign the next free key to each behavior without one, as long as keys are left."""
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
        """Return the key of a behavior; empty if it has none."""
        return FLAG_KEYS.get(behavior) or self._given.get(domain, {}).get(behavior, "")

    def commandable(
        self,
        domain: str,
        behaviors: Sequence[str],
        trained: Container[str],
        training: Learned | None = None,
    ) -> list[str]:
        """Return the behaviors that can be commanded, by key; assign missing keys.

        Args:
            domain: name of the agent's domain.
            behaviors: the agent's behaviors, with parameters.
            trained: names of the trained behaviors.
            training: the agent's training; None if it is not in training.
        """
        found = in_order(behaviors, trained)
        self.give(domain, found)
        if training is not None:
            bound = [state for state in training.possible_states if state not in found]
            found = [b for b in [*found, *bound] if Term.parse(b).name != training.name]
            found = [b for b in training.chosen_states or found if b not in FLAGS]
            self.give(domain, found)
        found.sort(key=lambda b: KEYS.index(key) if (key := self.of(domain, b)) else len(KEYS))
        return found if training is None else [*found, *FLAGS]


def _give(given: dict[str, str], new: Iterable[str], kept: dict[str, str]) -> dict[str, str]:
    """Assign keys to new behaviors; return the keys to store.

    If no key is left, the key of a stored behavior that this process has not seen is reused.

    Args:
        given: keys that this process shows, by behavior; they do not change.
        new: behaviors without a key.
        kept: stored keys, by behavior.
    """
    others = {b: k for b, k in kept.items() if b not in given and k not in given.values()}
    given |= {behavior: others.pop(behavior) for behavior in new if behavior in others}
    taken = {*given.values(), *others.values()}
    free = [*(key for key in KEYS if key not in taken), *others.values()]
    given |= dict(zip((b for b in new if b not in given), free, strict=False))
    return {b: k for b, k in others.items() if k not in given.values()} | given


def _read(path: Path) -> dict[str, dict[str, str]]:
    """Return the keys by domain and behavior; invalid entries are left out."""
    with suppress(OSError, ValueError, AttributeError, yaml.YAMLError):
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        of_keys = {str(d): {str(k): str(b) for b, k in ks.items()} for d, ks in content.items()}
        return {d: {b: k for k, b in ks.items() if k in {*KEYS}} for d, ks in of_keys.items()}
    return {}
