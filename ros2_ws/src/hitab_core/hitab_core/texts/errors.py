"""Errors a user can cause and fix: each names the thing, the place and the way out."""

from __future__ import annotations

from hitab_core.texts.remedies import Remedy


class HitabError(Exception):
    """Base of all errors that a user, not a programmer, has to fix.

    Args:
        what: the fault, in one clause.
        remedies: possible remedies, as data; ``str`` words them plainly.
        where: place of the fault, or its agent, such as ``Chase.hfa.yaml:14`` or ``keeper_1``.

    Attributes:
        what: the fault.
        remedies: possible remedies.
        where: place of the fault, or its agent; may be empty.
    """

    def __init__(self, what: str = "", *remedies: Remedy, where: str = "") -> None:
        super().__init__(what, *remedies)
        self.what = what
        self.remedies = remedies
        self.where = where

    @property
    def problem(self) -> str:
        """Place and description of the fault, without the ways out."""
        return f"{self.where}: {self.what}" if self.where else self.what

    def __str__(self) -> str:
        """Return the fault and the ways out, in plain words."""
        return "; ".join((self.problem, *map(str, self.remedies)))


class VocabularyError(HitabError):
    """A behavior, feature, target or parameter that does not exist or is used wrongly."""


class LostBehaviorError(VocabularyError):
    """A behavior that the library has but cannot be used, since a file of it is damaged."""


class TrainingError(HitabError):
    """A demonstrator's command or edit that is not possible now."""


class FeatureValueError(HitabError):
    """A feature whose value is missing, not a number or outside its categories."""


class NoValueError(FeatureValueError):
    """A feature that has no value now; a learned tree decides without it."""


class LibraryError(HitabError):
    """A behavior file or library folder that cannot be read, trusted or written."""


class FolderInUseError(LibraryError):
    """A folder that another process has locked."""


def newer_format(found: object, newest: int) -> str:
    """Return the fault of a file whose format is newer than the newest readable one."""
    return f"has format version {found}, but this HiTAB reads up to {newest}; update HiTAB"
