"""`bt-mission reproduce`: recordings of faulted runs, stripped to the topics of a robot.

And scans as those of real robots: ranges vary with their length, and rays are lost on surfaces.
"""

from __future__ import annotations

import gzip
import json
import math
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bt_mission.base.files import find
from bt_mission.base.yaml.document import read_text
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.cli.main import main
from bt_mission.cli.recorded_scenario import record_scenario
from bt_mission.commands.reproduce.diagnosis import diagnose
from bt_mission.commands.reproduce.evidence import Evidence, EvidenceReader, Path2D
from bt_mission.commands.reproduce.matching import matched
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import RecordedFile
from bt_mission.robots.model import load_robot
from bt_mission.scenarios.loader import load_scenario
from tests.support.recordings import write_messages
from tests.support.robot_bag import RobotBag
from tests.support.thorough import sample

SITE = 'requirements: {sees: always age("scan") < 0.5}\n'
DRIVE = {
    "mission": "drive",
    "world": "empty_arena",
    "tree": {
        "sequence": [
            {"drive_on_heading": {"target": {"x": 0.5}, "speed": 0.2}, "timeout": 20},
            {"turn": {"angle": 60}, "timeout": 20},
        ]
    },
}
ROBOT = {"/scan", "/odom", "/tf", "/tf_static", "/cmd_vel", "/joint_states", "/battery_state"}


def recorded(folder: Path, *faults: str, **more: Any) -> Path:
    """Record a run with faults; return the file with the topics of a robot alone.

    Args:
        more: Further keys of the scenario.
    """
    data = {
        **more,
        "scenario": "recorded",
        "mission": DRIVE,
        "faults": list(faults),
        "expect": {"outcome": "any", "orphaned_goals": "any"},
    }
    whole, robot = folder / "whole.mcap", folder / "robot.mcap"
    record_scenario(load_scenario(read_text(to_yaml(data), str(folder / "s.yaml"))), whole)
    kept = (
        (channel, time_ns, message)
        for time_ns, channel, message in RecordedFile(whole).timed_messages()
        if channel.topic in ROBOT or "/_action/" in channel.topic
    )
    return write_messages(McapFile(robot, "a robot"), kept)


def evidence_of(bag: Path) -> Evidence:
    """Read what a recording tells."""
    return EvidenceReader.of(RecordedFile(bag)).evidence(bag)


def test_a_silent_lidar_is_named_and_its_violation_is_repeated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """World, mission, fault and verdict follow from the topics; the case passes as a scenario."""
    bag, site, case = recorded(tmp_path, "at 1.5: lidar_dead lasting 1"), tmp_path / "s", "case"
    site.write_text(SITE, encoding="utf-8")
    (tmp_path / "robot.mcap.gz").write_bytes(gzip.compress(bag.read_bytes()))
    words = ["--require", str(site), "-o", str(tmp_path / case), "--json"]
    assert main(["reproduce", str(tmp_path / "robot.mcap.gz"), *words]) == 0
    result = json.loads(capsys.readouterr().out)
    (fault,) = result["faults"]
    assert (fault["name"], fault["start"]) == ("lidar_dead", 1.55)
    assert result["verdict_recorded"]["violated"] == ["sees"]
    assert result["verdict_simulated"]["violated"] == ["sees"]
    assert result["goals_recorded"] == result["goals_simulated"]
    assert result["path_error_m"]["largest"] < 0.05
    assert result["unexplained"] == []
    names = {path.name for path in (tmp_path / case).iterdir()}
    files = {"robot.scenario.yaml", "robot.png"}
    assert names == {"world.yaml", "mission.yaml", *files}
    assert main(["run", str(tmp_path / case / "robot.scenario.yaml"), "--plain"]) == 0


@pytest.mark.parametrize(
    ("faults", "expected"),
    sample(
        [
            (
                (
                    "at 0.5: odometry_drift turn 10 lasting 1",
                    "at 1.0: battery_charge 0.3",
                    "at 2.0: abort_goal drive_on_heading",
                ),
                {
                    "odometry_drift": (0.5, 1.5),
                    "battery_charge": (1.0, None),
                    "abort_goal": (2.0, None),
                },
            ),
            (
                ("at 0.8: block_wheel left lasting 0.5", "at 0.0: drop_answers drive_on_heading"),
                {"drop_answers": (0.05, None), "block_wheel": (0.8, 1.3)},
            ),
            (
                (
                    "at 1.0: spawn_box ahead 1 size (0.2, 0.3, 0.4)",
                    "at 0.5: lidar_blind (90, 150) lasting 1",
                ),
                {"lidar_blind": (0.5, 1.5), "spawn_box": (1.0, None)},
            ),
            (("at 1.5: shove 0.9 -0.5",), {"shove": (1.5, 1.6)}),
        ],
        3,
    ),
)
def test_faults_are_named_with_their_times(
    faults: tuple[str, ...], expected: dict[str, tuple[float, float | None]], tmp_path: Path
) -> None:
    """To a tenth of a second, and no others."""
    bag = recorded(tmp_path, *faults)
    diagnosis = diagnose(evidence_of(bag), load_robot(find("robots", "waffle")))
    named = {each.name: each for each in diagnosis.faults}
    assert set(named) == set(expected)
    for name, (start, end) in expected.items():
        assert named[name].start == pytest.approx(start, abs=0.11)
        assert named[name].end == (None if end is None else pytest.approx(end, abs=0.11))


