"""Packages stand on floors: each imports from those below it, and only what is public there."""

import ast
import itertools
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[1] / "ros2_ws" / "src"

FLOORS = (
    ("hitab_core",),  # knows no ROS
    ("hitab_ros",),
    ("hitab_agent", "hitab_client", "hitab_world"),
    ("foraging_world", "hitab_commander", "hitab_robots", "hitab_studio", "keepaway_world"),
    ("half_field_world", "hitab_bringup"),
    ("hitab_machines",),
    ("hitab_class", "hitab_cli", "hitab_rcssserver"),
    ("hitab_export", "hitab_gamepad"),
)

CORE_FLOORS = (
    ("texts",),
    ("example", "hierarchy"),
    ("default_example", "term", "transition_function"),
    ("automaton", "codec", "number", "plain_body", "source_file"),
    ("domain",),
    ("action_behavior", "numeric", "repertoire"),
    ("regression",),
    ("learning",),
    ("advice",),
    ("running",),
    ("drawing", "library"),
    ("training",),
    ("assistant",),
    ("training_session",),
    ("agent_library",),
    ("acting",),
    ("agent",),
    ("labeling", "notebook", "operations", "orders"),
)

OPTIONAL = (SOURCES.parents[1] / "requirements/optional.txt").read_text().split()

PACKAGES = [name for floor in FLOORS for name in floor]

BUDGET = {
    "foraging_world": 850,
    "half_field_world": 450,
    "hitab_agent": 3050,
    "hitab_bringup": 3050,
    "hitab_class": 200,
    "hitab_cli": 3400,
    "hitab_client": 4640,
    "hitab_commander": 1150,
    "hitab_core": 10550,
    "hitab_export": 900,
    "hitab_gamepad": 400,
    "hitab_machines": 1300,
    "hitab_rcssserver": 1200,
    "hitab_robots": 1350,
    "hitab_ros": 1850,
    "hitab_studio": 5450,
    "hitab_world": 2150,
    "keepaway_world": 1350,
    "tests": 35550,
}
"""Maximum lines of code by package, and of all tests: lower it when code goes."""

FILE_MAX = 400
"""Maximum number of lines of a file of the product, comments and docstrings included."""

TIMES_MAX = 63
"""Maximum number of times that modules define: share those of `hitab_ros/timing.py`."""

TIME_WORDS = {"S", "MS", "NS", "HZ", "SECONDS", "MINUTES", "HOURS", "PERIOD", "TIMEOUT"}
SAYS_A_TIME = re.compile(r"(?<![\w'/])(s|ms|Hz|seconds|minutes)(?![\w'])")

CALCULATED = (
    *(ast.Constant, ast.Name, ast.Tuple, ast.expr_context),
    *(ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop),
)

DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def modules(package: str) -> dict[str, Path]:
    root = SOURCES / package
    return {
        ".".join(path.relative_to(root).with_suffix("").parts): path
        for path in (root / package).rglob("*.py")
        if path.name != "__init__.py"
    }


@cache
def all_modules() -> dict[str, Path]:
    return {name: path for package in PACKAGES for name, path in modules(package).items()}


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@cache
def imports(path: Path) -> list[tuple[str, str]]:
    """Return (module, name) for each name that is imported, for type checking too."""
    return [
        (node.module, alias.name) if isinstance(node, ast.ImportFrom) else (alias.name, "")
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.Import) or (isinstance(node, ast.ImportFrom) and node.module)
        for alias in node.names
    ]


@cache
def face(package: str) -> dict[str, str]:
    """Return where each public name of a package is from; a public module is from "."."""
    stub = SOURCES / package.partition(".")[0] / package.replace(".", "/") / "__init__.pyi"
    if not stub.exists():
        return {}
    found = {}
    for node in ast.parse(stub.read_text()).body:
        assert isinstance(node, ast.ImportFrom)
        assert node.level == 1
        for alias in node.names:
            assert alias.asname == alias.name
            found[alias.name] = node.module or "."
    return found


def packages_used(package: str) -> set[str]:
    """Return what a package imports of the others."""
    used = {m.partition(".")[0] for path in modules(package).values() for m, _ in imports(path)}
    return used & set(PACKAGES) - {package}


