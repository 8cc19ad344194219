"""Whether behavior files fit together: what they use exists, and none uses itself."""

from __future__ import annotations

from collections.abc import Mapping

from hitab_core.automaton import FLAGS
from hitab_core.behavior_file import BehaviorFile, file_name
from hitab_core.domain import Domain
from hitab_core.errors import has


def misfits(
    files: Mapping[str, BehaviorFile], domain: Domain, unreadable: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return what keeps behaviors from being used, by name, each a text with a line per complaint.

    Args:
        files: the behaviors that could be read, by name.
        domain: gives the basic behaviors and the hand-written automata.
        unreadable: names of those that could not; what uses them cannot be used either.
    """
    lost = set(unreadable or ())
    found: dict[str, str] = {}
    while True:
        fine = {name: file for name, file in files.items() if name not in found}
        more = {
            name: "\n".join(complaints)
            for name, file in fine.items()
            if (complaints := _complaints(file, files, domain, lost))
        }
        if not more:
            return found
        found |= more
        lost |= set(more)


def _complaints(
    file: BehaviorFile, files: Mapping[str, BehaviorFile], domain: Domain, lost: set[str]
) -> list[str]:
    complaints = []
    for state, line in zip(file.automaton.states, file.state_lines, strict=True):
        if state.name in FLAGS:
            continue
        place = f'{file_name(file.name)}:{line}: state "{state}" uses behavior "{state.name}"'
        circle = _circle(file.name, state.name, files, domain)
        parameters = _parameters(state.name, files, domain)
        if circle:
            complaints.append(
                f"{place}, which makes it recursive ({' -> '.join(circle)}); "
                "a behavior cannot use itself: remove the state from one of these"
            )
        elif state.name in lost:
            complaints.append(f"{place}, which is not right either; mend that first")
        elif parameters is None:
            complaints.append(
                f"{place} which is not in the library {has(files)} nor a behavior of domain "
                f'"{domain.name}" {has([*domain.behaviors, *domain.automata])}; '
                f"put {file_name(state.name)} into the folder, or take the state out"
            )
        elif len(parameters) != len(state.arguments):
            complaints.append(
                f"{place}, which takes {len(parameters)} target(s) "
                f"({', '.join(parameters) or 'none'}), not {len(state.arguments)}; "
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


def _circle(name: str, used: str, files: Mapping[str, BehaviorFile], domain: Domain) -> list[str]:
    """Return the way from ``name`` over ``used`` back to ``name``, if there is one."""
    ways = [[name, used]]
    seen: set[str] = set()
    while ways:
        way = ways.pop()
        last = way[-1]
        if last == name:
            return way
        if last in seen:
            continue
        seen.add(last)
        automaton = files[last].automaton if last in files else domain.automata.get(last)
        if automaton is not None:
            ways.extend([*way, next_] for next_ in sorted(automaton.behaviors_used))
    return []