def test_a_recording_without_what_is_needed_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The error names what is missing, and the topics that are there."""
    bag = RobotBag(tmp_path / "bag.mcap", "/robot1")
    for step in range(30):
        bag.odometry(step / 10, x=step / 50, speed=0.2)
    bag.close()
    assert main(["reproduce", str(bag.path), "-o", str(tmp_path / "case")]) == 2
    error = capsys.readouterr().err
    assert "has neither scans nor a map" in error
    assert error.rstrip().endswith("[BT-1005]")
    words = ["--topic", "scan:=/front/scan", "-o", str(tmp_path / "case")]
    assert main(["reproduce", str(bag.path), *words]) == 2
    assert "has no topic /front/scan (topics: /robot1/odom)" in capsys.readouterr().err


def _drive(bag: RobotBag, times: range) -> None:
    for step in times:
        bag.odometry(step / 10, x=step / 50, speed=0.2)
        bag.scan(step / 10, [1.0] * 90)


def _jumping(folder: Path) -> Path:
    bag = RobotBag(folder / "bag.mcap")
    _drive(bag, range(20))
    _drive(bag, range(-10_000, -9_980))
    return bag.close()


def _cut_archive(folder: Path) -> Path:
    bag = RobotBag(folder / "bag.mcap")
    _drive(bag, range(20))
    path = folder / "bag.mcap.gz"
    path.write_bytes(gzip.compress(bag.close().read_bytes())[:60])
    return path


def _text(folder: Path) -> Path:
    path = folder / "bag.mcap"
    path.write_text("no recording\n", encoding="utf-8")
    return path


def _empty_folder(folder: Path) -> Path:
    (folder / "bag").mkdir()
    return folder / "bag"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (_jumping, "its times go back by 1,002 s; were its parts recorded by different clocks?"),
        (_cut_archive, "cannot unpack it: Compressed file ended before"),
        (_text, "not an MCAP file"),
        (_empty_folder, "the folder has no MCAP file"),
    ],
)
def test_bad_recordings_are_refused(
    make: Callable[[Path], Path], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With a message that names the file, and without a case."""
    path = make(tmp_path)
    assert main(["reproduce", str(path), "-o", str(tmp_path / "case")]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"{path}: ")
    assert message in error
    assert not (tmp_path / "case").exists()


@pytest.mark.thorough
def test_poses_of_odometry_that_drifts_are_corrected_by_scans(tmp_path: Path) -> None:
    """Without a map, walls are straight although the wheels count wrong."""
    bag = recorded(tmp_path, "at 0.0: odometry_drift turn 4")
    evidence = evidence_of(bag)
    times, x, y, yaw = evidence.odometry.T[:4]
    odometry = Path2D(times, x, y, yaw, "odom")
    lost = replace(evidence, track=odometry, grid=None)
    truth = evidence.track.pose(evidence.end_s)
    counted, corrected = (each.track.pose(evidence.end_s) for each in (lost, matched(lost)))
    assert abs(counted.yaw - truth.yaw) > 0.2
    assert abs(corrected.yaw - truth.yaw) < 0.03
    assert math.dist((corrected.x, corrected.y), (truth.x, truth.y)) < 0.05


HALF_X, HALF_Y = 4.0, 3.0
"""Of a room, m."""
POST = (1.0, 2.2)
RAYS = 360
REST_S, SPEED = 2.0, 0.4


