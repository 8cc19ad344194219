"""`hitab library`: the choice of a library, and changes of libraries."""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from hitab_bringup import read_swarm
from hitab_bringup.casting import Cast
from hitab_bringup.libraries.library_choice import with_library
from hitab_bringup.libraries.run_libraries import prepare
from hitab_bringup.swarm_files.swarm_options import described_swarm
from hitab_cli.main import make_app
from hitab_cli.verbs.libraries import library_change_verbs as library_changes
from hitab_client import DescriptionError, RunFolder, RunRecord, SwarmError
from hitab_client.runs.shipped import find_file, shipped
from hitab_core import BehaviorLibrary, LearningAgent, LibraryError, load_domain

KEEPAWAY = ["ApproachBall", "ControlBall", "GotoBall", "Keepaway"]


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keep away from the user's own swarms."""
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.delenv("HITAB_LIBRARY", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "home"


@pytest.fixture
def lib(tmp_path: Path) -> Path:
    """Return a copy of the shipped soccer library."""
    folder = tmp_path / "lib"
    shutil.copytree(shipped("libraries", "keepaway"), folder)
    return folder


def hitab(*arguments: str) -> Any:
    return CliRunner().invoke(make_app(), list(arguments), env={"COLUMNS": "300", "TERM": "dumb"})


def said(result: Any) -> str:
    return re.sub(r"\s+", " ", result.output)


def done(*arguments: str) -> str:
    result = hitab(*arguments)
    assert result.exit_code == 0, result.output
    return said(result)


def refused(*arguments: str) -> str:
    result = hitab(*arguments)
    assert result.exit_code == 1, result.output
    return said(result)


def run_before(home: Path, swarm: str = "keepaway_trained") -> RunFolder:
    """Create the leftovers of a swarm, as if it had been up."""
    description = read_swarm(find_file(swarm, "swarms", "swarm"))
    folder = RunFolder(home / description.name)
    folder.prepare()
    prepare(description, folder.path)
    return folder


@pytest.fixture
def up(home: Path, monkeypatch: pytest.MonkeyPatch) -> RunFolder:
    """Register a swarm as up."""
    folder = run_before(home)
    record = RunRecord(
        "keepaway_trained", "", 7, "", ("keeper_1", "keeper_2", "keeper_3"), True, 1, "", "k-1"
    )
    folder.write(record, register=True)
    monkeypatch.setattr(RunFolder, "supervisor", lambda self, record: object())
    return folder


def library_of(folder: Path) -> BehaviorLibrary:
    return BehaviorLibrary(folder, load_domain("keepaway"))


# -- which library ----------------------------------------------------------------------------


def test_with_nothing_up_and_none_named_it_says_which_libraries_there_are(
    home: Path, lib: Path
) -> None:
    run_before(home)
    text = refused("library", "list")
    assert "choose a library, for example with -l keepaway_trained/keeper_1 (known: " in text
    for name in ("keepaway_trained/keeper_1", "keepaway", "lib"):
        assert "ApproachBall" in done("library", "list", "-l", name)
    assert "-l keepaway_trained/keeper_2 " in refused("library", "list", "-a", "keeper_2")
    assert "foraging" in text
    assert "ApproachBall" not in text


def test_the_library_of_the_swarm_that_is_up_is_meant_if_its_agents_have_the_same(
    up: RunFolder,
) -> None:
    text = done("library", "show", "ApproachBall")
    assert "the library of keeper_1, which the others of the swarm equal" in text
    library_of(up.path / "libraries" / "keeper_2").remove("Keepaway")
    text = refused("library", "show", "ApproachBall", "--deep")
    assert "there are differences between the libraries of the swarm" in text
    assert "--agent (known: keeper_1, keeper_2, keeper_3)" in text
    assert "Keepaway" not in done("library", "list", "--agent", "keeper_2")
    assert 'Did you mean "keeper_2"?' in refused("library", "list", "--agent", "keper_2")


def test_where_the_libraries_differ_each_behavior_is_listed_with_the_agents_that_have_it(
    up: RunFolder,
) -> None:
    for path in (up.path / "libraries" / "keeper_2").glob("*.hfa.yaml"):
        path.unlink()
    library_of(up.path / "libraries" / "keeper_3").remove("Keepaway")
    lines = hitab("library", "list").output.splitlines()
    owners = {line.split()[0]: re.split(r"\s{2,}", line.strip())[-1] for line in lines}
    assert owners["behavior"] == "agents"
    assert owners["Keepaway"] == "keeper_1"
    assert owners["GotoBall"] == "keeper_1, keeper_3"
    assert "nothing is saved in the library of keeper_2" in lines
    listed = json.loads(hitab("library", "list", "--json", "-").stdout)
    assert {row["name"]: row["agents"] for row in listed}["Keepaway"] == ["keeper_1"]
    # A behavior that only some agents have, but equally, needs no agent.
    assert "Keepaway" in done("library", "show", "Keepaway")
    assert 'has "Keepawy"' in refused("library", "show", "Keepawy")


def test_all_libraries_of_the_swarm_that_is_up_are_checked(up: RunFolder) -> None:
    assert done("library", "check").count("nothing is wrong") == 3
    (up.path / "libraries" / "keeper_2" / "GotoBall.hfa.yaml").write_text("nothing")
    text = refused("library", "check")
    assert text.count("nothing is wrong") == 2
    assert "GotoBall.hfa.yaml:1: " in text
    where = up.path / "libraries" / "keeper_2"
    assert f"{where}: 3 of 4 behaviors cannot be used" in text
    assert f"`hitab library delete GotoBall -l {where}`" in text


# -- changing ---------------------------------------------------------------------------------


def test_what_is_exported_is_imported_elsewhere_with_what_it_is_made_of(
    lib: Path, tmp_path: Path
) -> None:
    text = done("library", "export", "GotoBall", "-l", "lib")
    assert "wrote ApproachBall, GotoBall to GotoBall.bundle.yaml" in text
    text = done("library", "import", "GotoBall.bundle.yaml", "-l", "new")
    assert "ApproachBall: new GotoBall: new imported 2 behaviors into new" in text
    assert sorted(library_of(tmp_path / "new").load()) == ["ApproachBall", "GotoBall"]
    text = done("library", "import", "GotoBall.bundle.yaml", "-l", "new")
    assert "ApproachBall: the same is there already" in text
    assert "imported" not in text


def test_an_import_says_what_it_replaces_before_and_after(lib: Path, tmp_path: Path) -> None:
    done("library", "export", "-l", "lib", "-o", "all.yaml")
    other = tmp_path / "other"
    shutil.copytree(lib, other)
    path = other / "Keepaway.hfa.yaml"
    path.write_text(path.read_text().replace('description: "', 'description: "Ours. '))
    assert "the file was edited" in done("library", "check", "-l", "other")
    number = library_of(other).file("Keepaway").provenance.version
    replaced = f"version {number + 1}, replaces version {number} (8 examples)"
    before = {path: path.read_bytes() for path in other.rglob("*") if path.is_file()}
    text = done("library", "import", "all.yaml", "-l", "other", "--dry-run")
    assert f"Keepaway: {replaced}" in text
    assert {path: path.read_bytes() for path in other.rglob("*") if path.is_file()} == before
    assert f"Keepaway: {replaced}" in done("library", "import", "all.yaml", "-l", "other")


def test_the_agents_that_use_a_library_read_what_is_changed_in_it(
    up: RunFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[str]] = []

    def reload(agents: list[str]) -> Any:
        asked.append(agents)
        yield agents[0], "2 trained behaviors", True

    @contextmanager
    def connection(swarm: str) -> Iterator[Any]:
        if len(asked) > 1:
            raise SwarmError("keeper_2 does not answer")
        yield SimpleNamespace(agents=SimpleNamespace(reload=reload))

    monkeypatch.setattr(library_changes, "connection", connection)
    text = done("library", "delete", "Keepaway", "--agent", "keeper_2")
    assert "read again: keeper_2: 2 trained behaviors" in text
    version = re.search(r"library restore Keepaway (\d+)", text)[1]  # type: ignore[index]
    done("library", "restore", "Keepaway", version, "--agent", "keeper_2")
    assert asked == [["keeper_2"], ["keeper_2"]]
    text = done("library", "delete", "Keepaway", "--agent", "keeper_2")
    assert "keeper_2 does not answer; its agents have not read the change" in text


def test_the_only_version_is_restored_without_its_number(lib: Path) -> None:
    versions = lib / ".versions" / "Keepaway"
    shutil.rmtree(versions, ignore_errors=True)
    done("library", "delete", "Keepaway", "-l", "lib")
    assert "restored version" in done("library", "restore", "Keepaway", "-l", "lib")
    assert "Keepaway" in library_of(lib).load()


# -- for a swarm ------------------------------------------------------------------------------


def swarm(name: str) -> Any:
    return read_swarm(find_file(name, "swarms", "swarm"))


def test_a_library_of_a_world_in_one_file_is_opened_with_the_file(tmp_path: Path) -> None:
    words = "from hitab_core import behavior\n\n@behavior\ndef Go(percept):\n    return [1.0]\n"
    (tmp_path / "walk.py").write_text(
        f"{words}\nfrom hitab_world import Simulation\nclass Walk(Simulation):\n    pass\n"
    )
    agent = LearningAgent(load_domain("walk.py"), tmp_path / "mine").train("March", features=[])
    agent.step([0.0], command="Go")
    agent.save()
    described = described_swarm("walk.py", None, library="mine")
    assert [member.library for member in described.agents] == [tmp_path / "mine"]
    del sys.modules["hitab_file_walk"]  # as in another process
    assert "hitab library --file my_world.py" in refused("library", "list", "-l", "mine")
    assert "March" in done("library", "--file", "walk.py", "list", "-l", "mine")


@pytest.mark.parametrize("named", ["./payload.py", "payload:DOMAIN"])
def test_a_domain_that_a_library_or_bundle_names_runs_no_file(
    lib: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "payload.py").write_text("from pathlib import Path\nPath('ran').touch()\n")
    done("library", "export", "GotoBall", "-l", "lib", "-o", "one.bundle.yaml")
    bundle = tmp_path / "one.bundle.yaml"
    bundle.write_text(re.sub("(?m)^domain: .*", f'domain: "{named}"', bundle.read_text()))
    for file in lib.glob("*.hfa.yaml"):
        file.write_text(file.read_text().replace("name: keepaway,", f'name: "{named}",'))
    for verb in (("list", "-l", "lib"), ("import", "one.bundle.yaml", "-l", "new")):
        assert f'no domain "{named}" is installed' in refused("library", *verb)
        assert not (tmp_path / "ran").exists()


def test_a_library_is_only_for_those_of_its_domain(lib: Path) -> None:
    with pytest.raises(DescriptionError, match=r'of domain "keepaway", and no agent .* foraging'):
        with_library(swarm("foraging"), "lib")
    description = with_library(swarm("keepaway_captain"), "lib")
    assert [c.library for c in description.commanders] == [None]


def test_nothing_is_saved_into_a_shipped_library() -> None:
    with pytest.raises(LibraryError, match="is shipped with HiTAB"):
        with_library(swarm("keepaway"), "keepaway")


# -- taking a behavior to a robot's own program -------------------------------------------------


def test_a_behavior_of_an_agent_or_of_a_library_is_exported_for_a_program_of_ones_own(
    up: RunFolder, tmp_path: Path
) -> None:
    assert "wrote Keepaway to Keepaway.py" in done(
        "export", "keeper_1", "Keepaway", "--to", "python"
    )
    namespace: dict[str, Any] = {"__name__": "exported"}
    exec((tmp_path / "Keepaway.py").read_text(), namespace)
    robot = namespace["Keepaway"]()
    percept = {"ATeammateIsCloserToBall": 1, "IWasYelledAt": 0}
    assert robot.tick(percept, 0.0, float).name == "GetOpen"
    done("export", "Carry(squad_box)", "-l", "foraging", "--to", "cpp", "-o", "carry.hpp")
    assert "Carry(squad_box), exported by" in (tmp_path / "carry.hpp").read_text()
    done("export", "Keepaway", "-l", "keepaway", "--to", "bt.xml")
    assert 'main_tree_to_execute="Keepaway"' in (tmp_path / "Keepaway.bt.xml").read_text()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["keper_1", "Keepaway"], 'Did you mean "keeper_1"?'),
        (["keeper_1", "Keepawy"], 'Did you mean "Keepaway"?'),
        (["keeper_1", "Keepaway", "GotoBall"], "name an agent and one behavior"),
        (["keeper_1", "Keepaway", "-l", "keepaway"], "only the behavior of a --library"),
        (["Keepaway", "-l", "keepawy"], 'Did you mean "keepaway"?'),
        (["Carry", "-l", "foraging"], "write, for example, Carry("),
        (["ServoBall", "-l", "keepaway"], "written by hand"),
        (
            ["Keepaway", "-l", "keepaway", "-o", "there"],
            "choose another with -o FILE, or give --fo",
        ),
        (["Keepaway", "-l", "keepaway", "-o", "there/in.py"], "there/in.py"),
        (["Keepaway", "-l", "keepaway", "-o", ".", "--force"], ". is a folder"),
    ],
)
def test_nothing_is_exported_by_wrong_words_or_over_another_file(
    up: RunFolder, tmp_path: Path, arguments: list[str], why: str
) -> None:
    (tmp_path / "there").write_text("mine")
    assert why in refused("export", *arguments, "--to", "python")
    assert (tmp_path / "there").read_text() == "mine"
    assert [path.name for path in tmp_path.glob("*.py")] == []


def test_an_export_replaces_a_file_if_told_to(tmp_path: Path) -> None:
    (tmp_path / "Keepaway.py").write_text("old")
    done("export", "Keepaway", "-l", "keepaway", "--to", "python", "--force")
    assert "class Keepaway" in (tmp_path / "Keepaway.py").read_text()


def test_an_earlier_version_is_compared_with_those_who_have_it(home: Path) -> None:
    for name in ("keeper_1", "keeper_2"):
        shutil.copytree(
            shipped("libraries", "keepaway"), home / "keepaway_trained/libraries" / name
        )
    taught = library_of(home / "keepaway_trained/libraries/keeper_2")
    taught.save(taught.load()["Keepaway"])
    number = taught.on_disk.versions("Keepaway")[-1]
    cast = Cast(swarm("keepaway_trained"))
    cast.choose_libraries([f"Keepaway@{number}"])
    versions = {name: part.versions for name, part in cast.parts().items()}
    assert versions == {"keeper_1": {}, "keeper_2": {"Keepaway": number}, "keeper_3": {}}
    cast.choose_libraries(["Keepaway@99"])
    with pytest.raises(LibraryError, match='no version 99 of "Keepaway"'):
        cast.parts()
