"""Names of classifiers in text: ``tree``, ``tree(prune=True)``, ``sklearn.svm.SVC(C=10)``."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hitab_core.texts.errors import VocabularyError


@dataclass(frozen=True, slots=True)
class ClassifierSpec:
    """A classifier by name, with keyword arguments: ``tree``, ``tree(prune=True)``, ..."""

    name: str
    arguments: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: str) -> ClassifierSpec:
        """Read ``name`` or ``name(keyword=literal, ...)`` without running anything.

        Raises:
            VocabularyError: if the text has another form.
        """
        try:
            call = ast.parse(text.strip(), mode="eval").body
            arguments: dict[str, Any] = {}
            if isinstance(call, ast.Call):
                if call.args:
                    raise ValueError
                for keyword in call.keywords:
                    if keyword.arg is None:
                        raise ValueError
                    arguments[keyword.arg] = ast.literal_eval(keyword.value)
                call = call.func
            parts: list[str] = []
            while isinstance(call, ast.Attribute):
                parts.append(call.attr)
                call = call.value
            if not isinstance(call, ast.Name):
                raise ValueError
        except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
            raise VocabularyError(
                f'"{text}" does not name a classifier; write "tree" or '
                '"sklearn.module.Class(keyword=literal, ...)"'
            ) from None
        return cls(".".join([call.id, *reversed(parts)]), arguments)

    def __str__(self) -> str:
        """Return the text that `parse` reads."""
        inner = ", ".join(f"{name}={value!r}" for name, value in self.arguments.items())
        return f"{self.name}({inner})" if inner else self.name
