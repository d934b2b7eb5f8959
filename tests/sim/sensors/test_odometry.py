"""What is reckoned from the wheels: pose and velocity, with slip and wrong figures, and charge."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_mission.robots.model import BatteryModel as Spec
from bt_mission.robots.model import load_robot
from sim.sensors.battery import Battery
from sim.sensors.odometry import Encoders, Odometry, wrapped

WAFFLE = load_robot("waffle")
RADIUS, SEPARATION = 0.033, 0.287
HALF_TURN, QUARTER = math.pi * SEPARATION / 2 / RADIUS, math.pi / 2
S = 1_000_000_000


@pytest.mark.parametrize(
    ("start", "turned", "pose", "velocity"),
    [
        ((12.0, -7.0), (0.0, 0.0), (0, 0, 0), (0, 0)),
        ((0.0, 0.0), (10.0, 10.0), (0.33, 0, 0), (0.165, 0)),
        ((0.0, 0.0), (-HALF_TURN, HALF_TURN), (0, 0, math.pi), (0, math.pi / 2)),
        (
            (5.0, 9.0),
            (QUARTER * (1 - SEPARATION / 2) / RADIUS, QUARTER * (1 + SEPARATION / 2) / RADIUS),
            (1, 1, QUARTER),
            (QUARTER / 2, QUARTER / 2),
        ),
    ],
    ids=["at the start", "straight on", "on the spot", "an arc of 1 m"],
)
def test_one_reading_after_2_s_gives_pose_and_velocity(start, turned, pose, velocity):
    """Exactly, wherever the wheels stood at first; a reading of the same instant counts once."""
    odometry = Odometry(WAFFLE)
    left, right = start
    odometry.read(left, right, S)
    for _ in range(2):
        odometry.read(left + turned[0], right + turned[1], 3 * S)
        assert (odometry.x, odometry.y) == pytest.approx(pose[:2])
        assert abs(odometry.yaw) == pytest.approx(pose[2])
        assert (odometry.linear, odometry.angular) == pytest.approx(velocity)


@given(st.floats(-100, 100))
def test_wrapped_angles_lie_within_half_a_turn(angle):
    """The direction stays the same."""
    assert -math.pi < wrapped(angle) <= math.pi + 1e-12
    assert math.cos(wrapped(angle)) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped(angle)) == pytest.approx(math.sin(angle), abs=1e-9)


def test_wheels_taken_for_larger_make_odometry_run_ahead(equipped, drive):
    """1 % too large, 1 % too far."""
    simulation = equipped(odometry={"wheel_radius_error": 0.01})
    drive(simulation, 5.0, linear=0.2)
    drive(simulation, 0.5)
    assert simulation.odometry.x == pytest.approx(1.01 * simulation.pose[0], rel=1e-3)


def test_wheels_taken_to_be_farther_apart_make_it_turn_less(equipped, drive):
    """10 % farther apart, 1.1 times less turned."""
    simulation = equipped(odometry={"wheel_separation_error": 0.1})
    drive(simulation, 2.0, angular=1.0)
    true = simulation.pose[2] * 0.288 / 0.287
    assert simulation.odometry.yaw == pytest.approx(true / 1.1, rel=0.01)


def test_slip_makes_odometry_and_joints_run_ahead(equipped, drive):
    """5 % in the mean; the seed decides how much each time; the truth is as without."""
    first, second = (equipped(seed=seed, odometry={"slip": 0.05}) for seed in (1, 2))
    for simulation in (first, second):
        drive(simulation, 5.0, linear=0.2)
    assert first.odometry.x == pytest.approx(1.05 * first.pose[0], rel=0.01)
    assert first.wheels[0][0] * 0.033 == pytest.approx(1.05 * first.pose[0], rel=0.02)
    assert first.pose == second.pose
    assert first.odometry.y != second.odometry.y


def test_encoders_count_from_the_start_and_slip_otherwise_at_each_wheel():
    """Without slip they show what is; with 5 %, over a thousand readings, 5 % more."""
    encoders = Encoders(0.0, seed=1)
    encoders.start(2.0, -3.0)
    assert encoders.angles(2.5, -3.0) == (0.5, 0.0)
    encoders = Encoders(0.05, seed=1)
    for index in range(1, 1001):
        encoders.read(0.1 * index, 0.1 * index)
    left, right = encoders.angles(100.0, 100.0)
    assert (left, right) == pytest.approx((105, 105), abs=0.5)
    assert left != right


# ---- the battery -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("charge", "voltage", "percentage"), [(1.0, 12.3, 100.0), (0.5, 11.4, 50.0), (0.0, 10.5, 0.0)]
)
def test_a_battery_shows_voltage_and_percentage_as_the_firmware_does(charge, voltage, percentage):
    """12.3 V when it is full, 10.5 V when it is empty."""
    battery = Battery(Spec(start_charge=charge))
    assert battery.voltage == pytest.approx(voltage)
    assert (battery.percentage, battery.is_empty) == (percentage, not charge)


def test_standing_empties_a_battery_in_2_9_hours_and_driving_in_two():
    """1.8 Ah at 11.1 V: 7 W, and 3 W of motors at full speed. Time that stands takes nothing."""
    standing, driving = Battery(WAFFLE.battery), Battery(WAFFLE.battery)
    # Of both wheels, whatever their directions.
    turned = Encoders(0.0, seed=1).read(*(s * WAFFLE.max_linear_velocity / RADIUS for s in (1, -1)))
    for battery, radians in ((standing, 0.0), (driving, turned * 3600)):
        battery.use(0, 0.0)
        battery.use(0, 5.0)
        assert battery.charge == 1.0
        battery.use(3600 * S, radians)
    assert 1 / (1 - standing.charge) == pytest.approx(2.85, abs=0.01)
    assert 1 / (1 - driving.charge) == pytest.approx(2.0, abs=0.01)
    assert driving.current == pytest.approx(10 / 11.1, abs=0.01)
    driving.use(10_000 * 3600 * S, 0.0)
    assert (driving.charge, driving.voltage, driving.is_empty) == (0.0, 10.5, True)
