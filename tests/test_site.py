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


def test_links_of_pages_lead_to_others_of_the_site():
    for page, text in PAGES.items():
        prose = re.sub(r"^```.*?^```|`[^`\n]+`", "", text, flags=re.MULTILINE | re.DOTALL)
        for target in re.findall(r"\]\(([^)\s#]+)[^)]*\)", prose):
            outside = re.match(r"[a-z]+:", target)
            there = outside or target in PAGES or (ROOT / "docs" / target).is_file()
            assert there, f"{page} links to {target}"


def test_links_of_a_text_are_moved():
    for text, folder, on_the_site in [
        ("[A](docs/a.md#b)", "", "[A](a.md#b)"),
        ("![A](docs/images/a.png)", "", "![A](images/a.png)"),
        ("[![A](docs/images/a.png)](docs/a.md)", "", "[![A](images/a.png)](a.md)"),
        ("[A](a.md), [B](#b), [C](https://c)", "docs", "[A](a.md), [B](#b), [C](https://c)"),
        ("[A](../README.md#a)", "docs", "[A](index.md#a)"),
        ("[`A`](../LICENSE) B", "docs", "`A` B"),
        ("`[A](../LICENSE)`", "docs", "`[A](../LICENSE)`"),
        ("    [A](../LICENSE)", "docs", "    [A](../LICENSE)"),
    ]:
        assert site_pages.on_the_site(text, folder, "") == on_the_site
    text = site_pages.on_the_site("[A](../ros2_ws/src)", "docs", "https://example.org/hitab")
    assert text == "[A](https://example.org/hitab/blob/main/ros2_ws/src)"


def test_the_reference_names_all_that_a_package_makes_public():
    page = PAGES["api/hitab_robots.md"]
    assert page.startswith("# hitab_robots\n\nRobots with the standard sensors")
    stub = ROOT / "ros2_ws/src/hitab_robots/hitab_robots/__init__.pyi"
    public = re.findall(r" as (\w+)$", stub.read_text(), re.MULTILINE)
    assert re.findall(r"^      heading: (.+)$", page, re.MULTILINE) == public
    assert "::: hitab_robots.sensors.Odometry\n" in page


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


def test_nothing_else_is_overwritten(tmp_path: Path):
    (tmp_path / "mine").touch()
    refused = subprocess.run(
        [ROOT / "scripts/docs", tmp_path], capture_output=True, text=True, check=False
    )
    assert refused.returncode == 1
    assert "holds something else" in refused.stderr
    assert (tmp_path / "mine").exists()
