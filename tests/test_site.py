"""The site has all pages, and its links lead somewhere; scripts/docs builds it."""

import importlib.util
import json
import os
import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mentions import ROOT

PATH = ROOT / "docs" / "site_pages.py"
SPEC = importlib.util.spec_from_file_location("site_pages", PATH)
assert SPEC is not None
assert SPEC.loader is not None
site_pages = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(site_pages)
PAGES = dict(site_pages.pages())


def navigation(entries: list[Any]) -> Iterator[str]:
    """Go through the pages in a part of the navigation."""
    for entry in entries:
        inner = entry if isinstance(entry, str) else next(iter(entry.values()))
        if isinstance(inner, str):
            yield inner
        else:
            yield from navigation(inner)


def test_each_page_is_once_in_the_navigation():
    project = tomllib.loads((ROOT / "docs/site.toml").read_text())["project"]
    assert sorted(navigation(project["nav"])) == sorted(PAGES)


@pytest.mark.long
def test_the_site_is_built_with_search_and_reference(tmp_path: Path):
    site = tmp_path / "site"
    built = subprocess.run(
        [ROOT / "scripts/docs", site],
        capture_output=True,
        text=True,
        env={**os.environ, "HITAB_DOCS_VENV": str(tmp_path / "environment")},
        check=False,
    )
    assert built.returncode == 0, built.stderr
    assert {f"{page.removesuffix('.md')}.html" for page in PAGES} <= {
        path.relative_to(site).as_posix() for path in site.rglob("*.html")
    }
    for path in site.rglob("*.html"):  # nothing comes from other sites
        assert not re.search(r'<(script|link)[^>]*(src|href)="https?:', path.read_text()), path
    assert "hitab_robots.sensors.Odometry" in (site / "api/hitab_robots.html").read_text()
    assert "LearningAgent" in json.dumps(json.loads((site / "search.json").read_text()))
