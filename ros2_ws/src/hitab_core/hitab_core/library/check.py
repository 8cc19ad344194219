"""Checks that behavior files fit together: used behaviors exist, and none is recursive."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping

from hitab_core.automaton import FLAGS
from hitab_core.domain import Domain
from hitab_core.hierarchy import circle_among, in_order
from hitab_core.library.behavior_file import BehaviorFile, file_name
from hitab_core.texts.vocabulary import has
from hitab_core.texts.wording import quantity


def misfits(
    files: Mapping[str, BehaviorFile],
    domain: Domain,
    unreadable: Iterable[str] = (),
    deleted: Callable[[str], int | None] = lambda name: None,
) -> tuple[dict[str, str], dict[str, list[str]]]:
    """Return the reasons why behaviors cannot be used, and their lost parts.

    Args:
        files: the behaviors that could be read, by name.
        domain: domain with the basic behaviors and the hand-written automata.
        unreadable: names of the others; behaviors that use them cannot be used either.
        deleted: returns the newest version of a behavior without a file, or None.

    Returns:
        The faults of files, by name, each a text with one line per complaint; and all lost
        behaviors, unreadable files and hand-written automata included, each with the lost
        parts. A cause has none.
    """
    lost: dict[str, list[str]] = {name: [] for name in unreadable}
    circles: dict[str, list[str]] = {}

    def used(name: str) -> Collection[str]:
        automaton = files[name].automaton if name in files else domain.automata.get(name)
        return () if automaton is None or name in lost else automaton.behaviors_used

    def uses(name: str) -> Collection[str]:
        return () if name in circles else used(name)

    while way := circle_among(files, uses):
        for i, name in enumerate(way[:-1]):
            circles[name] = [*way[i:-1], *way[: i + 1]]
    found: dict[str, str] = {}
    for name in in_order([*files, *domain.automata], uses):
        parts = sorted(lost.keys() & used(name))
        if name in files:
            complaints = _complaints(
                files[name], files, domain, lost, circles.get(name, []), deleted
            )
            if complaints:
                found[name] = "\n".join(complaints)
                lost[name] = [] if name in circles else parts
        elif parts:
            lost[name] = parts
    return found, lost


def _complaints(
    file: BehaviorFile,
    files: Mapping[str, BehaviorFile],
    domain: Domain,
    lost: Collection[str],
    circle: list[str],
    deleted: Callable[[str], int | None],
) -> list[str]:
    complaints = []
    for state, line in zip(file.automaton.states, file.state_lines, strict=True):
        if state.name in FLAGS:
            continue
        place = f'{file_name(file.name)}:{line}: state "{state}" uses behavior "{state.name}"'
        parameters = _parameters(state.name, files, domain)
        if circle and state.name == circle[1]:
            complaints.append(
                f"{place}, which makes it recursive ({' -> '.join(circle)}); "
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
