from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core.library.behavior_text import scalar
from hitab_core.library.yaml_places import Complaints, open_yaml, read_yaml
from hitab_core.texts.errors import HitabError, LibraryError, VocabularyError


def test_everything_in_a_document_knows_its_line() -> None:
    document = read_yaml("a: 1\nb:\n  - x\n  - {c: 2,\n     d: 3}\n", "f.yaml")
    assert document.value == {"a": 1, "b": ["x", {"c": 2, "d": 3}]}
    lines = [document.line(path) for path in [(), ("a",), ("b", 0), ("b", 1, "c"), ("b", 1, "d")]]
    assert lines == [1, 1, 3, 4, 5]
    assert document.place(("b", 1, "no such", 7)) == "f.yaml:4"


def test_words_that_other_yaml_takes_for_something_else_stay_text() -> None:
    value = read_yaml("[no, On, 2012-01-01, 12:30:00, 0x1F, 1_000, y]", "f.yaml").value
    assert value == ["no", "On", "2012-01-01", "12:30:00", "0x1F", "1_000", "y"]


def test_numbers_are_numbers_also_without_a_point() -> None:
    assert read_yaml("[1, -2, 1e3, 1.5, .5, 1., 'x', ~]", "f.yaml").value == [
        1,
        -2,
        1000.0,
        1.5,
        0.5,
        1.0,
        "x",
        None,
    ]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("a: 1\nb: 2\na: 3\n", 'f.yaml:3: has the key "a" twice (first at line 1)'),
        ("a: &x [1]\nb: *x\n", "f.yaml:1: has an anchor or alias"),
        ("a: 1\nb: *x\n", "f.yaml:2: has an anchor or alias"),
        ("a: !!python/object/apply:os.system [true]\n", "f.yaml:1: has the tag"),
        ("a: 1\n---\nb: 1\n", "f.yaml:2: has a second document"),
        ("? [a, b]\n: 1\n", "f.yaml:1: has a key that is not a plain name"),
        ("a: [1, 2\nb: 3\n", "f.yaml:2: not YAML"),
        ("a: \x07\n", "f.yaml:1: not YAML"),
        ("", "f.yaml:1: is empty"),
        ("[" * 5000, "f.yaml:1: has more than 20 levels"),
        ('a: "\\UFFFFFFFF"', "f.yaml"),
        ("a: \ud800", "f.yaml: has a lone surrogate"),
    ],
)
def test_what_is_not_plain_data_is_refused_by_line(text: str, complaint: str) -> None:
    with pytest.raises(LibraryError) as refused:
        read_yaml(text, "f.yaml")
    assert str(refused.value).startswith(complaint)


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda path: None, ": cannot read it: No such file or directory; check the path"),
        (Path.mkdir, ": cannot read it: Is a directory; it is a folder; check the path"),
        (os.mkfifo, ": is a pipe, not a file; remove it"),
        (lambda path: path.write_bytes(b"a: 1\nb: \xff"), ":2: is not UTF-8 text; save it as"),
        (lambda path: os.truncate(path.touch() or path, 2**27), ": has more than 67108864 bytes"),
    ],
)
def test_a_file_that_cannot_be_read_is_named_with_a_way_out(
    tmp_path: Path, make: Callable[[Path], object], complaint: str
) -> None:
    path = tmp_path / "f.yaml"
    make(path)
    with pytest.raises(VocabularyError) as refused:
        open_yaml(path, error=VocabularyError)
    assert str(refused.value).startswith(f"{path}{complaint}")


def test_complaints_are_raised_together_in_the_order_of_lines() -> None:
    class MyError(HitabError):
        pass

    complaints = Complaints(read_yaml("a: 1\nb: 2\n", "f.yaml", error=MyError))
    complaints.raise_any()
    complaints.add(("b",), "is wrong")
    complaints.add(("a",), "is not right")
    complaints.add(("a",), "is not right")
    with pytest.raises(MyError, match=r"^f.yaml:1: is not right\nf.yaml:2: is wrong$"):
        complaints.raise_any()


@settings(max_examples=60)
@given(st.text() | st.floats(allow_nan=False) | st.integers(-(10**17), 10**17))
def test_a_scalar_is_read_back_as_it_was_by_any_reader(value: str | float | int) -> None:
    text = f"- {scalar(value)}\n- {{k: {scalar(value)}, l: [{scalar(value)}]}}\n"
    expected = [value, {"k": value, "l": [value]}]
    if value in (float("inf"), float("-inf")):
        return  # is refused before it could be written
    assert read_yaml(text, "f.yaml").value == expected
    assert yaml.safe_load(text) == expected
