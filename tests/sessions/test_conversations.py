"""Services and topics in missions, on the stage."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger

from bt_mission.base.errors import BtMissionError

HEAD = "mission: m\nworld: empty_arena\ntree:\n"


def test_a_topic_ends_a_drive(stage: Any) -> None:
    """The wait for odometry beside a goal; the goal is cancelled when the message has come."""
    run = stage.run(
        HEAD + "  parallel:\n"
        "    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}\n"
        "      timeout: 60\n"
        "    - wait_for: {topic: /odom, type: nav_msgs/msg/Odometry,"
        " until: pose.pose.position.x > 0.5}\n"
        "      timeout: 60\n"
        "      outputs: {pose.pose.position.x: x}\n"
        "  succeed_when: any\n"
    )
    run.until_done()
    assert (run.status, run.stage.executive.goals_left_behind) == ("success", ())
    x = run.stage.runner.scope.values["x"]
    assert 0.5 < x < 0.52, "the first message beyond it: 0.2 m/s at 20 Hz"
    assert run.pose[0] == pytest.approx(x, abs=0.06)


def test_a_mission_checks_its_battery(stage: Any) -> None:
    """As the real robot tells it, from 0 to 100."""
    battery = "wait_for: {topic: battery_state, type: sensor_msgs/msg/BatteryState, until: "
    run = stage.run(
        f"{HEAD}  sequence:\n"
        f"    - fallback:\n        - {battery}percentage < 20}}\n          timeout: 0.5\n"
        f"        - {battery}percentage > 20}}\n          timeout: 0.5\n"
        "          outputs: {percentage: charge}\n"
        "    - log: ${round(charge)} %\n"
    )
    run.until_done()
    assert (run.status, run.log) == ("success", ["100 %"])


def test_a_best_effort_topic_is_heard(stage: Any) -> None:
    """As a real lidar publishes its scan."""
    run = stage.run(
        HEAD + "  wait_for: {topic: /scan, type: sensor_msgs/msg/LaserScan,"
        " until: len(ranges) > 100}\n  timeout: 2\n"
    )
    run.until_done()
    assert run.status == "success"


def test_a_latched_topic_that_was_published_at_the_start_is_there_later(stage: Any) -> None:
    """The map; at the tick that reaches the node."""
    run = stage.run(
        HEAD + "  sequence:\n    - wait: 3\n"
        "    - wait_for: {topic: /map, type: nav_msgs/msg/OccupancyGrid, until: info.width > 10}\n"
        "      timeout: 1\n      outputs: {info.width: cells}\n    - log: $cells cells\n"
    )
    run.until_done()
    assert run.status == "success"
    assert run.t == pytest.approx(3.05)
    assert run.log[0].endswith(" cells")


def test_waits_and_calls_repeat_bit_for_bit(stage: Any) -> None:
    """They are served on the virtual clock."""
    hashes = []
    for _ in range(2):
        run = stage.run(
            f"{HEAD}  parallel:\n    - turn: {{angle: 90}}\n      timeout: 30\n"
            "    - wait_for: {topic: /imu, type: sensor_msgs/msg/Imu,"
            " until: angular_velocity.z > 0.3}\n"
            "      timeout: 9\n      outputs: {angular_velocity.z: rate}\n"
        )
        run.until_done()
        assert run.status == "success"
        hashes.append((run.stage.trace.sha256, run.stage.runner.scope.values["rate"]))
    assert hashes[0] == hashes[1]


def test_a_service_of_a_node_on_the_stage_is_called(stage: Any) -> None:
    """The answer is there within the instant of the call, and read at the next tick."""
    run = stage.run(
        HEAD + "  sequence:\n"
        "    - service: {name: /lamp, type: std_srvs/srv/SetBool, request: {data: true}}\n"
        "      outputs: {message: answer}\n"
        "    - log: the lamp is $answer\n"
    )

    def answer(request: Any, response: Any) -> Any:
        response.success, response.message = True, "on" if request.data else "off"
        return response

    run.stage.servers.create_service(SetBool, "/lamp", answer)
    run.until_done()
    assert (run.status, run.log) == ("success", ["the lamp is on"])
    assert run.t == pytest.approx(0.1)


def test_a_service_that_never_answers_holds_nobody_up(stage: Any) -> None:
    """Ticks go on; the answer that comes after the timeout changes nothing."""
    run = stage.run(
        HEAD + "  sequence:\n"
        "    - fallback:\n"
        "        - service: {name: /slow, type: std_srvs/srv/Trigger}\n"
        "          timeout: 1\n"
        "        - log: gave up\n"
        "    - wait: 2\n"
    )
    node = run.stage.servers
    gate: Any = Future()

    async def answer(request: Any, response: Any) -> Any:
        await gate
        response.success = False
        return response

    node.create_service(Trigger, "/slow", answer, callback_group=ReentrantCallbackGroup())
    run.until(lambda s: s.t > 2)
    assert run.log == ["gave up"]
    gate.set_result(None)
    run.until_done()
    assert run.status == "success"


@pytest.mark.parametrize(
    ("node", "words"),
    [
        (
            "wait_for: {topic: /odom, type: std_msgs/msg/Bool, until: data}",
            "/odom is published as nav_msgs/msg/Odometry, not as std_msgs/msg/Bool",
        ),
        (
            "action: {name: /turn, type: bt_mission_interfaces/action/CameraSweep}",
            "/turn is a bt_mission_interfaces/action/Turn, not a bt_mission_interfaces/action/Cam",
        ),
    ],
)
def test_a_name_of_another_type_is_refused_at_the_start(stage: Any, node: str, words: str) -> None:
    """Nothing has moved yet."""
    with pytest.raises(BtMissionError, match=f"<text>:4:3: {words}"):
        stage.run(f"{HEAD}  {node}\n  timeout: 9\n")
