"""The open dialog of a page."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from hitab_core import FLAGS, FeatureKind, Term, shown_unit
from hitab_studio.actions.library_actions import users_of
from hitab_studio.field.graph_layout import Graph, graph
from hitab_studio.pages.page import Page
from hitab_studio.pages.person_names import NAME_LENGTH_MAX
from hitab_studio.swarm.received_vocabulary import terms
from hitab_studio.views.label_strip import words
from hitab_studio.views.numbers import counted, measure
from hitab_studio.views.question_titles import TITLES, WHEN_UNSURE

FLAG_DESCRIPTION = "the behavior that runs inside has raised {}"

NAME_FORMAT = "A name is made of letters, digits and _, and begins with a letter, as ApproachBall."
"""Format of behavior and parameter names, as checked by input fields."""

Feature = tuple[str, str, str, str]
"""A feature with targets, its description, its kind and unit, and its present value."""


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the dialog's template."""
    dialog = page.dialog
    kind = dialog.get("kind", "")
    found: dict[str, Any] = {"kind": kind, "name_format": NAME_FORMAT}
    if kind == "new":
        vocabulary = page.watched.vocabulary
        parameter = dialog["parameter"]
        arguments = [*vocabulary.targets, *([parameter] if parameter else [])]
        status, world = page.status, page.studio.known.world
        found |= {
            "features": _features(page, arguments),
            "states": [
                (str(term), _described(vocabulary.behavior_descriptions, text, term))
                for text, term in terms(vocabulary.behaviors, arguments)
            ],
            "running": world is not None and world.mode != "paused",
            "others": sorted({p.name for p in page.studio.held.values() if not page.is_same(p)}),
            "targets": vocabulary.targets,
            "unsaved": status.training.examples if status is not None else 0,
            "saved": _saved(page),
        }
    if kind == "features":
        arguments = [*page.watched.vocabulary.targets, *dialog["parameters"]]
        found |= {
            # In the order in which they will be used: those in use come first.
            "features": sorted(
                _features(page, arguments),
                key=lambda found: [*dialog["used"], found[0]].index(found[0]),
            ),
            "same": dialog["chosen"] == dialog["used"],
            "graph": _graph(page),
        }
    if kind == "label":
        found |= words(dialog["domain"])
    if kind == "caution":
        found |= {
            "when_unsure": WHEN_UNSURE,
            "now_unsure": page.status.caution.when_unsure if page.status is not None else "",
        }
    if kind == "name":
        found |= {"demonstrator": page.demonstrator, "longest_name": NAME_LENGTH_MAX}
    if kind == "distribute":
        others = [agent for agent in page.agents if agent != dialog["agent"]]
        found["receivers"] = dialog.get("alike", others)
    if kind in ("rename-behavior", "delete-behavior"):
        found["users"] = users_of(page, dialog["name"])
    if kind == "save":
        training = dialog["training"]
        labels = (*training.feature_labels, *training.possible_states)
        used = {argument for label in labels for argument in Term.parse(label).arguments}
        found["bindable"] = sorted(used - set(training.parameters))
        # Those that the agent has found since it was opened, too.
        found |= {"asked": (page.training or training).questions, "question_titles": TITLES}
    return found


def _saved(page: Page) -> tuple[str, str]:
    """Return the typed name and its number of examples, if such a behavior is saved."""
    name = page.dialog.get("typed", "")
    if page.dialog["resume"] or name not in page.watched.vocabulary.trained:
        return ("", "")
    behavior = page.watched.behaviors.get(name)
    return (name, counted(behavior.examples) if behavior is not None else "")


def _features(page: Page, arguments: Sequence[str]) -> list[Feature]:
    """Return the features to choose from, with all choices of these arguments."""
    words = page.watched.vocabulary
    return [
        *(_feature(page, text, term) for text, term in terms(words.features, arguments)),
        *((flag, FLAG_DESCRIPTION.format(flag), "boolean", "") for flag in FLAGS),
    ]


def _graph(page: Page) -> Graph | None:
    """Return the drawing of the automaton learned from the chosen features; None if none."""
    preview = page.dialog["preview"]
    if preview is None or not preview.transitions:
        return None
    return graph(preview, [*page.watched.behaviors])


def _feature(page: Page, text: str, term: Term) -> Feature:
    """Return a feature of the vocabulary with targets, as offered by the dialog."""
    watched = page.watched
    vocabulary, name, label = watched.vocabulary, term.name, str(term)
    kind, unit = vocabulary.kinds.get(name, ""), vocabulary.units.get(name, "")
    now = ""
    if history := watched.readings.get(("", label)):
        now = measure(history[-1], kind, unit)
    about = _described(vocabulary.feature_descriptions, text, term)
    kind = "circular" if kind == FeatureKind.TOROIDAL else kind
    return label, about, f"{kind}, {shown_unit(unit)}" if unit else kind, now


def _described(descriptions: Mapping[str, str], text: str, term: Term) -> str:
    """Return a description with the term's targets in place of the parameters."""
    said = descriptions.get(term.name, "")
    for parameter, target in zip(Term.parse(text).arguments, term.arguments, strict=True):
        said = re.sub(rf"\b{re.escape(parameter)}\b", target, said)
    return said
