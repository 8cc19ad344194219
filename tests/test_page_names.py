"""What pages name is there: the targets of links, files, and options."""

import re
from functools import cache

from mentions import PAGES, ROOT

TEXTS = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for pattern in PAGES
    for path in sorted(ROOT.glob(pattern))
}
SOURCES = ROOT / "ros2_ws/src"
FOLDERS = {path.name for path in (*ROOT.iterdir(), *SOURCES.iterdir()) if path.is_dir()}
"""A path that begins with one of these is one of this checkout."""

PYTHON = {
    path.name
    for folder in ("ros2_ws/src", "tests", "research", "examples", "docs")
    for path in (ROOT / folder).rglob("*.py")
}


def prose(page: str) -> str:
    """Return the text of a page without its fenced code."""
    return re.sub(r"^```.*?^```", "", TEXTS[page], flags=re.DOTALL | re.MULTILINE)


def quoted(page: str) -> set[str]:
    """Return what a page names within a line in backticks."""
    return set(re.findall(r"(?<!`)`([^`\n]+)`(?!`)", prose(page)))


@cache
def anchors(page: str) -> frozenset[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", prose(page), flags=re.MULTILINE)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return frozenset(re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in plain)


def wrong_with_link(page: str, target: str) -> str:
    """Return what is wrong with the target of a link, or ""."""
    if re.match(r"[a-z]+:", target):
        return ""  # elsewhere
    name, _, anchor = target.partition("#")
    path = (ROOT / page).parent / name if name else ROOT / page
    if not path.exists():
        return f"{target}: there is no such file"
    if anchor and anchor not in anchors(path.resolve().relative_to(ROOT).as_posix()):
        return f"{target}: there is no such heading"
    return ""


def is_there(name: str) -> bool:
    """Whether a file is there, named from the top, from a package or from inside one."""
    places = (ROOT, SOURCES, *SOURCES.iterdir(), *(ROOT / "examples").iterdir())
    return any((place / name).exists() for place in places)


def test_every_link_leads_somewhere():
    wrong = [
        f"{page}: {what}"
        for page in TEXTS
        for target in re.findall(r"\]\(([^)\s]+)\)", prose(page))
        if (what := wrong_with_link(page, target))
    ]
    assert wrong == []


def test_every_file_that_is_named_is_there():
    missing = []
    for page in TEXTS:
        for name in sorted(quoted(page)):
            if re.fullmatch(r"[\w.-]+(/[\w.-]+)+/?", name) and name.partition("/")[0] in FOLDERS:
                if not is_there(name):
                    missing.append(f"{page}: {name}")
            elif re.fullmatch(r"\w+\.py", name) and name not in PYTHON:
                missing.append(f"{page}: {name}")
    assert missing == []
