"""What every action server keeps to: the stop service, and motors that are off."""

from __future__ import annotations

import math

from action_servers.core.maneuver import ZERO, ErrorCode
from tests.support.served import SERVED


def test_the_stop_service_ends_the_goal_within_the_instant(bench, name):
    """Aborted as stopped, zero velocity first; refused until released; then as usual."""
    sent = bench.send(name)
    bench.steps(20)
    answer = bench.trigger("stop")
    asked_ns = bench.clock.now_ns
    bench.clock.run_until_quiet()
    assert bench.clock.now_ns == asked_ns
    assert answer.result().success is True
    assert sent.status == "aborted"
    assert (sent.code, sent.text) in ((ErrorCode.STOPPED, "stopped"), (None, None))
    assert bench.commands[-1] == ZERO
    robot = bench.robot.fake.robot
    braking_s = robot.max_linear_velocity / robot.max_linear_acceleration
    bench.steps(1 + math.ceil(braking_s * robot.control_rate))
    assert abs(bench.robot.fake.linear) + abs(bench.robot.fake.angular) < 1e-6

    refused = bench.send(name)
    bench.steps(3)
    assert (refused.accepted, bench.commands[-1]) == (False, ZERO)
    assert bench.servers.why_rejected(f"/{name}") == "stopped; call the service release to continue"
    bench.trigger("release")
    following = bench.send(name)
    bench.steps(3)
    assert following.accepted is True


def test_a_second_stop_and_a_second_release_change_nothing(bench):
    """Both succeed; they say what they found. A stop publishes zero each time."""
    reports = []
    for service in ("stop", "stop", "release", "release"):
        answer = bench.trigger(service)
        bench.steps(1)
        reports.append((answer.result().success, answer.result().message))
    assert reports == [
        (True, "stopped; goals are refused until release"),
        (True, "stopped already"),
        (True, "released"),
        (True, "was not stopped"),
    ]
    assert bench.commands == [ZERO, ZERO]


def test_motors_that_go_off_end_what_drives_and_nothing_else(bench, name):
    """Aborted as "motors off"; what drives is refused until they are on again."""
    sent = bench.send(name)
    bench.steps(20)
    bench.set_motors(on=False)
    bench.steps(1)
    drives = SERVED[name].drives
    refused = bench.send(name)
    bench.steps(3)
    if drives:
        assert bench.servers.why_rejected(f"/{name}").startswith("motors off; switch them on with")
        assert (sent.status, sent.result.error_code) == ("aborted", ErrorCode.MOTORS_OFF)
        assert sent.result.error_msg == "motors off"
        assert bench.commands[-1] == ZERO
    elif not SERVED[name].is_alone:
        assert sent.status is None
    assert refused.accepted is not drives
    bench.set_motors(on=True)
    following = bench.send(name)
    bench.steps(3)
    assert following.accepted is True


def test_a_release_does_not_switch_the_motors_on(bench):
    """Two causes, each with its own end."""
    bench.set_motors(on=False)
    bench.steps(1)
    for service in ("stop", "release"):
        bench.trigger(service)
        bench.steps(1)
    refused = bench.send("turn")
    bench.steps(3)
    assert refused.accepted is False
