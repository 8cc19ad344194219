"""Errors a user can cause and fix: each names the thing, the place and the way out."""


class HitabError(Exception):
    """Base of all errors that a user, not a programmer, has to fix."""


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
    """Return what is wrong with a file of a newer format than can be read."""
    return f"has format version {found}, but this HiTAB reads up to {newest}; update HiTAB"
