"""What every action server keeps to: exceptions, sensors that fail, the end of the servers."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

from action_servers.camera.camera_sweep import ImageFolder
from action_servers.core.maneuver import ZERO, ErrorCode
from bt_mission.base.geometry import Pose2D
from tests.support.served import DRIVING, SERVED, goal
from tests.support.thorough import sample

DRIVES_ON = 20


def begun(bench, name):
    """A goal that has been running for half a second, and is driving if it drives."""
    sent = bench.send(name)
    if SERVED[name].drives:
        bench.until(lambda: bench.moved)
    bench.steps(10)
    return sent


def maneuver(bench, name):
    """The class of the maneuver that carries out a goal of an action."""
    (adapter,) = [offered for offered in bench.servers._adapters if offered.name == f"/{name}"]
    ((run, _),) = adapter._running.values()
    return type(run.maneuver)


def alive(bench, name):
    """Whether the next goal is carried out as usual."""
    following = bench.send(name)
    bench.steps(DRIVES_ON)
    drives = not SERVED[name].drives or bench.commands[-1] != ZERO
    return (following.accepted, following.status, drives) == (True, None, True)


@pytest.mark.parametrize(
    ("name", "method"), sample(itertools.product(SERVED, ["step", "feedback"]), every=5)
)
def test_a_maneuver_that_raises_ends_its_goal_and_not_the_server(bench, name, method, monkeypatch):
    """Aborted with the cause, the robot stopped, the next goal as usual."""
    sent = begun(bench, name)

    def broken(*_: Any) -> None:
        raise KeyError("no such sensor")

    with monkeypatch.context() as patch:
        patch.setattr(maneuver(bench, name), method, broken)
        bench.steps(2)
    assert sent.status == "aborted"
    assert sent.code in (ErrorCode.UNKNOWN, None)
    assert sent.text in ("KeyError: 'no such sensor'", None)
    if SERVED[name].drives:
        assert bench.before_the_last_end == ZERO
    assert alive(bench, name)


def test_a_result_that_raises_still_ends_the_goal(bench, name, monkeypatch):
    """The client is not left waiting."""
    sent = bench.send(name)
    bench.steps(5)

    def broken(*_: Any) -> None:
        raise KeyError("no such sensor")

    with monkeypatch.context() as patch:
        patch.setattr(maneuver(bench, name), "result", broken)
        bench.cancel(name, sent.id)
        bench.steps(1)
    assert sent.status == "canceled"


@pytest.mark.parametrize(
    ("name", "method"), sample(itertools.product(SERVED, ["feedback", "result"]), every=5)
)
def test_fields_that_do_not_exist_end_the_goal_and_not_the_server(bench, name, method, monkeypatch):
    """The reason lists the fields that there are."""
    sent = begun(bench, name)
    with monkeypatch.context() as patch:
        patch.setattr(maneuver(bench, name), method, lambda *_: {"angel": 1.0})
        bench.steps(1)
        if method == "result":
            bench.trigger("stop")
            bench.steps(1)
    assert sent.status == "aborted"
    assert sent.code in (ErrorCode.UNKNOWN, None)
    assert sent.text is None or "has no field 'angel', only" in sent.text


@pytest.mark.parametrize(
    ("name", "lost"),
    sample(itertools.product(SERVED, ["scan", "odom", "camera", "joint_states"]), every=14),
)
def test_a_sensor_that_falls_silent_ends_the_goals_that_need_it(bench, name, lost):
    """Within five seconds, aborted with a code and a reason, and the robot stands."""
    sent = begun(bench, name)
    bench.robot.silent = {lost}
    if lost not in SERVED[name].watches:
        bench.steps(60)
        assert sent.status is None
        return
    bench.until(lambda: sent.status is not None, limit=130)
    assert sent.status == "aborted"
    if sent.code is not None:
        codes = SERVED[name].action.codes if not SERVED[name].action.part else ()
        assert sent.code in (codes or range(900, 1000))
        assert sent.text != ""
    if SERVED[name].drives:
        assert bench.before_the_last_end == ZERO
    bench.robot.silent = set()
    bench.steps(2)
    assert alive(bench, name)


RAYS = {"empty": [], "nan": [math.nan] * 360, "zero": [0.0] * 250}


@pytest.mark.parametrize(("driving", "rays"), sample(itertools.product(DRIVING, RAYS), every=4))
def test_a_scan_without_a_measurement_is_no_scan(bench, driving, rays):
    """The base stands after a second, or where it navigates, half of one; then the goal ends."""
    sent = begun(bench, driving)
    bench.robot.rays = RAYS[rays]
    bench.steps(22)
    assert bench.commands[-1] == ZERO
    bench.until(lambda: sent.status is not None, limit=60)
    assert sent.status == "aborted"
    assert "no scan " in sent.result.error_msg


def test_one_scan_without_a_measurement_is_passed_over(bench, driving):
    """A lidar that misses a turn stops nobody."""
    sent = begun(bench, driving)
    bench.robot.rays = [math.nan] * 360
    bench.steps(1)
    bench.robot.rays = None
    bench.steps(5)
    assert sent.status is None


@pytest.mark.parametrize(
    "driving", sample([name for name in DRIVING if name != "explore_frontiers"], 3)
)
def test_a_base_that_does_not_follow_ends_what_drives(bench, driving):
    """After two seconds, or where it navigates, ten; exploring goes on to the next frontier."""
    bench.robot.fake.stuck = True
    sent = bench.send(driving)
    bench.until(lambda: sent.status is not None, limit=250)
    assert sent.status == "aborted"
    assert any(words in sent.text for words in ("no progress for 2 s", "has not got away from"))
    assert bench.before_the_last_end == ZERO


@pytest.mark.parametrize(
    "name", sample([name for name in SERVED if "odom" in SERVED[name].watches], 3)
)
def test_odometry_that_jumps_does_not_make_the_robot_run_away(bench, name):
    """A goal measured by odometry ends with the reason; one on the map finds its way again."""
    sent = begun(bench, name)
    bench.robot.fake.changes = {"odom": Pose2D(0.0, -1.5, 2.0)}
    bench.steps(3)
    if "map" in SERVED[name].action.needs:
        assert sent.status is None
    else:
        assert sent.status == "aborted"
        assert "jumped" in sent.result.error_msg
        assert not SERVED[name].drives or bench.before_the_last_end == ZERO


@pytest.mark.parametrize("name", [name for name in SERVED if "camera" in SERVED[name].watches])
def test_a_picture_that_never_comes_ends_the_goal(bench, name):
    """Code 904 with the reason, before the robot moves."""
    bench.robot.silent = {"camera"}
    sent = bench.send(name)
    bench.until(lambda: sent.status is not None, limit=100)
    assert (sent.status, sent.result.error_code) == ("aborted", ErrorCode.NO_IMAGE)
    assert sent.result.error_msg.startswith("no image from the camera ")
    assert not bench.moved


@pytest.mark.parametrize("name", [name for name in SERVED if "camera" in SERVED[name].watches])
def test_the_camera_is_off_after_the_end(bench, name):
    """Pictures are sent only while somebody wants them; two goals do not take them from another."""
    first = bench.send(name)
    second = bench.send("find_colour", client=1)
    bench.steps(10)
    bench.cancel(name, first.id)
    bench.steps(2)
    assert bench.robot.camera.get_subscription_count() == 1
    bench.steps(60)
    assert second.status is None
    bench.cancel("find_colour", second.id)
    bench.steps(2)
    assert bench.robot.camera.get_subscription_count() == 0


@pytest.mark.parametrize("method", ["open", "save"])
@pytest.mark.parametrize("error", [PermissionError(13, "denied"), OSError(28, "No space left")])
def test_pictures_that_cannot_be_stored_end_the_goal(bench, monkeypatch, method, error):
    """An unwritable folder, a full disk: code 905 with the system's reason, the robot stopped."""

    def full(*_: Any) -> None:
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(ImageFolder, method, full)
        sent = bench.send("camera_sweep", goal("camera_sweep", image_count=30))
        bench.until(lambda: sent.status is not None, limit=100)
    assert (sent.status, sent.result.error_code) == ("aborted", ErrorCode.STORAGE)
    assert error.strerror in sent.result.error_msg
    assert bench.commands[-1] == ZERO
    assert alive(bench, "camera_sweep")


def test_stopping_the_servers_ends_the_goal_with_the_robot_stopped(bench, name):
    """And nothing is accepted any more."""
    sent = begun(bench, name)
    bench.servers.stop("the action servers were stopped by SIGTERM")
    bench.clock.run_until_quiet()
    assert sent.status == "aborted"
    assert sent.text in ("the action servers were stopped by SIGTERM", None)
    assert bench.commands[-1] == ZERO
    late = bench.send(name)
    bench.steps(5)
    assert late.accepted is False
    assert bench.commands[-1] == ZERO


@pytest.mark.parametrize("driving", DRIVING)
def test_destroying_the_node_stops_the_robot(bench, driving):
    """Even when nobody waits for a result."""
    begun(bench, driving)
    bench.servers.destroy_node()
    bench.clock.remove_node(bench.servers)
    bench.steps(1)
    assert bench.commands[-1] == ZERO