def lines_of_code(path: Path) -> int:
    """Return the number of lines without docstrings, comments, blank lines and imports."""
    text = path.read_text()
    left_out: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            node = node.body[0]
        elif not isinstance(node, ast.Import | ast.ImportFrom):
            continue
        left_out.update(range(node.lineno, (node.end_lineno or 0) + 1))
    lines = enumerate(map(str.strip, text.split("\n")), 1)
    return sum(bool(x) and x[0] != "#" and number not in left_out for number, x in lines)


def counted_files() -> Iterator[tuple[str, Path]]:
    """Yield the Python files of the repository, each with its line of `BUDGET`."""
    root = SOURCES.parents[1]
    for folder in ("ros2_ws/src", "tests", "research/tests", "examples"):
        for path in (root / folder).rglob("*.py"):
            parts = path.relative_to(root).parts
            if {"test", "tests"} & {*parts}:
                yield "tests", path
            elif folder == "ros2_ws/src":
                yield parts[2], path


def is_number(value: ast.AST) -> bool:
    """Whether an expression is a number, or a tuple of numbers, as far as can be seen."""
    parts = list(ast.walk(value))
    literals = [part.value for part in parts if isinstance(part, ast.Constant)]
    return all(isinstance(part, CALCULATED) for part in parts) and all(
        type(literal) in (int, float) for literal in literals
    )


def times(path: Path) -> Iterator[tuple[str, str]]:
    """Yield each time that a module defines, with its reason: its docstring and comments."""
    text = path.read_text()
    lines, body = text.split("\n"), ast.parse(text).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        found = [
            part.id for one in targets for part in ast.walk(one) if isinstance(part, ast.Name)
        ]
        doc = after.value if isinstance(after, ast.Expr) else None
        reason = str(doc.value) if isinstance(doc, ast.Constant) else ""
        reason += lines[(node.end_lineno or 0) - 1].partition("#")[2]
        above = itertools.takewhile(lambda x: x[:1] == "#", reversed(lines[: node.lineno - 1]))
        reason += "".join(above)
        for name in found:
            says = TIME_WORDS & {*name.split("_")} or SAYS_A_TIME.search(reason)
            if name.isupper() and is_number(node.value) and says:
                yield name, reason


def all_times() -> dict[str, str]:
    """Return the reasons of the product's times, by module and name."""
    return {
        f"{module}.{name}": reason
        for module, path in all_modules().items()
        if path.name != "testing.py"
        for name, reason in times(path)
    }


def test_there_are_few_times_and_no_shared_one_is_defined_twice():
    found = all_times()
    assert len(found) <= TIMES_MAX, (
        f"{len(found)} times, {len(found) - TIMES_MAX} more than TIMES_MAX: use one of "
        f"hitab_ros/timing.py, or wait for an event: {sorted(found)}"
    )
    names = [name.rpartition(".")[2] for name in found]
    assert {name for name in names if names.count(name) > 1} == set()


def test_each_time_has_a_reason():
    short = {name for name, reason in all_times().items() if len(reason.split()) < 5}
    assert short == set()


def test_times_are_found_however_they_are_written(tmp_path):
    module = tmp_path / "module.py"
    module.write_text(
        'WAIT_S = 3 * OTHER\nLIMIT: float = 2.0\n"""Longest wait, s."""\n'
        "A, B = 1, 2  # in seconds\n# at 10 Hz\nRATE = 10\n"
        'SPEED = 1.0\n"""Speed, m/s."""\nNAME_S = "text"\nPLACES_S = find(3)\n'
    )
    assert [name for name, _ in times(module)] == ["WAIT_S", "LIMIT", "A", "B", "RATE"]


@pytest.mark.parametrize("name", BUDGET)
def test_no_package_grows_unseen(name):
    lines = sum(lines_of_code(path) for owner, path in counted_files() if owner == name)
    assert lines <= BUDGET[name], (
        f"{name} has {lines} lines of code, {lines - BUDGET[name]} more than its budget: make it "
        f"smaller, or raise BUDGET in {Path(__file__).name} and say why in the commit"
    )


def test_every_package_has_a_budget_of_lines():
    assert {owner for owner, _ in counted_files()} == {*BUDGET}


def test_no_file_of_the_product_is_long():
    lengths = {
        path.relative_to(SOURCES): len(path.read_text().splitlines())
        for owner, path in counted_files()
        if owner != "tests"
    }
    assert not {path: length for path, length in lengths.items() if length > FILE_MAX}