def _ranges(x: float, generator: np.random.Generator) -> Any:
    """Return the ranges of a lidar in a room, which has a dark wall ahead and a thin post."""
    angles = np.arange(RAYS) * math.tau / RAYS
    cos, sin = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        to_x = np.where(cos > 0, HALF_X - x, -HALF_X - x) / cos
        to_y = np.where(sin > 0, HALF_Y, -HALF_Y) / sin
    ranges = np.minimum(np.where(to_x > 0, to_x, np.inf), np.where(to_y > 0, to_y, np.inf))
    lost = np.where(ranges == to_x, 0.6, 0.2)  # in a dark wall, in another
    along = (POST[0] - x) * cos + POST[1] * sin
    across = np.abs(POST[1] * cos - (POST[0] - x) * sin)
    ranges = np.where((across < 0.04) & (along > 0), along, ranges)
    ranges += generator.normal(0.0, 0.01 * np.maximum(ranges - 1, 0.5))
    return np.where(generator.random(RAYS) < lost, np.inf, ranges)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot rests, drives through the room, and rests; it sends no goals, and has no map."""
    generator = np.random.default_rng(1)
    written = RobotBag(tmp_path_factory.mktemp("bag") / "room.mcap")
    for step in range(200):
        time_s = step * 0.05
        drives = REST_S <= time_s < 2 * REST_S + 3
        x = -1.0 + SPEED * min(max(time_s - REST_S, 0.0), REST_S + 3)
        written.odometry(time_s, x=x, speed=SPEED if drives else 0.0)
        if step % 2 == 0:
            written.scan(time_s, _ranges(x, generator).tolist(), increment=math.tau / RAYS)
    return written.close()


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("rate", "repeated", "sent", "faults"),
    sample(
        [
            (30.0, range(0), 3, []),  # a bag of two recorders, and one of their messages twice
            (30.0, range(40, 41), 1, ["at 1.32: lidar_frozen lasting 0.05"]),
            (10.0, range(20, 30), 1, ["at 1.95: lidar_frozen lasting 1.0"]),
        ],
        3,
    ),
)
def test_a_lidar_is_frozen_if_new_scans_repeat_the_last(
    tmp_path: Path, rate: float, repeated: range, sent: int, faults: list[str]
) -> None:
    """Not if the same scan, with its stamp, arrives again; no fault is shorter than a step."""
    generator = np.random.default_rng(1)
    written = RobotBag(tmp_path / "scans.mcap")
    ranges = _ranges(-1.0, generator)
    for step in range(round(4 * rate)):
        written.odometry(step / rate, x=-1.0, speed=0.0)
        if step not in repeated:
            ranges = _ranges(-1.0, generator)
        for copy in range(sent):
            time_s = step / rate + copy * 0.001
            written.scan(time_s, ranges.tolist(), increment=math.tau / RAYS, stamp_s=step / rate)
    evidence = matched(evidence_of(written.close()))
    diagnosis = diagnose(evidence, load_robot(find("robots", "burger")))
    assert [each.fault.text for each in diagnosis.faults] == faults


@pytest.mark.thorough
def test_a_search_without_optuna_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """And draws its guesses at random."""
    monkeypatch.setitem(sys.modules, "optuna", None)
    monkeypatch.setattr(
        "bt_mission.commands.reproduce.session._Reproducer._is_near", lambda *_: False
    )
    bag = recorded(tmp_path, "at 1.0: push 20 0")
    assert main(["reproduce", str(bag), "-o", str(tmp_path / "case"), "--budget", "2"]) in (0, 1)
    expected = (
        "guesses are drawn at random, which finds less: the package optuna cannot be imported"
    )
    assert expected in capsys.readouterr().out


@pytest.mark.thorough
def test_a_lidar_that_loses_rays_keeps_its_walls(room: Path) -> None:
    """Nothing comes, moves or fails: the walls and the post are in the world."""
    evidence = matched(evidence_of(room))
    diagnosis = diagnose(evidence, load_robot(find("robots", "burger")))
    assert [fault.name for fault in diagnosis.faults] == []
    middles = np.array([(HALF_X, 0.5), (-HALF_X, 0.5), (0.5, HALF_Y), (0.5, -HALF_Y)])
    assert diagnosis.around.distances(middles).max() < 0.1
    assert diagnosis.around.distances(np.array([POST]))[0] < 0.15


@pytest.mark.thorough
def test_a_path_without_goals_is_driven_after_the_same_rest(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Goals of the simulation have none of the recording to be compared with."""
    words = ["-o", str(tmp_path / "case"), "--robot", "burger", "--budget", "1"]
    assert main(["reproduce", str(room), *words, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["verdict_recorded"]["outcome"] == "any"
    assert (result["goals_recorded"], result["events"]) == ([], [])
    assert [text for text in result["unexplained"] if "goals" in text] == []
    mission = (tmp_path / "case" / "mission.yaml").read_text(encoding="utf-8")
    assert "wait: 1.8" in mission
    assert mission.count("navigate_through_poses") == 1
