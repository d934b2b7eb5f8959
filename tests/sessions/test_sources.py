"""The missions of missions/sources do what docs/reference/sources.md says, by the true pose."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from rclpy.action import get_action_names_and_types

from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.robots.model import load_robot
from bt_mission.sessions.check import examine
from sim.world.loader import load_world
from tests.support.paths import path_length
from tests.support.project import ROOT

FOLDER = ROOT / "missions" / "sources"
NAMES = sorted(path.stem for path in FOLDER.glob("*.yaml"))
WARNINGS = {
    "new_goal_replaces": [
        "two branches of a parallel move the base: the later goal ends the earlier, or both move it"
    ],
    "rejected_goal": [
        (
            "linear_velocity must be from -0.26 to 0.26 m/s, got 0.9: the server of move refuses "
            "that (limit: max_linear_velocity of the robot 'waffle')"
        )
    ],
    "bad_sweep": [
        (
            "sweep_angle must be above 0 and at most 180 deg, got 0: the server of camera_sweep "
            "refuses that (limit: the Sheffield course's camera sweep)"
        ),
        (
            "image_count must be from 1 to 30 images, got 0: the server of camera_sweep refuses "
            "that (limit: parameter sweep_images of the servers)"
        ),
    ],
}
"""What is said of those whose point it is."""


@pytest.mark.parametrize("name", NAMES)
def test_each_is_sound(name: str) -> None:
    """No error, and no warning but the one that is the point of its mission."""
    mission, faults = examine(FOLDER / f"{name}.yaml")
    assert mission is not None
    assert (mission.name, bool(mission.world), bool(mission.description)) == (name, True, True)
    assert [fault.message for fault in faults] == WARNINGS.get(name, [])


@pytest.fixture
def ran(stage: Any) -> Any:
    """Run one to its end; it succeeds, touches nothing, and leaves no goal behind.

    Its lines are compared where they are given.
    """

    def run(name: str, *log: str) -> Any:
        played = stage.run(FOLDER / f"{name}.yaml")
        played.until_done()
        assert (played.status, played.reason) == ("success", "")
        assert played.stage.runs[0].collisions == 0
        assert played.stage.executive.goals_left_behind == ()
        assert not log or tuple(played.log) == log
        return played

    return run


def test_names_and_types_are_in_the_graph(tmp_path: Path, context: Any) -> None:
    """What the command line of ROS 2 lists: every action that missions have a short name for."""
    servers = ServersNode(
        load_robot("waffle"), ServerOptions(image_folder=tmp_path, lean=True, context=context)
    )
    served = dict(get_action_names_and_types(servers))
    services = dict(servers.get_service_names_and_types())
    servers.destroy_node()
    names = {f"/{short.name}": [short.type] for short in ACTION_NAMES.values()}
    del names["/execute_mission"]  # it is the executive that serves this one
    assert names.items() <= served.items()
    assert services["/stop"] == services["/release"] == ["std_srvs/srv/Trigger"]


def message(run: Any, node: str, status: str) -> str:
    """What a node said at its last change to a status."""
    events = [e for e in run.events("status") if (e["node"], e["status"]) == (node, status)]
    return str(events[-1]["message"])


def test_move_for_seconds(ran: Any) -> None:
    """Five seconds at 0.1 m/s, and the status has the real numbers."""
    run = ran("move_for_seconds")
    assert run.stage.runs[0].distance_travelled_m == pytest.approx(0.5, abs=0.02)
    assert run.t == pytest.approx(5.2, abs=0.2)
    assert run.log == ["drove for 5.00 of 5 s, 0.50 m"]


def test_rejected_goal(ran: Any) -> None:
    """The client does not wait for a result that will never come."""
    run = ran("rejected_goal", "too fast was refused")
    assert message(run, "too fast", "FAILURE").startswith("rejected: ")
    assert run.t < 0.5
    assert run.stage.runs[0].distance_travelled_m < 0.001


def test_record_distance(ran: Any) -> None:
    """The distance is that of the true path."""
    run = ran("record_distance")
    (log,) = run.log
    assert float(log.split()[0]) == pytest.approx(run.stage.runs[0].distance_travelled_m, abs=0.1)
    assert run.t == pytest.approx(20.2, abs=0.3)


def test_five_pictures(ran: Any, tmp_path: Any) -> None:
    """The result of the cancelled goal names the five files that are there."""
    ran("five_pictures", "5 pictures")
    assert len(list(tmp_path.glob("run_001/*/*.png"))) == 5


def test_bad_sweep(ran: Any, tmp_path: Any) -> None:
    """No folder is made for it."""
    ran("bad_sweep", "a sweep of nothing was refused")
    assert [path for path in tmp_path.iterdir() if path.is_dir()] == []


@pytest.mark.thorough
def test_two_metres(ran: Any) -> None:
    """No goal drives further than 2 m, one control step and the way to stop."""
    run = ran("two_metres")
    forward = [e for e in run.events("status") if e["node"] == "forward"]
    legs = [
        path_length(run, start["t"], end["t"])
        for start, end in zip(forward[::2], forward[1::2], strict=True)
    ]
    assert len(legs) == 4
    assert max(legs) <= 2.0 + 0.2 * 0.05 + 0.2**2 / 2
    assert all(output.count(" m") == 2 for output in run.log)


@pytest.mark.thorough
def test_informed_turn(ran: Any) -> None:
    """Each turn is away from the object that ended the drive before it."""
    run = ran("informed_turn")
    angles = [int(output.split(", ")[-1].split()[0]) for output in run.log]
    turns = [e for e in run.events("status") if e["node"] == "away"]
    poses = {p["t"]: p["yaw"] for p in run.events("pose")}
    for angle, start, end in zip(angles, turns[::2], turns[1::2], strict=True):
        turned = math.remainder(poses[end["t"]] - poses[start["t"]], 2 * math.pi)
        assert math.degrees(abs(turned)) == pytest.approx(90, abs=6)
        assert angle == 0 or (turned < 0) == (angle > 0)


def test_meanwhile(ran: Any) -> None:
    """A line each second, until the turn has ended."""
    run = ran("meanwhile", "1 x 7 = 7", "2 x 7 = 14", "3 x 7 = 21")
    assert math.degrees(run.pose[2]) == pytest.approx(180, abs=5) or math.degrees(
        run.pose[2]
    ) == pytest.approx(-180, abs=5)


def test_timed_cancel(ran: Any) -> None:
    """Three seconds after it was accepted; the next goal finds the base free."""
    run = ran("timed_cancel", "cancelled after 3 s")
    assert message(run, "too slow", "FAILURE") == "canceled by timeout: not done within 3 s"
    log = next(e for e in run.events("log"))
    assert log["t"] / 1e9 == pytest.approx(4.2, abs=0.2)


def test_pictures_while_moving(ran: Any) -> None:
    """The robot drives for as long as pictures are taken, and stands after the last."""
    run = ran("pictures_while_moving", "5 pictures")
    assert run.t == pytest.approx(5.3, abs=0.4)
    assert run.stage.runs[0].distance_travelled_m == pytest.approx(0.05 * 5, abs=0.03)


@pytest.mark.thorough
def test_waypoint_tour(ran: Any) -> None:
    """Within 0.25 m of each marker when it is said to be there."""
    run = ran("waypoint_tour")
    poses = {p["t"]: (p["x"], p["y"]) for p in run.events("pose")}
    logs = run.events("log")
    for zone, log in zip(load_world("nav_arena").zones, logs, strict=True):
        assert log["text"] == f"at {zone.name}"
        assert math.dist(poses[log["t"]], (zone.x, zone.y)) < 0.25


def test_motor_power(ran: Any) -> None:
    """The one turn is made with the motors on."""
    run = ran("motor_power")
    assert "no turn without power" in run.log
    assert math.degrees(run.pose[2]) == pytest.approx(90, abs=3)


def test_stop_service(ran: Any) -> None:
    """The drive ends at 2 s with the reason, and the robot stands within 0.3 s of the call."""
    run = ran("stop_service", "the drive was stopped", "no goal while stopped")
    assert "stopped" in message(run, "move", "FAILURE")
    called = next(e["t"] for e in run.events("status") if e["node"] == "stop")
    after = path_length(run, called + 300_000_000, called + 600_000_000)
    assert path_length(run, 1_000_000_000, called) == pytest.approx(0.4, abs=0.05)
    assert after < 0.005
    assert math.degrees(run.pose[2]) == pytest.approx(90, abs=3)


def test_new_goal_replaces(ran: Any) -> None:
    """The old goal ends aborted when the new one begins, and never comes back."""
    run = ran("new_goal_replaces", "the old goal was replaced", "the new goal is done")
    assert message(run, "old", "FAILURE").startswith("aborted: /move: replaced by a new")
    assert math.degrees(run.pose[2]) == pytest.approx(90, abs=3)
    assert run.stage.runs[0].distance_travelled_m == pytest.approx(0.4, abs=0.06)


def test_no_server(ran: Any) -> None:
    """Each is named after its limit."""
    run = ran("no_server", "no such action", "no such service")
    assert message(run, "camera_sweap", "FAILURE").endswith("/camera_sweap: no server after 2 s")
    assert run.t == pytest.approx(3.05)


def test_recoveries(ran: Any) -> None:
    """The wall is told of by Nav2's code, and the robot faces away from it in the end."""
    run = ran("recoveries")
    assert run.log[0] == "blocked, code 723"
    assert run.log[1].startswith("backed up for 3 s") or run.log[1] == "backed up for 4 s"
    assert abs(math.degrees(run.pose[2])) == pytest.approx(180, abs=8)


def test_drive_until_blue(ran: Any) -> None:
    """It ends in front of the blue pillar."""
    run = ran("drive_until_blue")
    pillar = next(
        cylinder
        for cylinder in load_world("coloured_pillars").cylinders
        if cylinder.colour == "blue"
    )
    x, y, _ = run.pose
    assert math.dist((x, y), (pillar.x, pillar.y)) < 0.3 + pillar.radius + 0.069 + 0.1
