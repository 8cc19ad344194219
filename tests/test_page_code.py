"""The code of pages runs as it stands and prints what the page shows."""

import contextlib
import io
import re

import pytest
from mentions import ROOT


@pytest.mark.parametrize(("name", "examples"), [("notebook.md", 4), ("when.md", 1)])
def test_the_page_shows_what_its_code_prints(name, examples, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = ROOT / "docs" / name
    blocks = re.findall(r"```(python)?\n(.*?)```", page.read_text(), re.DOTALL)
    assert len(blocks) == 2 * examples
    names = {}
    for (kind, code), (none, shown) in zip(blocks[::2], blocks[1::2], strict=True):
        assert (kind, none) == ("python", "")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, str(page), "exec"), names)  # our own page
        assert printed.getvalue() == shown
