"""Files of ranges: what they say, and what is told of a wrong one."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.core.yaml.document import read_text
from bt_mission.search.ranges import RangesFile, Span, StartRanges
from bt_mission.search.session import load_search
from bt_mission.sweeps.base import BaseChanges
from tests.search.conftest import MISSION


def test_a_file_that_says_nothing_has_defaults() -> None:
    """A thousand seeds, three obstacles, three faults; which of them follows from the mission."""
    ranges = RangesFile().ranges
    assert ranges.seeds == range(1000)
    assert (ranges.obstacles.most, ranges.faults.most) == (3, 3)
    assert ranges.faults.kinds is None
    assert ranges.assume == []
    assert ranges.start is None


def test_every_key() -> None:
    """A range has two ends, or is a number."""
    text = """\
seeds: 3..5
worlds: [empty_arena, dqn_stage1]
inputs: {speed: 0.1..0.2, rounds: [1, 2]}
start: {x: -1..1, y: 0}
obstacles: {most: 2, times: 1..4, ahead: 0.5, size: 0.1..0.2, lasting: 1..2}
faults: {most: 1, kinds: [lidar_dead, clock], times: 0..9.5, lasting: 0.5..1}
limit: 40
"""
    file = RangesFile(read_text(text))
    ranges = file.ranges
    assert ranges.seeds == range(3, 6)
    assert [one.name for one in file.parameters] == ["speed", "rounds", "world"]
    assert isinstance(ranges.start, StartRanges)
    assert (ranges.start.x, ranges.start.y) == (Span(-1, 1), Span(0, 0))
    assert ranges.obstacles.ahead == Span(0.5, 0.5)
    assert ranges.faults.times == Span(0, 9.5)
    assert ranges.limit == 40


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("seeds: 5..1", "1:8", "expected the lower end first, got 5..1"),
        ("seeds: 0.5..1", "1:8", "expected integers from 0 up"),
        ("seed: 1..2", "1:1", "unknown key 'seed'"),
        ("start: everywhere", "1:8", "did you mean 'anywhere'?"),
        ("obstacles: {most: 9}", "1:19", "expected at most 4, got the number 9"),
        ("obstacles: {size: 0..1}", "1:19", "expected more than 0"),
        ("faults: {times: -3..2}", "1:17", "expected a time from 0 s up"),
        ("faults: {lasting: soon}", "1:19", "a range such as '0.5..2', got string 'soon'"),
        ("faults: {kinds: [netwrk]}", "1:18", "did you mean 'network'?"),
        ("faults: {kinds: [spawn_box]}", "1:18", "obstacles have ranges of their own"),
        ("obstacles: {speed: 0.1..9}", "1:20", "expected speeds from 0 to 2 m/s"),
        ("assume: [always sped < 1]", "1:17", "unknown signal 'sped'"),
        ("assume: [speed < 1]", "1:16", "this speaks of the start alone"),
        ("inputs: {speed: 3..1}", "1:17", "expected the lower end first"),
        ("inputs: {speed: fast}", "1:17", "a range such as '0.1..0.26', or a list"),
        ("inputs: {speed: {low: 1}}", "1:17", "a range such as '0.1..0.26', or a list"),
    ],
)
def test_errors_have_their_place(text: str, place: str, message: str) -> None:
    """And say what is expected."""
    with pytest.raises(InputError) as caught:
        RangesFile(read_text(text, "ranges.yaml"))
    assert f"ranges.yaml:{place}: error: " in str(caught.value)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("worlds: [empty_arena, nowhere]", "1:23", "no such world: 'nowhere'"),
        ("inputs: {sped: 1..2}", "1:10", "did you mean 'speed'?"),
        ("assume: [\"always not failed('driv')\"]", "1:22", "did you mean 'drive'?"),
        ("inputs: {rounds: [two]}", "1:18", "input 'rounds' expects a number, got string 'two'"),
        ("inputs: {speed: 0.1..7}", "1:17", "fwd_velocity"),
    ],
)
def test_ranges_that_do_not_fit_the_mission(
    tmp_path: Path, text: str, place: str, message: str
) -> None:
    """Worlds that are not there, inputs that it does not have, and values that it refuses."""
    path = tmp_path / "short.yaml"
    path.write_text(MISSION)
    with pytest.raises(InputError) as caught:
        load_search(path, BaseChanges(), RangesFile(read_text(text, "ranges.yaml")), None)
    assert f"ranges.yaml:{place}: error: " in str(caught.value)
    assert message in str(caught.value)
