"""The agent's percept, with the last values of features."""

from __future__ import annotations

from collections.abc import Mapping

from hitab_core import OWN_NAMES, Term
from hitab_studio.pages.looking_back import readings_of
from hitab_studio.pages.page import Page

Readings = Mapping[tuple[str, str], tuple[float, ...]]


def perceived(page: Page) -> Readings:
    """Return the features of the active automata; all features of the agent if none is active.

    As in `hitab perceive`, features with the same target twice, and features of the automaton
    itself, are left out.
    """
    readings = {key: history for key, history in readings_of(page).items() if history}
    of_automata = {key: history for key, history in readings.items() if key[0]}
    if of_automata:
        return of_automata
    return {key: history for key, history in readings.items() if _is_of_the_body(key[1])}


def _is_of_the_body(feature: str) -> bool:
    term = Term.parse(feature)
    return term.name not in OWN_NAMES and len(set(term.arguments)) == len(term.arguments)


def plotted(page: Page) -> Readings:
    """Return the features plotted in place of an empty field; {} if the field is not empty."""
    scene = page.moment.shown
    return {} if scene is not None and scene.names else perceived(page)
