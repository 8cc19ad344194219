"""Names commands the way the user types them.

Texts name commands as ``hitab VERB``. Where `hitab` is not on the PATH, because it was called as
``scripts/hitab``, what is printed has to be named so, or it cannot be run as it stands.
"""

from __future__ import annotations

import os
import re

CALLED_AS = "HITAB_CALLED_AS"
"""Environment variable that ``scripts/hitab`` sets to how it was called."""

_COMMAND = re.compile(r"(?m)(^\s*|`|: )hitab(?= [a-zA-Z-])")


def as_called(text: str) -> str:
    """Return a text with its commands named as the user calls `hitab`.

    A command begins a line, or comes after a backtick or a colon.
    """
    name = os.environ.get(CALLED_AS)
    return _COMMAND.sub(lambda found: f"{found[1]}{name}", text) if name else text
