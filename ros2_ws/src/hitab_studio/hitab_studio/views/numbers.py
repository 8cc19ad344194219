"""Formats numbers for the page."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hitab_client import as_direction
from hitab_core import (
    FLAGS,
    RADIANS,
    Example,
    FeatureKind,
    Term,
    quantity,
    shown_unit,
    shown_value,
)
from hitab_studio.pages.page import Page

ONE_DECIMAL_FROM = 100.0
"""Absolute value from which numbers have one decimal instead of two."""


def measure(value: float, kind: str = "", unit: str = "") -> str:
    """Return the value of a feature, with two decimals and its unit; angles in degrees.

    Args:
        value: value of the feature; NaN if there is none.
        kind: kind of the feature; a boolean is shown as yes or no, a category as its number.
        unit: unit of the feature; "" if none.
    """
    if math.isnan(value):
        return "no value"
    if kind == FeatureKind.BOOLEAN:
        return "yes" if value else "no"
    if kind == FeatureKind.CATEGORICAL:
        return str(int(value))
    digits = 2 if abs(value) < ONE_DECIMAL_FROM else 1
    if unit == RADIANS:
        digits = 1
    value, unit = shown_value(as_direction(value, unit, kind), unit), shown_unit(unit)
    text = f"{value:.{digits}f}"
    text = text.removeprefix("-") if float(text) == 0.0 else text
    return f"{text} {unit}" if unit else text


def measured(page: Page, feature: str, value: float) -> str:
    """Return the value of an agent's feature for people, with the unit."""
    words, name = page.watched.vocabulary, Term.parse(feature).name
    kind = FeatureKind.BOOLEAN if name in FLAGS else words.kinds.get(name, "")
    return measure(value, kind, words.units.get(name, ""))


def duration(seconds: float) -> str:
    """Return a time for people, such as ``25 s`` or ``3 min 20 s``."""
    whole = round(seconds)
    minutes, rest = divmod(whole, 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def counted(examples: Sequence[Example]) -> str:
    """Return a text with the number of examples that count, and of overruled ones if any."""
    count = sum(example.is_learned for example in examples)
    overruled = len(examples) - count
    if not overruled:
        return quantity(count, "example")
    counts, are = "count" if count != 1 else "counts", "are" if overruled != 1 else "is"
    return f"{quantity(count, 'example')} {counts}, {overruled} {are} overruled"
