"""The code of pages runs as it stands and prints what the page shows."""

import ast
import builtins
import contextlib
import io
import re
import textwrap
from importlib import import_module

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


def _snippets(page: str):
    """Yield the code of a page, parsed: blocks that are Python and name something."""
    fenced = re.compile(r"```(?:python)?\n(.*?)```", re.DOTALL)
    indented = re.findall(r"(?:^    .*\n|^\n)+", fenced.sub("", page), re.MULTILINE)
    for text in (*fenced.findall(page), *indented):
        with contextlib.suppress(SyntaxError):
            tree = ast.parse(textwrap.dedent(text))
            if any(
                isinstance(node, ast.Assign | ast.FunctionDef | ast.ImportFrom)
                for node in tree.body
            ):
                yield tree


@pytest.mark.parametrize("name", ["actions.md", "robots.md", "worlds.md", "your-own-robot.md"])
def test_the_code_of_a_page_on_robots_imports_what_it_uses(name):
    known = {*dir(builtins)}
    for tree in _snippets((ROOT / "docs" / name).read_text()):
        nodes = list(ast.walk(tree))
        known |= {
            a.name.split(".")[0] for n in nodes if isinstance(n, ast.Import) for a in n.names
        }
        froms = [n for n in nodes if isinstance(n, ast.ImportFrom)]
        known |= {a.asname or a.name for n in froms for a in n.names}
        for one in froms:
            if not (one.module or "").startswith("my_"):
                there = import_module(str(one.module))
                assert [a.name for a in one.names if not hasattr(there, a.name)] == []
        known |= {n.name for n in nodes if isinstance(n, ast.FunctionDef | ast.ClassDef)}
        known |= {n.arg for n in nodes if isinstance(n, ast.arg)}
        names = [n for n in nodes if isinstance(n, ast.Name)]
        known |= {n.id for n in names if not isinstance(n.ctx, ast.Load)}
        assert [n.id for n in names if n.id not in known] == []
