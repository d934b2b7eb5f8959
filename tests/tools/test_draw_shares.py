"""The chart of where the time of a step goes."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from tools import draw_shares

BEFORE = {"physics": 170.0, "tick": 300.0, "lidar": 25.0, "camera": 5.0}
AFTER = {"physics": 160.0, "tick": 90.0, "lidar": 25.0, "camera": 0.0}


def of_script(file: Path, parts: dict[str, float]) -> Path:
    """A file as benchmarks/shares.py writes it."""
    file.write_text(json.dumps({"mission": "m", "rooms": parts}), encoding="utf-8")
    return file


def of_entry_point(file: Path, **sides: dict[str, float]) -> Path:
    """A file as `python -m benchmarks shares --against old --json` writes it."""
    figures: list[dict[str, Any]] = [{"name": "a step, CPU", "old": {"median": 1}, "new": None}]
    figures += [
        {"name": f"{part}: CPU a step"}
        | {side: parts and {"median": parts[part]} for side, parts in sides.items()}
        for part in BEFORE
    ]
    found = {
        "commit": "abc",
        "against": "old" if sides["old"] else None,
        "benchmarks": [{"name": "shares", "figures": figures}],
    }
    file.write_text(json.dumps(found), encoding="utf-8")
    return file


def drawn(monkeypatch: pytest.MonkeyPatch, *words: str | Path) -> int:
    """Run the script."""
    monkeypatch.setattr(sys, "argv", ["draw_shares.py", *map(str, words)])
    return draw_shares.main()


def test_one_file_has_both_commits(tmp_path: Path):
    """The older one first."""
    file = of_entry_point(tmp_path / "both.json", old=BEFORE, new=AFTER)
    assert draw_shares.read([file]) == {"old": BEFORE, "abc": AFTER}
    alone = of_entry_point(tmp_path / "one.json", old={}, new=AFTER)
    assert draw_shares.read([alone]) == {"abc": AFTER}


def test_parts_of_less_than_a_hundredth_are_others():
    """Those that are larger on either side are drawn, by their size before."""
    sides = {"old": {**BEFORE, "camera": 1.0}, "new": AFTER}
    assert draw_shares.rows(sides) == ["tick", "physics", "lidar", "others"]


def test_two_files_are_drawn_beside_each_other(tmp_path: Path, monkeypatch):
    """Each bar with its time and its share; the same files give the same picture."""
    before = of_script(tmp_path / "before.json", BEFORE)
    after = of_script(tmp_path / "after.json", AFTER)
    pictures = [tmp_path / "one.svg", tmp_path / "two.svg"]
    for picture in pictures:
        assert drawn(monkeypatch, before, after, "-o", picture) == 0
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", pictures[0].read_text(encoding="utf-8"))
    for words in ("physics", "before: 500 us", "after: 275 us", "300 us, 60%", "90 us, 33%"):
        assert words in texts
    assert pictures[0].read_bytes() == pictures[1].read_bytes()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "Expecting property name"),
        ('{"benchmarks": []}', "it has no shares; python -m benchmarks shares --json"),
    ],
)
def test_another_file_is_refused_with_its_name(text, words, tmp_path, monkeypatch, capsys):
    """And exit code 2."""
    file = tmp_path / "other.json"
    file.write_text(text, encoding="utf-8")
    assert drawn(monkeypatch, file) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"draw_shares.py: {file}: ")
    assert words in error


def test_three_sides_are_too_many(tmp_path, monkeypatch, capsys):
    """Two are compared."""
    files = [of_script(tmp_path / f"{name}.json", BEFORE) for name in "abc"]
    assert drawn(monkeypatch, *files) == 2
    assert "expected one file with two commits, or two files; got 3" in capsys.readouterr().err
