from __future__ import annotations

import pytest

from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.vocabulary import check_known, has


def test_an_unknown_name_is_reported_with_the_known_ones_and_what_was_meant() -> None:
    with pytest.raises(VocabularyError) as refused:
        check_known("behavior", "gofats", ["Stop", "GoFast"], ' in "X"')
    assert str(refused.value) == (
        'unknown behavior "gofats" in "X" (known: GoFast, Stop. Did you mean "GoFast"?)'
    )
    check_known("behavior", "Stop", ["Stop"])


def test_of_a_thousand_names_ten_are_listed_the_closest_first() -> None:
    thousand = [f"forager_{number}" for number in range(1, 1001)]
    text = has(thousand, "forager_10001")
    assert text.startswith("(known: forager_1000, forager_")
    assert text.endswith(', ... and 990 more. Did you mean "forager_1000"?)')
    assert text.count("forager_") == 11
    assert has(thousand).startswith("(known: forager_1, forager_2, forager_3,")
    assert has(thousand).endswith(", forager_10, ... and 990 more)")
