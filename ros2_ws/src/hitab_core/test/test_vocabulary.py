from __future__ import annotations

import pytest

from hitab_core.errors import VocabularyError
from hitab_core.vocabulary import check_known, has


def test_an_unknown_name_is_told_with_the_known_ones_and_what_was_meant() -> None:
    with pytest.raises(VocabularyError) as refused:
        check_known("behavior", "gofats", ["Stop", "GoFast"], ' in "X"')
    assert str(refused.value) == (
        'unknown behavior "gofats" in "X" (has: GoFast, Stop. Did you mean "GoFast"?)'
    )
    check_known("behavior", "Stop", ["Stop"])


def test_nothing_is_guessed_where_no_name_is_close() -> None:
    assert has(["Stop", "GoFast"], "Turn") == has(["Stop", "GoFast"]) == "(has: GoFast, Stop)"
    assert has([], "Turn") == "(has none)"
