"""Counts what there is to maintain, by package, at two revisions of the repository.

A line of code is one that is neither blank nor a comment, part of a docstring or of an import.

    scripts/python research/size.py 4c089a1 main
"""

from __future__ import annotations

import argparse
import ast
import io
import subprocess
import tokenize
from collections import Counter
from pathlib import PurePath

from rich.console import Console
from rich.table import Table

LAYOUT = (
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
)
COLUMNS = ("Python", "pages", "YAML", "tests", "test functions", "files")
"""Lines of code of the product, its JavaScript, HTML and CSS, and what it ships; of tests."""


def git(*arguments: str) -> str:
    """Return what a command of git prints."""
    return subprocess.run(["git", *arguments], capture_output=True, text=True, check=True).stdout


def lines_of_code(source: str) -> int:
    """Return the number of lines of code of a Python file."""
    left_out: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        is_text = (
            isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Constant)
            and isinstance(node.value.value, str)
        )
        if is_text or isinstance(node, ast.Import | ast.ImportFrom):
            left_out.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    found: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in LAYOUT:
            found.update(range(token.start[0], token.end[0] + 1))
    return len(found - left_out)


def place(path: PurePath) -> str:
    """Return the package that a file belongs to, or its folder at the top."""
    return path.parts[2] if path.parts[:2] == ("ros2_ws", "src") else path.parts[0]


def count(revision: str) -> dict[str, Counter[str]]:
    """Return the counts of each package."""
    counts: dict[str, Counter[str]] = {}
    for name in git("ls-tree", "-r", "--name-only", revision).splitlines():
        path = PurePath(name)
        if path.parts[0] not in ("ros2_ws", "tests", "research", "benchmarks"):
            continue
        here = counts.setdefault(place(path), Counter())
        here["files"] += 1
        if path.suffix not in (".py", ".js", ".html", ".css", ".yaml"):
            continue
        source = git("show", f"{revision}:{name}")
        filled = sum(1 for line in source.splitlines() if line.strip())
        if path.suffix == ".py" and {"test", "tests"} & set(path.parts):
            here["tests"] += lines_of_code(source)
            here["test functions"] += source.count("def test_")
        elif path.suffix == ".py":
            here["Python"] += lines_of_code(source)
        else:
            here["YAML" if path.suffix == ".yaml" else "pages"] += filled
    return counts


def words(revision: str) -> int:
    """Return the number of words of the pages in docs/."""
    pages = [
        p for p in git("ls-tree", "--name-only", revision, "docs/").split() if p[-3:] == ".md"
    ]
    return sum(len(git("show", f"{revision}:{page}").split()) for page in pages)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("before", help="a revision, such as a tag")
    parser.add_argument("after", help="a later one")
    given = parser.parse_args()
    before, after = count(given.before), count(given.after)
    table = Table("", *COLUMNS, title=f"{given.before} -> {given.after}")
    totals: Counter[str] = Counter()
    for name in sorted(before.keys() | after.keys()):
        old, new = before.get(name, Counter()), after.get(name, Counter())
        cells = [f"{old[column]:,} -> {new[column]:,}" for column in COLUMNS]
        table.add_row(name, *cells)
        for column in COLUMNS:
            totals[f"old {column}"] += old[column]
            totals[f"new {column}"] += new[column]
    sums = [f"{totals[f'old {c}']:,} -> {totals[f'new {c}']:,}" for c in COLUMNS]
    table.add_row("sum", *sums, style="bold")
    Console(width=140).print(table)
    print(f"words of docs/: {words(given.before):,} -> {words(given.after):,}")


if __name__ == "__main__":
    main()
