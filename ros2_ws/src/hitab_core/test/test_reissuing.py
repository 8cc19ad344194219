"""A behavior file gets another provenance, and everything else in it stays."""

from pathlib import Path

import pytest

from hitab_core import BehaviorLibrary, LibraryError, load_domain
from hitab_core.library import content_of, reissued

SHIPPED = Path(__file__).parents[2] / "keepaway_world" / "libraries" / "keepaway"


def test_a_file_is_reissued_with_its_comments_and_can_be_read(tmp_path):
    texts = {
        name: (SHIPPED / f"{name}.hfa.yaml").read_text() for name in ("ApproachBall", "GotoBall")
    }
    before = texts["GotoBall"]
    after = reissued(before, "GotoBall.hfa.yaml", version=7, note="generation 2 restored")
    assert [line for line in after.splitlines() if line not in before.splitlines()] == [
        "  version: 7",
        '  note: "generation 2 restored"',
        after.splitlines()[-1],
    ]
    assert content_of(after, "b")["trees"] == content_of(before, "a")["trees"]

    library = BehaviorLibrary(tmp_path, load_domain("keepaway"))
    library.install(texts | {"GotoBall": after})
    assert library.file("GotoBall").provenance.version == 7
    assert library.file("GotoBall").provenance.note == "generation 2 restored"


def test_a_damaged_file_is_not_reissued():
    text = (SHIPPED / "ApproachBall.hfa.yaml").read_text()
    with pytest.raises(LibraryError, match=r"A.hfa.yaml: is not a behavior file as it was saved"):
        reissued(text.replace("4.5", "5.5"), "A.hfa.yaml", version=2)
    with pytest.raises(LibraryError, match=r"A.hfa.yaml: is not a behavior file"):
        reissued("[]", "A.hfa.yaml", version=2)