def test_no_two_public_classes_have_one_name():
    places: dict[str, list[str]] = {}
    for module, path in all_modules().items():
        for node in parsed(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places.setdefault(node.name, []).append(module)
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


def test_few_files_of_a_package_are_in_no_folder():
    loose = Counter(module.partition(".")[0] for module in all_modules() if module.count(".") == 1)
    core = loose.pop("hitab_core")  # what the paper names, each in a file: automaton, example, ...
    assert core <= 16
    assert {package for package, count in loose.items() if count > 13} == set()


def test_packages_import_only_from_lower_floors():
    below: set[str] = set()
    wrong = []
    for floor in FLOORS:
        wrong += [(package, packages_used(package) - below) for package in floor]
        below |= set(floor)
    assert [(package, used) for package, used in wrong if used] == []


def test_optional_packages_are_known_to_nobody_but_one_another():
    assert set(OPTIONAL) < set(PACKAGES)
    used = {name: packages_used(name) & set(OPTIONAL) for name in set(PACKAGES) - set(OPTIONAL)}
    assert {name: found for name, found in used.items() if found} == {}
    extras = (SOURCES.parents[1] / "pyproject.toml").read_text()
    assert [name for name in OPTIONAL if f'"{name.replace("_", "-")}==' not in extras] == []


def test_the_studio_talks_to_a_swarm_through_the_client_alone():
    assert packages_used("hitab_studio") == {"hitab_client", "hitab_core", "hitab_ros"}


def test_a_user_may_have_no_name_so_one_function_alone_asks_for_it():
    asking = {m for m, path in all_modules().items() for s, _ in imports(path) if s == "getpass"}
    assert asking == {"hitab_client.runs.users"}


def test_nothing_of_the_product_imports_research():
    root = SOURCES.parents[1]
    research = {path.stem for path in (root / "research").glob("*.py")}
    research |= {path.name for path in (root / "research/src").iterdir()}
    wrong = [
        f"{path.relative_to(root)} imports {module}"
        for folder in ("ros2_ws/src", "tests", "examples", "docs")
        for path in (root / folder).rglob("*.py")
        for module, _ in imports(path)
        if module.partition(".")[0] in {*research, "research"}
    ]
    assert wrong == []


def test_packages_take_from_others_only_what_these_make_public():
    wrong = []
    for module, path in all_modules().items():
        for source, name in imports(path):
            owner = source.partition(".")[0]
            if owner == module.partition(".")[0] or owner not in PACKAGES:
                continue
            parent, _, leaf = source.rpartition(".")
            public = name in face(source) or face(parent).get(leaf) == "."
            if not public:
                wrong.append(f"{module} imports {name} from {source}")
    assert wrong == []


def test_no_modules_import_each_other_in_a_circle():
    there = all_modules()
    edges: dict[str, set[str]] = {}
    for module, path in there.items():
        found = set()
        for source, name in imports(path):
            found |= {source, f"{source}.{name}"} & set(there)
            origin = face(source).get(name)  # a name that a face hands on
            if origin not in (None, "."):
                found.add(f"{source}.{origin}")
        edges[module] = found & set(there) - {module}
    while leaves := [module for module, used in edges.items() if not used & set(edges)]:
        for module in leaves:
            del edges[module]
    in_circle = {m for m in edges if any(m in used for used in edges.values())}
    assert in_circle == set()


def test_the_parts_of_the_engine_import_only_from_lower_floors():
    height = {part: floor for floor, parts in enumerate(CORE_FLOORS) for part in parts}
    wrong = []
    for module, path in modules("hitab_core").items():
        part = module.split(".")[1]
        for source, _ in imports(path):
            owner, _, rest = source.partition(".")
            used = rest.partition(".")[0]
            if owner == "hitab_core" and used != part and height[used] >= height[part]:
                wrong.append(f"{module} imports {source}")
    assert wrong == []


def test_what_a_face_names_is_there():
    import importlib

    for package in PACKAGES:
        for stub in (SOURCES / package / package).rglob("__init__.pyi"):
            name = ".".join(stub.parent.relative_to(SOURCES / package).parts)
            module = importlib.import_module(name)
            assert set(module.__all__) == set(face(name))
            for public in module.__all__:
                assert getattr(module, public) is not None
