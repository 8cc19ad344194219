"""Errors a user can cause and mend: each names the thing, the place and the way out."""


class HitabError(Exception):
    """Base of all errors that a user, not a programmer, has to mend."""


class VocabularyError(HitabError):
    """A behavior, feature, target or parameter that does not exist or is used wrongly."""


class TrainingError(HitabError):
    """A demonstrator's command or edit that cannot be taken as things stand."""


class FeatureValueError(HitabError):
    """A feature whose value is missing, not a number or outside its categories."""


class LibraryError(HitabError):
    """A behavior file or library folder that cannot be read, trusted or written."""


class FolderInUseError(LibraryError):
    """A folder that somebody else holds at the moment."""


def has(names: object) -> str:
    """Return ``(has: a, b, c)``, the tail of an error about an unknown name."""
    listed = ", ".join(sorted(str(name) for name in names))  # type: ignore[attr-defined]
    return f"(has: {listed})" if listed else "(has none)"
