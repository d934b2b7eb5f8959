"""`tools/plant_defects.py`: which places it chooses, and whether tests catch what it plants."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest

from tests.support.thorough import sample
from tools import plant_defects
from tools.mutations import Place, places
from tools.plant_defects import CHOSEN, KINDS, ROOMS, ROOT, draw, located

EXAMPLE = '''"""An example."""

from typing import TYPE_CHECKING

if TYPE_CHECKING and 1 < 2:
    import math


def clamp(value: int, low: int, high: "int | math.inf") -> int:
    """Limit a number, at most 9 < 10."""
    told.append(value)
    logger.info(value, low)
    if low <= value and value < high:
        return span(value, low + 1)
    raise ValueError(value, 3)


def label(value: int) -> str:
    return str(value + 1)
'''
CHANGES = {
    ("call", "told.append(value)", "pass"),
    ("negation", "if low <= value and value < high:", "if not (low <= value and value < high):"),
    ("boolean", "if low <= value and value < high:", "if low <= value or value < high:"),
    ("comparison", "if low <= value and value < high:", "if low < value and value < high:"),
    ("comparison", "if low <= value and value < high:", "if low <= value and value <= high:"),
    ("arguments", "return span(value, low + 1)", "return span(low + 1, value)"),
    ("off by one", "return span(value, low + 1)", "return span(value, low + 2)"),
}


def example(folder: Path, text: str = EXAMPLE) -> list[Place]:
    """Write a room with one module; return its places."""
    (folder / "room").mkdir(exist_ok=True)
    (folder / "room" / "module.py").write_text(text, encoding="utf-8")
    return places(folder, ["room"])


def test_changes_of_each_kind(tmp_path):
    """Code is changed; docstrings, annotations, logs, errors and texts are not."""
    assert {(place.kind, place.before, place.after) for place in example(tmp_path)} == CHANGES


def test_same_seed_same_places():
    """The seed alone decides which places of a room are drawn."""
    candidates = places(ROOT, ROOMS["goals"])
    drawn = draw(candidates, "goals", 27)
    assert drawn == draw(reversed(candidates), "goals", 27)
    assert drawn != draw(candidates, "goals", 28)


def test_edit_elsewhere(tmp_path):
    """A stored place is found again after lines were added; the nearest replaces a changed one."""
    comparison, other = (place for place in example(tmp_path) if place.kind == "comparison")
    text = EXAMPLE.replace("def clamp", "NEW = [5, 6]\n\n\ndef clamp").replace(
        "low <=", "lowest <="
    )
    entries = [
        comparison.stored(),
        other.stored() | {"before": "if lowest <= value and value < high:"},
    ]
    entries[1]["after"] = "if lowest <= value and value <= high:"
    results = located(entries, example(tmp_path, text))
    assert [(place.after, is_nearest) for place, is_nearest in results] == [
        ("if lowest < value and value < high:", True),
        ("if lowest <= value and value <= high:", False),
    ]


@pytest.mark.parametrize("room", sample(ROOMS, every=99))
def test_stored_places(room):
    """Each room has ten defects in ten places, and each planted file is valid Python."""
    candidates = places(ROOT, ROOMS[room])
    results = [
        place
        for place, _ in located(json.loads(CHOSEN.read_text(encoding="utf-8"))[room], candidates)
    ]
    assert [place.kind for place in results] == [
        kind for kind, count in KINDS.items() for _ in range(count)
    ]
    assert len(set(results)) == 10
    for place in results:
        source = (ROOT / place.file).read_bytes()
        planted = place.planted(source)
        assert ast.dump(ast.parse(planted)) != ast.dump(ast.parse(source))


@pytest.mark.thorough
@pytest.mark.process
def test_verdicts(tmp_path, monkeypatch):
    """A defect is caught by a test of the changed code, survives other tests, or ends no test."""
    monkeypatch.setattr(plant_defects, "CHOSEN", ROOT / "room" / "module.py")
    (tmp_path / "pytest.ini").write_text("[pytest]\npythonpath = .\n", encoding="utf-8")
    module = "def lower(n, limit):\n    while n > limit:\n        n -= 2\n    return n\n"
    candidates = {place.after: place for place in example(tmp_path, module)}
    test = "from room.module import lower\n\ndef test_lower():\n    assert lower({}, {}) == {}\n"

    def verdict(n: int, limit: int, result: int, after: str | None, patience_s: int = 20) -> object:
        text = test.format(n, limit, result)
        (tmp_path / "test_module.py").write_text(text, encoding="utf-8")
        place = candidates[after] if after else None
        row = plant_defects.timed(tmp_path, ["test_module.py"], place, patience_s)
        assert (row["first_failure"] == "test_module.py::test_lower") is (
            row["verdict"] == "caught"
        )
        return row["verdict"]

    assert verdict(5, 2, 1, None) == "survived"
    assert verdict(5, 2, 1, "while n >= limit:") == "survived"
    assert verdict(5, 1, 1, "while n >= limit:") == "caught"
    assert verdict(1, 2, 1, "while not (n > limit):", 4) == "timed out"
    assert (tmp_path / "room" / "module.py").read_text(encoding="utf-8") == module
