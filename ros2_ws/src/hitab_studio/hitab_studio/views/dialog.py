"""The dialog in front of everything else."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hitab_core import FLAGS, FeatureKind, Use
from hitab_studio import reasons
from hitab_studio.learned import uses
from hitab_studio.session import Session

FLAG_DESCRIPTION = "the behavior that runs inside has raised {}"

NAME_FORMAT = "A name is made of letters, digits and _, and begins with a letter, as ApproachBall."
"""Of behaviors and parameters, as their fields in the dialogs check it."""

TITLES = {
    "help": "Keys",
    "new": "Train a behavior",
    "discard": "Give up a training",
    "save": "Save a behavior",
    "distribute": "Distribute a behavior",
    "round": "Next round",
    "snapshots": "Snapshots",
    "rename-recording": "Rename a recording",
    "delete-recording": "Delete a recording",
    "stop": "Stop the swarm",
}


@dataclass(frozen=True)
class Choice:
    """A feature or behavior to choose.

    Attributes:
        label: with its targets.
        kind: of a feature, with its unit.
        now: its present value, for people.
    """

    label: str
    description: str
    kind: str = ""
    now: str = ""


def context(session: Session) -> dict[str, Any]:
    """Return what the dialog shows."""
    dialog = session.dialog
    kind = dialog.get("kind", "")
    found: dict[str, Any] = {
        "dialog": dialog,
        "kind": kind,
        "title": TITLES.get(kind, ""),
        "name_format": NAME_FORMAT,
    }
    if kind == "new":
        vocabulary = session.watched.vocabulary
        parameter = dialog["parameter"]
        arguments = [*vocabulary.targets, *([parameter] if parameter else [])]
        status, world = session.status, session.shared.store.known.world
        found |= {
            "features": [
                *(
                    _feature(session, text, use)
                    for text, use in uses(vocabulary.features, arguments)
                ),
                *(Choice(flag, FLAG_DESCRIPTION.format(flag), "boolean") for flag in FLAGS),
            ],
            "states": [
                Choice(str(use), _described(vocabulary.behavior_descriptions, text, use))
                for text, use in uses(vocabulary.behaviors, arguments)
            ],
            "running": world is not None and world.mode != "paused",
            "agent_off": reasons.agent(session),
            "targets": vocabulary.targets,
            "unsaved": status.examples if status is not None else 0,
            "training": session.watched.training,
        }
    if kind == "save":
        training = dialog["training"]
        used = {a for f in (*training.features, *training.states) for a in Use.parse(f).arguments}
        found["bindable"] = sorted(used)
    return found


def _feature(session: Session, text: str, use: Use) -> Choice:
    """Return a feature of the vocabulary with targets, as the dialog offers it."""
    watched = session.watched
    vocabulary, name, label = watched.vocabulary, use.name, str(use)
    kind, unit = vocabulary.kinds.get(name, ""), vocabulary.units.get(name, "")
    now = ""
    if (value := watched.probed.get(label)) is not None:
        if math.isnan(value):
            now = "no value"
        elif kind == FeatureKind.BOOLEAN:
            now = "yes" if value else "no"
        else:
            now = f"{value:.3g} {unit}".strip()
    about = _described(vocabulary.feature_descriptions, text, use)
    return Choice(label, about, f"{kind}, {unit}" if unit else kind, now)


def _described(descriptions: Mapping[str, str], text: str, use: Use) -> str:
    """Return a description, with the targets of a use in place of the parameters."""
    said = descriptions.get(use.name, "")
    for parameter, target in zip(Use.parse(text).arguments, use.arguments, strict=True):
        said = re.sub(rf"\b{re.escape(parameter)}\b", target, said)
    return said
