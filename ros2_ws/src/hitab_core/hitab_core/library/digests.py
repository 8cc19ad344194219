"""Digests for comparing behaviors: SHA-256, in hexadecimal.

A file has a checksum, which shows damage and edits. A behavior has a digest, which shows whether
two agents have learned the same.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

from hitab_core.example import Example


def checksum(content: Mapping[str, Any]) -> str:
    """Return the digest of a behavior file's content, without its own checksum.

    Comments, spaces and the order of keys do not matter.
    """
    return _digest({key: value for key, value in content.items() if key != "checksum"})


def learned_digest(
    content: Mapping[str, Any], examples: Iterable[Example], trees: Mapping[str, str]
) -> str:
    """Return the digest of the learned automaton, given a behavior file's content.

    Equal digests mean that the behavior has the same states and features and learned the same
    decisions from the same examples, superseded ones left out. When and by whom it was saved, its
    name, description and format version do not matter, nor do the order and numbers of examples,
    commands and cycles, nor the readings.

    Args:
        content: the content, as in `hitab_core.library.behavior_model.BehaviorRecord`.
        examples: the examples in it.
        trees: digest of each state's transition function.
    """
    learned = [
        [
            example.state,
            list(example.point),
            example.next_state,
            example.is_default,  # all other kinds are learned from alike
            # Adding zero makes -0.0, which decides like 0.0, read like it.
            *([[value + 0.0 for value in example.numbers]] if example.numbers else []),
        ]
        for example in examples
        if example.is_learned
    ]
    return _digest(
        {
            "domain": content["domain"]["name"],
            **{key: content[key] for key in ("parameters", "states", "features", "classifier")},
            "examples": sorted(learned, key=_place),
            "trees": dict(trees),
        }
    )


def _place(example: list[Any]) -> list[Any]:
    """Return the sort key of an example; a missing value comes first."""
    state, values, *rest = example
    return [state, [-math.inf if value is None else value for value in values], *rest]


def digest_of(digests: Mapping[str, str]) -> str:
    """Return the digest of several behaviors, given the digest of each by name.

    Libraries with equal digests hold the same behaviors. An empty library has a digest too.
    """
    lines = "".join(f"{name} {digests[name]}\n" for name in sorted(digests))
    return hashlib.sha256(lines.encode()).hexdigest()


def _digest(content: Mapping[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
