"""Digests for comparing behaviors: SHA-256, in hexadecimal."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any


def checksum(content: Mapping[str, Any]) -> str:
    """Return the digest of a behavior file's content, without its own checksum.

    Comments, spaces and the order of keys do not matter.
    """
    said = {key: value for key, value in content.items() if key != "checksum"}
    text = json.dumps(said, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def digest_of(checksums: Mapping[str, str]) -> str:
    """Return the digest of several behaviors, given the checksum of each by name.

    Libraries with equal digests hold the same behaviors. An empty library has a digest too.
    """
    lines = "".join(f"{name} {checksums[name]}\n" for name in sorted(checksums))
    return hashlib.sha256(lines.encode()).hexdigest()
