"""The battery: drained by time and by turning wheels, and shown as the real robot shows it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from typing_extensions import override

from bt_mission.robots.model import BatteryModel as BatterySpec
from sim.faults import FaultError
from sim.sensors import topics
from sim.sensors.sensor import Mount, Sensor


class Battery:
    """Charge as a share of the full one, 0 to 1. Voltage falls linearly with it."""

    def __init__(self, spec: BatterySpec) -> None:
        self.spec = spec
        self.charge = spec.start_charge
        self.current = 0.0
        """The mean current since the reading before, A; never negative."""
        self._time_ns: int | None = None

    def use(self, time_ns: int, turned_rad: float) -> None:
        """Account for the time since the last call, in which both wheels turned so far."""
        spec = self.spec
        if self._time_ns is not None and time_ns > self._time_ns:
            elapsed_s = (time_ns - self._time_ns) / 1e9
            joules = spec.idle_power * elapsed_s + spec.drive_energy * turned_rad
            self.current = joules / elapsed_s / spec.nominal_voltage
            full = spec.capacity * 3600 * spec.nominal_voltage
            self.charge = max(0.0, self.charge - joules / full)
        self._time_ns = time_ns

    def charge_to(self, share: float) -> None:
        """Set the charge, 0 to 1. Raises FaultError for an invalid one."""
        if not 0 <= share <= 1:
            raise FaultError(f"expected a charge from 0 to 1, got {share:g}")
        self.charge = share

    @property
    def is_empty(self) -> bool:
        """Whether it is empty."""
        return self.charge <= 0.0

    @property
    def voltage(self) -> float:
        """V, between those of an empty and of a full battery."""
        return self.spec.empty_voltage + self.charge * (
            self.spec.full_voltage - self.spec.empty_voltage
        )

    @property
    def percentage(self) -> float:
        """0 to 100, as a TurtleBot3 reports it: the place of the voltage between empty and full."""
        return 100 * self.charge


class BatterySensor(Sensor):
    """Shows the state of the battery."""

    name = "battery"
    topic = topics.BATTERY_STATE
    message = "sensor_msgs/msg/BatteryState"
    rate = 20.0
    """Hz [turtlebot3_node]."""

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        self.fields = ("voltage", "current", "charge", "percentage")
        self.restart()

    @override
    def restart(self) -> None:
        self.battery = Battery(self.spec)

    @override
    def constants(self) -> Mapping[str, Any]:
        return {
            "design_capacity": self.spec.capacity,
            "temperature": math.nan,  # not measured, as the message has it
            "capacity": math.nan,
            "power_supply_status": 2,  # POWER_SUPPLY_STATUS_DISCHARGING
            "power_supply_technology": 3,  # POWER_SUPPLY_TECHNOLOGY_LIPO
            "present": True,
        }

    @override
    def numbers(self, index: int) -> tuple[float, ...]:
        now = self.battery
        # V, A (below 0: discharging), Ah, and a percentage from 0 to 100.
        return now.voltage, -now.current, now.charge * self.spec.capacity, now.percentage
