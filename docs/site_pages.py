"""Lays out the pages of the site for its generator: see scripts/docs.

The pages are written for people who read them in the checkout. On the site, README.md and its
neighbors are pages too, and links to other files lead to the repository that HITAB_REPOSITORY
names; without it, they are plain text. The API reference has a page for each package with an
``__init__.pyi``, with the names that this makes public.
"""

from __future__ import annotations

import argparse
import ast
import os
import posixpath
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "ros2_ws" / "src"
BESIDE = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
"""Pages of the site that are files outside ``docs``."""

_LINK = re.compile(r"(!?)\[((?:[^\[\]]|!\[[^\]]*\]\([^)]*\))*)\]\(([^)\s]+)\)")
_CODE = re.compile(r"^```.*?^```|^ {4}[^\n]*$|`[^`\n]+`", re.MULTILINE | re.DOTALL)


def pages(repository: str = "") -> Iterator[tuple[str, str]]:
    """Yield the name and the text of each page.

    Args:
        repository: address of the repository; empty if none is public.
    """
    for path in sorted(ROOT.glob("docs/*.md")):
        yield path.name, on_the_site(path.read_text(encoding="utf-8"), "docs", repository)
    for name, page in BESIDE.items():
        yield page, on_the_site((ROOT / name).read_text(encoding="utf-8"), "", repository)
    for stub in sorted(SOURCES.glob("*/*/__init__.pyi")):
        yield f"api/{stub.parent.name}.md", "\n".join(reference(stub))


def on_the_site(text: str, folder: str, repository: str) -> str:
    """Return a page whose links lead to where their targets are on the site.

    Args:
        text: of the page.
        folder: where the page is in the checkout, to which its links are relative.
        repository: address of the repository; without one, links to it become plain text.
    """
    code = [match.span() for match in _CODE.finditer(text)]

    def moved(match: re.Match[str]) -> str:
        image, label, target = match.groups()
        path, mark, anchor = target.partition("#")
        if not path or re.match(r"[a-z]+:", path):
            return match[0]
        if any(begin <= match.start() and match.end() <= end for begin, end in code):
            return match[0]
        label = _LINK.sub(moved, label)
        found = posixpath.normpath(posixpath.join(folder, path))
        page = BESIDE.get(found, found.removeprefix("docs/") if found.startswith("docs/") else "")
        if page:
            return f"{image}[{label}]({page}{mark}{anchor})"
        return f"[{label}]({repository}/blob/main/{found})" if repository else label

    return _LINK.sub(moved, text)


def reference(stub: Path) -> Iterator[str]:
    """Yield the lines of a package's page: its docstring, and each public name.

    Args:
        stub: the package's ``__init__.pyi``.
    """
    package = stub.parent.name
    init = stub.with_suffix(".py").read_text(encoding="utf-8")
    yield from (f"# {package}", "", ast.get_docstring(ast.parse(init)) or "", "")
    modules = []
    for node in ast.parse(stub.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.module:
            for name in node.names:
                yield from _object(f"{package}.{node.module}.{name.name}", name.name)
        elif isinstance(node, ast.ImportFrom):
            modules += [name.name for name in node.names]
    for name in modules:
        yield from _object(f"{package}.{name}", f"{package}.{name}")


def _object(path: str, heading: str) -> Iterator[str]:
    yield from (f"::: {path}", "    options:", f"      heading: {heading}", "")


def lay_out(folder: Path, repository: str) -> None:
    """Write the pages, their pictures and the configuration into an empty folder."""
    for name, text in pages(repository):
        path = folder / "docs" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    pictures = folder / "docs" / "images"
    shutil.copytree(ROOT / "docs/images", pictures, ignore=shutil.ignore_patterns("*.py", "__*"))
    sources = sorted(str(path.parent.parent) for path in SOURCES.glob("*/*/__init__.pyi"))
    config = (ROOT / "docs/site.toml").read_text(encoding="utf-8")
    (folder / "zensical.toml").write_text(
        config.replace("paths = []", f"paths = {sources}"), encoding="utf-8"
    )


def main() -> None:
    """Lay the pages out in the folder that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where to, empty or not there yet")
    lay_out(parser.parse_args().folder, os.environ.get("HITAB_REPOSITORY", "").rstrip("/"))


if __name__ == "__main__":
    main()
