from __future__ import annotations

import pytest

from bt_mission.coverage.places import CoveragePlace
from bt_mission.coverage.record import CoverageTally, CoveredFile
from bt_mission.coverage.report import as_html, as_text, in_ranges

MANY = {"succeeded": 1, "aborted": 0, "rejected": 0, "server lost": 0, "no answer": 0, "lost": 0}


def place(line: int, depth: int, name: str, runs: int, tree: str = "", **marks) -> CoveragePlace:
    """A node in a line of its own; outcomes and branches by name."""
    counts = {f"{what} {first}": n for what, part in marks.items() for first, n in part.items()}
    path = ".".join("0" * (depth + 1))
    return CoveragePlace(tree, path, name, "x", line, 1, {"reached": runs, **counts})


@pytest.fixture
def tally() -> CoverageTally:
    """One file with a named tree."""
    places = [
        place(3, 0, "look", 1, tree="look", outcome=MANY),
        place(5, 0, "tour", 1, outcome={"success": 1, "failure": 0}),
        place(6, 1, "here", 1, outcome={"success": 1}),
        place(7, 1, "either", 1, branch={"1 a": 1, "2 b": 0}),
        place(8, 2, "a", 1),
        place(9, 2, "b", 0),
        place(10, 3, "<below>", 0),
    ]
    source = tuple(f"- line {number} <&>" for number in range(1, 12))
    made = CoverageTally()
    made.add(
        "a",
        CoveredFile(
            "a.yaml", {"a"}, source, {covered_place.key: covered_place for covered_place in places}
        ),
    )
    return made


def lines_of(tally: CoverageTally, *, brief: bool = False) -> tuple[list[str], list[str]]:
    """The lines of the table, and those of the trees."""
    lines = list(as_text(tally, brief=brief))
    end = lines.index("") if "" in lines else len(lines)
    return lines[:end], lines[end:]


def test_the_table_has_a_line_for_each_file(tally):
    """And one for all where there are several."""
    tally.add("b", CoveredFile("much_longer.yaml", {"b"}, (), {(1, 1, "x"): place(1, 0, "b", 1)}))
    assert lines_of(tally)[0] == [
        "missions          nodes  reached  outcomes  seen  branches  taken  cover  missing",
        "a.yaml                7        5         9     3         2      1    50%  9-10",
        "much_longer.yaml      1        1         0     0         0      0   100%",
        "in all                8        6         9     3         2      1    52%",
    ]


def test_the_tree_shows_what_was_not_reached_and_the_way_there(tally):
    """What lies below a node that was never reached is not told again."""
    assert lines_of(tally)[1] == [
        "",
        "a.yaml",
        "        tree look:",
        "     3  look      never: aborted, rejected, server lost, no answer, lost",
        "        the mission:",
        "     5  tour      never: failure",
        "     7    either  never: 2 b",
        "     9      b     never reached",
    ]


def test_a_long_list_is_told_by_what_was_seen(tally):
    """On the terminal."""
    assert "     3  look      only: succeeded (of 6 outcomes)" in lines_of(tally, brief=True)[1]


def test_a_file_that_is_reached_in_full_shows_no_tree():
    """There is nothing to say."""
    tally = CoverageTally()
    tally.add("b", CoveredFile("b.yaml", {"b"}, (), {(1, 1, "x"): place(1, 0, "b", 1)}))
    assert lines_of(tally)[1] == []


def test_lines_between_which_no_node_stands_are_one_range(tally):
    """A comment does not part them, a node that was reached does."""
    (covered,) = tally.in_order()
    assert in_ranges([5, 6, 9, 10], covered) == "5-6, 9-10"
    assert in_ranges([10], covered) == "10"


def test_the_page_shows_the_lines_with_what_is_missing(tally):
    """Escaped, each with its colour."""
    text = as_html(tally)
    assert '<span class="all"><i>6</i>- line 6 &lt;&amp;&gt;</span>' in text
    assert '<span class="part"><i>7</i>- line 7 &lt;&amp;&gt;<b>never: 2 b</b></span>' in text
    assert '<span class="none"><i>10</i>- line 10 &lt;&amp;&gt;<b>never reached</b></span>' in text
    assert '<span class="text"><i>4</i>' in text
    assert "<h1>Coverage of missions: 50%</h1>" in text
