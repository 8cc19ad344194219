"""Checks that behavior files fit together: what they use exists, and none is recursive."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping

from hitab_core.automaton import FLAGS
from hitab_core.domain import Domain
from hitab_core.hierarchy import Uses, circular
from hitab_core.library.behavior_file import BehaviorFile, file_name
from hitab_core.vocabulary import has
from hitab_core.wording import quantity


def misfits(
    files: Mapping[str, BehaviorFile],
    domain: Domain,
    unreadable: Collection[str] = (),
    deleted: Callable[[str], int | None] = lambda name: None,
) -> dict[str, str]:
    """Return why behaviors cannot be used, by name, each a text with one line per complaint.

    Args:
        files: the behaviors that could be read, by name.
        domain: gives the basic behaviors and the hand-written automata.
        unreadable: names of the others; behaviors that use them cannot be used either.
        deleted: returns the newest version of a behavior that has no file; None: there is none.
    """
    lost = {*unreadable}
    lost |= hand_written_users(domain, files, lost)
    users: dict[str, list[str]] = {}
    for name, file in files.items():
        for used in file.automaton.behaviors_used:
            users.setdefault(used, []).append(name)

    def uses(name: str) -> Iterable[str]:
        automaton = files[name].automaton if name in files else domain.automata.get(name)
        return () if automaton is None else automaton.behaviors_used

    circles = circular(files, uses)
    found: dict[str, str] = {}
    asked: Iterable[str] = files
    while asked:
        more = {
            name: "\n".join(complaints)
            for name in asked
            if (
                complaints := _complaints(files[name], files, domain, lost, circles, uses, deleted)
            )
        }
        found |= more
        lost |= more.keys()
        hand_written = hand_written_users(domain, files, lost)
        lost |= hand_written
        # Only the users of these can become unusable.
        asked = {
            user: None
            for name in (*more, *hand_written)
            for user in users.get(name, ())
            if user not in found
        }
    return found


def hand_written_users(domain: Domain, files: Collection[str], lost: Collection[str]) -> set[str]:
    """Return the domain's automata that are made of something lost, unless a file replaces them.

    Args:
        domain: gives the hand-written automata.
        files: names of the trained behaviors.
        lost: names of the behaviors that cannot be used.
    """
    found: set[str] = set()
    more = bool(lost)
    while more:
        made = {
            name
            for name, automaton in domain.automata.items()
            if name not in files
            and name not in lost
            and not automaton.behaviors_used.isdisjoint({*lost, *found})
        }
        more = made > found
        found |= made
    return found


def _complaints(
    file: BehaviorFile,
    files: Mapping[str, BehaviorFile],
    domain: Domain,
    lost: set[str],
    circles: Mapping[str, int],
    uses: Uses,
    deleted: Callable[[str], int | None],
) -> list[str]:
    complaints = []
    for state, line in zip(file.automaton.states, file.state_lines, strict=True):
        if state.name in FLAGS:
            continue
        place = f'{file_name(file.name)}:{line}: state "{state}" uses behavior "{state.name}"'
        parameters = _parameters(state.name, files, domain)
        if file.name in circles and circles[file.name] == circles.get(state.name):
            way = " -> ".join(_circle(file.name, state.name, uses))
            complaints.append(
                f"{place}, which makes it recursive ({way}); "
                "a behavior cannot use itself: remove the state from one of these"
            )
        elif state.name in lost:
            complaints.append(f"{place}, which cannot be used; bring that back first")
        elif parameters is None and (version := deleted(state.name)):
            complaints.append(f"{place}, which was deleted; bring its version {version} back")
        elif parameters is None:
            complaints.append(
                f"{place}, which is neither in the library {has(files, state.name)} nor a "
                f'behavior of domain "{domain.name}" '
                f"{has([*domain.behaviors, *domain.automata], state.name)}; "
                f"put {file_name(state.name)} into the folder, or take the state out"
            )
        elif len(parameters) != len(state.arguments):
            complaints.append(
                f"{place}, which takes {quantity(len(parameters), 'target')}, "
                f"not {len(state.arguments)}; "
                "train one of the two again"
            )
    return complaints


def _parameters(
    name: str, files: Mapping[str, BehaviorFile], domain: Domain
) -> tuple[str, ...] | None:
    if name in files:
        return files[name].automaton.parameters
    known = domain.behaviors.get(name) or domain.automata.get(name)
    return known.parameters if known is not None else None


def _circle(name: str, used: str, uses: Uses) -> list[str]:
    """Return the shortest path from ``name`` via ``used`` back to ``name``; it must exist."""
    came_from = {used: name}
    waiting = deque([used])
    while name not in came_from:
        last = waiting.popleft()
        for below in sorted(uses(last)):
            if below not in came_from:
                came_from[below] = last
                waiting.append(below)
    way = [name]
    while len(way) == 1 or way[-1] != name:
        way.append(came_from[way[-1]])
    return way[::-1]
