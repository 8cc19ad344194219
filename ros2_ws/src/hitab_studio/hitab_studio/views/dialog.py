"""The dialog in front of everything else."""

from __future__ import annotations

from typing import Any

from hitab_core import FLAGS, Use
from hitab_studio.session import Session

NAME_FORMAT = "A name is made of letters, digits and _, and begins with a letter, as ApproachBall."
"""Of behaviors and parameters, as their fields in the dialogs check it."""

TITLES = {
    "help": "Keys",
    "new": "Train a behavior",
    "save": "Save a behavior",
    "distribute": "Distribute a behavior",
    "round": "Next round",
    "snapshots": "Snapshots",
}


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
        status = session.status
        found |= {
            "features": [*_uses(vocabulary.features, arguments), *FLAGS],
            "states": _uses(vocabulary.behaviors, arguments),
            "targets": vocabulary.targets,
            "unsaved": status.examples if status is not None else 0,
            "training": session.watched.training,
        }
    if kind == "save":
        training = dialog["training"]
        used = {a for f in (*training.features, *training.states) for a in Use.parse(f).arguments}
        found["bindable"] = sorted(used)
    return found


def _uses(names: tuple[str, ...], arguments: list[str]) -> list[str]:
    """Return behaviors or features with each choice of targets."""
    found = []
    for text in names:
        use = Use.parse(text)
        choices: list[tuple[str, ...]] = [()]
        for _ in use.arguments:
            choices = [(*c, a) for c in choices for a in arguments]
        found += [str(Use(use.name, choice)) for choice in choices]
    return found
