"""The battery: what drains it, and what it shows."""

import pytest

from bt_mission.core.robot.model import BatteryModel as Spec
from bt_mission.core.robot.model import load_robot
from sim.sensors.battery import Battery

S = 1_000_000_000


def test_a_full_one_shows_12_3_volts_and_an_empty_one_10_5():
    """And 100 and 0 percent, as the firmware reckons."""
    full, half, empty = (Battery(Spec(start_charge=charge)) for charge in (1.0, 0.5, 0.0))
    assert [b.voltage for b in (full, half, empty)] == pytest.approx([12.3, 11.4, 10.5])
    assert [b.percentage for b in (full, half, empty)] == [100.0, 50.0, 0.0]
    assert [b.is_empty for b in (full, half, empty)] == [False, False, True]


def test_standing_empties_it_in_2_9_hours_and_driving_in_two():
    """1.8 Ah at 11.1 V: 7 W of electronics, and 3 W of motors at a Waffle's full speed."""
    robot = load_robot("waffle")
    standing, driving = Battery(robot.battery), Battery(robot.battery)
    turned = 2 * robot.max_linear_velocity / robot.drive.wheel_radius * 3600
    for battery, radians in ((standing, 0.0), (driving, turned)):
        battery.use(0, 0.0)
        battery.use(3600 * S, radians)
    assert 1 / (1 - standing.charge) == pytest.approx(2.85, abs=0.01)
    assert 1 / (1 - driving.charge) == pytest.approx(2.0, abs=0.01)
    assert driving.current == pytest.approx(10 / 11.1, abs=0.01)


def test_it_never_holds_less_than_nothing():
    """Nor shows less."""
    battery = Battery(Spec(start_charge=0.01))
    battery.use(0, 0.0)
    battery.use(10_000 * S, 0.0)
    assert (battery.charge, battery.voltage, battery.is_empty) == (0.0, 10.5, True)


def test_an_instant_counts_once():
    """Time that does not pass takes nothing."""
    battery = Battery(Spec())
    battery.use(1 * S, 0.0)
    battery.use(1 * S, 5.0)
    assert battery.charge == 1.0
