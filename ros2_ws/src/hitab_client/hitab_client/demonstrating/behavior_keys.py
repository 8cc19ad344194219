"""Which key commands which behavior: a key stays with its behavior, whatever else appears.

The keys are kept on this machine, so that `hitab drive`, `hitab joystick` and the studio agree on
them, today and tomorrow.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from hitab_client.run_folder import state_home
from hitab_core import FLAGS, HitabError, Use
from hitab_core.library.durable_files import file_errors, locked, make_folder, write_durably

KEYS = "1234567890qweiopsghjkcvm"
"""Keys of behaviors, in the order in which they are given; other keys have other meanings."""

FLAG_KEYS = dict(zip(FLAGS, "dx", strict=True))
"""Keys of the flags, which every training has."""

LOCK_S = 1.0
"""How long to wait for another process that gives keys, s."""

DOMAINS_MAX = 100
"""Maximum number of domains whose keys are kept."""


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
        use = Use.parse(behavior)
        return use.name in trained, bool(use.arguments), behavior

    return sorted(behaviors, key=place)


class Keys:
    """The keys of the behaviors of each domain.

    Args:
        path: of the file that keeps them for all processes; None: they are this process's own. If
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
        try:
            with file_errors(self._path, "write"):
                make_folder(self._path.parent, sync=False)
                with locked(self._path.parent, alone=True, patience=LOCK_S):
                    kept = _read(self._path)
                    left = _give(given, new, kept.pop(domain, {}))
                    _write(self._path, kept | {domain: left})
        except HitabError:
            _give(given, new, {})

    def of(self, domain: str, behavior: str) -> str:
        """Return the key of a behavior; "" if it has none."""
        return FLAG_KEYS.get(behavior) or self._given.get(domain, {}).get(behavior, "")

    def commandable(
        self,
        domain: str,
        behaviors: Sequence[str],
        trained: Container[str],
        *,
        training: str = "",
        chosen: Collection[str] = (),
        states: Collection[str] = (),
    ) -> list[str]:
        """Return what an agent can be commanded, in the order of the keys, which it gives.

        Args:
            domain: of the agent.
            behaviors: of the agent, with parameters.
            trained: names of those that were trained.
            training: name of the automaton that is being trained; "": none.
            chosen: the behaviors chosen for it; empty: all.
            states: its behaviors until now, such as ``GoTo(goal)``.
        """
        there = in_order(behaviors, trained)
        self.give(domain, there)
        if training:
            bound = [state for state in states if state not in there]
            there = [b for b in [*there, *bound] if Use.parse(b).name != training]
            there = [b for b in chosen or there if b not in FLAGS]
            self.give(domain, there)
        there.sort(key=lambda b: KEYS.index(key) if (key := self.of(domain, b)) else len(KEYS))
        return [*there, *FLAGS] if training else there


def _give(given: dict[str, str], new: Iterable[str], kept: dict[str, str]) -> dict[str, str]:
    """Give keys to new behaviors; return what is to be kept.

    If no key is left, that of a behavior is given which was kept and has not been met since.

    Args:
        given: the keys that this process shows; they do not change.
        new: behaviors without one.
        kept: by behavior.
    """
    taken = set(given.values())
    others = {b: k for b, k in kept.items() if b not in given and k not in taken}
    for behavior in new:
        if behavior in others:
            given[behavior] = others.pop(behavior)
    for behavior in new:
        taken = {*given.values(), *others.values()}
        free = next((key for key in KEYS if key not in taken), None)
        if behavior in given:
            continue
        if free is None and others:
            free = others.pop(next(iter(others)))
        if free is not None:
            given[behavior] = free
    return others | given


def _read(path: Path) -> dict[str, dict[str, str]]:
    """Return the keys by domain and behavior; what is no key is left out."""
    import yaml

    with suppress(OSError, ValueError, AttributeError, yaml.YAMLError):
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        found = {str(d): {str(b): str(k) for b, k in ks.items()} for d, ks in content.items()}
        return {d: _without_doubles(keys) for d, keys in found.items()}
    return {}


def _without_doubles(keys: dict[str, str]) -> dict[str, str]:
    first: dict[str, str] = {}
    for behavior, key in keys.items():
        if len(key) == 1 and key in KEYS:
            first.setdefault(key, behavior)
    return {behavior: key for key, behavior in first.items()}


def _write(path: Path, kept: dict[str, dict[str, str]]) -> None:
    import yaml

    kept = dict(list(kept.items())[-DOMAINS_MAX:])
    text = "# The key of each behavior in `hitab drive` and the studio, by domain.\n"
    text += yaml.safe_dump(kept, sort_keys=False)
    write_durably(path, text.encode(), sync=False)
