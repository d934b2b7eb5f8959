"""Files of ranges and the option ``--vary``: what they say, and the errors of wrong ones."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.commands.falsify.session import load_search
from bt_mission.scenarios.concrete.base_scenario import BaseChanges
from bt_mission.scenarios.concrete.ranges import (
    Interval,
    RangesFile,
    StartRanges,
    ValueChoice,
    ValueRange,
    check_ranges,
    parse_parameter,
    ranges_schema,
    refuse_repeated,
    with_fault_plans,
)
from tests.commands.falsify.conftest import MISSION


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
    assert [parameter.name for parameter in file.parameters] == ["speed", "rounds", "world"]
    assert isinstance(ranges.start, StartRanges)
    assert ranges.start.x == Interval("", -1, 1, is_whole=True)
    assert ranges.start.y == Interval("", 0, 0)
    assert ranges.obstacles.ahead == ValueRange(0.5, 0.5)
    assert ranges.faults.times == ValueRange(0, 9.5)
    assert ranges.limit == 40


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("seeds: 5..1", "1:8", "expected the lower end first, got 5..1"),
        ("seeds: 0.5..1", "1:8", "expected integers from 0 up"),
        ("seeds: [1, 1]", "1:8", "expected different seeds"),
        ("worlds: dqn_stage1", "1:9", "expected a list of names"),
        ("start: {x: [a]}", "1:12", "expected numbers"),
        ("inputs: {speed: 0..1 step 0}", "1:17", "expected a step above 0"),
        ("plans: {a: ['at 1.0: drip scan']}", "1:22", "drip"),
        ("seed: 1..2", "1:1", "unknown key 'seed'"),
        ("start: everywhere", "1:8", "did you mean 'anywhere'?"),
        ("obstacles: {most: 9}", "1:19", "expected at most 4, got the number 9"),
        ("obstacles: {size: 0..1}", "1:19", "expected more than 0"),
        ("faults: {times: -3..2}", "1:17", "expected a time from 0 s up"),
        ("faults: {lasting: soon}", "1:19", "a range such as '0.5..2', got string 'soon'"),
        ("faults: {kinds: [netwrk]}", "1:18", "did you mean 'network'?"),
        ("faults: {kinds: [spawn_box]}", "1:18", "obstacles have separate ranges"),
        ("obstacles: {speed: 0.1..9}", "1:20", "expected speeds from 0 to 2 m/s"),
        ("assume: [always sped < 1]", "1:17", "unknown signal 'sped'"),
        ("assume: [speed < 1]", "1:16", "this covers only the start"),
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
        ("worlds: [empty_arena, nowhere]", "1:23", "unknown world 'nowhere'"),
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


@pytest.mark.parametrize(
    ("reader", "key"), [("sweep", "assume: [always speed < 1]"), ("falsify", "robots: [burger]")]
)
def test_a_key_that_the_command_does_not_read_is_an_error(reader: str, key: str) -> None:
    """Nothing in a file is ignored."""
    with pytest.raises(InputError, match=f"{reader} does not read"):
        RangesFile(read_text(key)).refuse_others(reader)


def test_a_sweep_starts_in_ranges_not_anywhere() -> None:
    """A search moves a place that is not free."""
    with pytest.raises(InputError, match="1:8: error: a sweep has ranges of 'x', 'y' and 'yaw'"):
        RangesFile(read_text("start: anywhere")).refuse_others("sweep")


def test_a_sweep_varies_the_start_and_the_robot() -> None:
    """By the names of its parameters."""
    file = RangesFile(read_text("robots: [burger, waffle]\nstart: {x: -1..1 step 1, yaw: 90}"))
    assert file.parameters == (ValueChoice("robot", ("burger", "waffle")),)
    assert {coordinate.name: coordinate for coordinate in file.start} == {
        "start.x": ValueChoice("start.x", (-1, 0, 1)),
        "start.yaw": ValueChoice("start.yaw", (90,)),
    }


def test_plans_of_several_files(tmp_path: Path) -> None:
    """Each name once; such a file has nothing else."""
    first, second = tmp_path / "a.yaml", tmp_path / "b.yaml"
    first.write_text("plans: {sound: [], late: ['at 0: delay odom 200 ms']}\n")
    second.write_text("plans: {lost: ['at 1.0: drop scan lasting 1']}\n")
    assert list(with_fault_plans({"own": []}, [first, second])) == ["own", "sound", "late", "lost"]
    with pytest.raises(InputError, match="1:9: error: the plan 'sound' already exists"):
        with_fault_plans({}, [first, first])
    second.write_text("plans: {lost: []}\nseeds: 0..3\n")
    with pytest.raises(InputError, match="--fault-plan does not read 'seeds'"):
        with_fault_plans({}, [second])


def test_a_file_is_checked_alone(tmp_path: Path) -> None:
    """By its form, which its schema says, too."""
    path = tmp_path / "wide.yaml"
    path.write_text("seeds: 0..9\ninputs: {speed: 0.1..0.2}\n")
    checked, _ = check_ranges(path)
    assert (checked.name, checked.summary) == ("wide", "seeds, inputs")
    assert {"seeds", "plans", "obstacles"} < set(ranges_schema()["properties"])


# ---- the option --vary ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "parameter"),
    [
        ("speed=0.1,0.2", ValueChoice("speed", (0.1, 0.2))),
        ("world=dqn_stage1,dqn_stage4", ValueChoice("world", ("dqn_stage1", "dqn_stage4"))),
        ("zones=[a, b],[c]", ValueChoice("zones", (["a", "b"], ["c"]))),
        ("say='a,b',c", ValueChoice("say", ("a,b", "c"))),
        ("speed=0.1..0.26", Interval("speed", 0.1, 0.26)),
        ("speed=0.1..0.26 step 0.05", ValueChoice("speed", (0.1, 0.15, 0.2, 0.25))),
        ("legs=1..5 step 2", ValueChoice("legs", (1, 3, 5))),
        ("legs=1..3", Interval("legs", 1, 3, is_whole=True)),
        ("start.x=-1e0..+2.5", Interval("start.x", -1.0, 2.5)),
        ("on=true", ValueChoice("on", (True,))),
        ("x=1,true", ValueChoice("x", (1, True))),
    ],
)
def test_parameters_are_read(text: str, parameter: ValueChoice | Interval) -> None:
    """Values as those of a YAML list, or two ends, with a step or without."""
    assert parse_parameter(text) == parameter


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("speed", "expected NAME=VALUES, such as 'speed=0.1,0.2'"),
        ("=1", "expected NAME=VALUES"),
        ("speed=", "'speed': expected values"),
        ("speed=0.1,0.1", "the value 0.1 appears twice"),
        ("speed=0.3..0.1", "expected the lower end first, got 0.3..0.1"),
        ("speed=0..1 step 1e-9", "expected a step above 0 with at most 1,000 values"),
        ("speed=0.1:0.3", "write 'speed=0.1..0.3'"),
        ("speed=[", "expected values"),
        ("speed={a: 1}", "expected values"),
        ("world=1..2", "'world' has names"),
    ],
)
def test_what_is_wrong_with_a_parameter_is_told(text: str, message: str) -> None:
    """With the option that it stands in."""
    with pytest.raises(InputError) as error:
        parse_parameter(text)
    assert message in str(error.value)
    assert "--vary" in str(error.value)


def test_intervals_give_values_of_six_digits_within_their_ends() -> None:
    """So that the command that repeats a run can be typed."""
    interval = Interval("speed", 0.1, 0.26)
    shares = (0.0, 0.123456789, 0.999999999)
    assert [interval.at(share) for share in shares] == [0.1, 0.119753, 0.26]
    whole = Interval("legs", 1, 3, is_whole=True)
    assert [whole.at(share) for share in (0.0, 0.33, 0.34, 0.67, 0.99)] == [1, 1, 2, 3, 3]


def test_a_parameter_is_varied_once() -> None:
    """Twice is a mistake."""
    with pytest.raises(InputError, match="'speed' is given twice"):
        refuse_repeated([ValueChoice("speed", (1,)), ValueChoice("speed", (2,))])
