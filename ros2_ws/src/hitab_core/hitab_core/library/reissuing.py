"""Gives a behavior file another provenance without reading it for a domain.

So what was kept of an agent on another computer, or of a commander, can be sent back to it as its
next version.
"""

from __future__ import annotations

from typing import Any

from hitab_core.errors import LibraryError
from hitab_core.library.behavior_text import behavior_text
from hitab_core.library.digests import checksum
from hitab_core.library.yaml_places import read_yaml

_PROVENANCE = "\nprovenance:\n"


def reissued(text: str, file: str, **changes: Any) -> str:
    """Return a behavior file whose provenance says something else.

    Args:
        text: of the file.
        file: its name, for errors.
        changes: to its provenance, by key, such as ``version`` and ``note``.

    Raises:
        LibraryError: if it is not a behavior file that could have been saved.
    """
    content = content_of(text, file)
    unknown = sorted(set(changes) - set(content["provenance"]))
    if unknown:
        raise TypeError(f"a provenance has no {', '.join(unknown)}")
    content["provenance"] = content["provenance"] | changes
    content["checksum"] = checksum(content)
    plain = behavior_text(content, {})
    # The comments before the provenance, such as the rules in words, still hold.
    whole = text.rpartition(_PROVENANCE)[0] + _PROVENANCE + plain.rpartition(_PROVENANCE)[2]
    try:
        kept = read_yaml(whole, file).value == content
    except LibraryError:
        kept = False
    return whole if kept else plain


def content_of(text: str, file: str) -> dict[str, Any]:
    """Return the content of a behavior file, after comparing it with its checksum.

    Raises:
        LibraryError: if they differ, or it is no behavior file.
    """
    content: dict[str, Any] = read_yaml(text, file).value
    whole = isinstance(content, dict) and isinstance(content.get("provenance"), dict)
    if not whole or content.get("checksum") != checksum(content):
        raise LibraryError(
            f"{file}: is not a behavior file as it was saved: it was edited or damaged"
        )
    return content
