"""Two versions of a text beside the one with which both began."""

from __future__ import annotations

from random import Random

from bt_mission.commands.edit.merge import Hunk, hunks

BASE = "a\nb\nc\nd\ne\n"


def test_each_place_has_its_three_versions() -> None:
    """The changed version is proposed; nothing is, where both have changed the same lines."""
    cut = hunks(BASE, "a\nB\nc\nd\nx\n", "a\nb\nc\nnew\nd\ny\n")
    assert cut == (
        Hunk("a\n", "a\n", "a\n"),
        Hunk("b\n", "B\n", "b\n"),
        Hunk("c\n", "c\n", "c\n"),
        Hunk("", "", "new\n"),
        Hunk("d\n", "d\n", "d\n"),
        Hunk("e\n", "x\n", "y\n"),
    )
    assert [hunk.choice for hunk in cut if hunk.theirs != hunk.mine] == ["theirs", "mine", ""]


def test_versions_are_compared_as_a_whole_where_too_many_lines_are_alike() -> None:
    """Changes of lines that differ are found, however far they are from each other."""
    lines = [f"{number}\n" for number in range(20_000)]
    cut = hunks("".join(lines), "new\n" + "".join(lines), "".join([*lines[:-1], "end\n"]))
    assert [(hunk.theirs, hunk.mine) for hunk in cut if hunk.theirs != hunk.mine] == [
        ("new\n", ""),
        ("19999\n", "end\n"),
    ]
    alike = "x\n" * 20_000
    cut = hunks(alike, f"a\n{alike}b\n", alike)
    assert cut == (Hunk(alike, f"a\n{alike}b\n", alike),)


def test_no_line_of_any_version_is_lost() -> None:
    """The parts of each version, put together, are that version."""
    random = Random(1)
    for _ in range(300):
        texts = ["".join(random.choices("ab\n", k=random.randrange(30))) for _ in range(3)]
        cut = hunks(texts[0], texts[1], texts[2])
        parts = zip(*((hunk.base, hunk.theirs, hunk.mine) for hunk in cut), strict=True)
        assert ["".join(part) for part in parts] == texts or not any(texts)
