"""The simulated TurtleBot3 as a ROS node: commands in, sensors out, on a virtual clock.

`SimNode` is moved from outside, by `advance_to`; `sim.ros.live` does that in its own process.
Topics, types, QoS and frames are those of a TurtleBot3 on Jazzy; names are relative, so that a
namespace applies.

A world in messages: its map, and its zones as markers for RViz and Foxglove.
"""

from __future__ import annotations

import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from nav_msgs.msg import OccupancyGrid
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker, MarkerArray

from bt_mission.base.parameters import ParameterSpec
from bt_mission.base.stamps import set_ns
from bt_mission.ros.executors.process import RobotNode, RobotNodeOptions
from sim import frames
from sim.physics.names import STEP_NS
from sim.physics.simulator import SimulatorFactory
from sim.physics.spawn import RobotSpawn
from sim.ros.schedule import Schedule
from sim.ros.sensor_topics import LATCHED, RELIABLE, publish_sensor
from sim.ros.topics import (
    COMMAND_TYPES,
    REQUESTS,
    CommandType,
    RobotPublishers,
    header,
    localise,
)
from sim.simulation import Simulation
from sim.world.loader import unseen
from sim.world.occupancy import OccupancyMap, rasterise
from sim.world.shapes import rgba
from sim.world.world import World, Zone

_PLACE = 0.1
"""m: the radius of the disc of a place."""

_TEXT = 0.15
"""m: how high a zone's name is written."""


def occupancy_grid(drawn: OccupancyMap, stamp: Any) -> OccupancyGrid:
    """Return the map of a world."""
    grid = header(OccupancyGrid(), stamp, frames.MAP)
    grid.info.map_load_time = stamp
    grid.info.resolution = drawn.resolution
    grid.info.height, grid.info.width = drawn.cells.shape
    grid.info.origin.position.x, grid.info.origin.position.y = drawn.origin
    grid.data = array.array("b", drawn.cells.tobytes())
    return grid


def zone_markers(
    world: World, stamp: Any, places: Mapping[str, tuple[float, float]] | None = None
) -> MarkerArray:
    """Return a disc and a name for each zone and place, which stay until they are replaced.

    Places are not part of a world: the camera does not see them.
    """
    named = (places or {}).items()
    marks = [
        Zone.model_construct(name=name, x=x, y=y, radius=_PLACE, colour="white")
        for name, (x, y) in named
    ]
    markers = []
    for index, zone in enumerate((*world.zones, *marks)):
        disc = _marker(zone, stamp, "zones", index, Marker.CYLINDER)
        disc.scale.x = disc.scale.y = 2 * zone.radius
        disc.scale.z = 0.002
        disc.color.r, disc.color.g, disc.color.b, _ = rgba(zone.colour)
        disc.color.a = 0.6
        name = _marker(zone, stamp, "zone names", index, Marker.TEXT_VIEW_FACING)
        name.text = zone.name
        name.pose.position.z = _TEXT
        name.scale.z = _TEXT
        name.color.r = name.color.g = name.color.b = name.color.a = 1.0
        markers += [disc, name]
    return MarkerArray(markers=markers)


def _marker(zone: Zone, stamp: Any, namespace: str, index: int, kind: int) -> Marker:
    marker = header(Marker(ns=namespace, id=index, type=kind), stamp, frames.MAP)
    marker.pose.position.x, marker.pose.position.y = zone.x, zone.y
    return marker


NODE_NAME = "bt_mission_sim"


@dataclass(frozen=True, slots=True, kw_only=True)
class SimOptions(RobotNodeOptions):
    """The options of the simulator's node.

    Args:
        seed: The seed of all sensor noise.
        start_ns: The first instant, ns.
        camera: Whether there are cameras.
        with_map: Whether the map of the world is published.
        localises: Whether `tf` has the pose of `odom` on the map; else another node has to provide
            it.
        command_type: Of `cmd_vel`: `TwistStamped` (stamped) or `Twist` (plain).
        props: The number of obstacles that can be placed later (`sim.physics.props`).
        simulator: Makes what moves the robot in place of MuJoCo.
        places: Named points of the map, m, that are published beside the zones.
    """

    seed: int
    start_ns: int = 1_000_000_000
    camera: bool = True
    with_map: bool = True
    localises: bool = True
    command_type: CommandType = "stamped"
    props: int = 0
    simulator: SimulatorFactory | None = None
    places: Mapping[str, tuple[float, float]] = field(default_factory=dict)


class SimNode(RobotNode):
    """One robot in one world, or several. Messages are sent only where somebody subscribes.

    The topics of a robot without a name, which is alone, are the node's own (`scan`). Those of a
    robot with a name begin with it (`robot1/scan`): each has a `robot1/map`, `robot1/tf` with the
    same frames as a robot alone, and so on. There is one `/clock`.

    Raises SpawnError, RobotSpawnError, RateError, PropError, and rclpy's ParameterException for a
    parameter that does not suit.
    """

    def __init__(self, world: World, robots: Sequence[RobotSpawn], options: SimOptions) -> None:
        self.simulation = Simulation(
            world,
            robots,
            seed=options.seed,
            start_ns=options.start_ns,
            props=options.props,
            simulator=options.simulator,
        )
        self.robots, self.physics = self.simulation.robots, self.simulation.physics
        lean = options.lean
        super().__init__(NODE_NAME, options)
        self.command_type = self._declare_command_type(options)
        self._schedule = Schedule(options.start_ns)
        self._time = Clock()
        self._stamp = self._time.clock  # shared by all messages
        self._time_out = self.create_publisher(Clock, "/clock", RELIABLE)
        drawn = rasterise(world) if options.with_map else None
        self._topics: list[RobotPublishers] = []
        for robot in self.robots:
            if drawn is not None:
                self._latch(occupancy_grid(drawn, self._stamp), f"{robot.prefix}map")
            if world.zones or options.places:
                marks = zone_markers(world, self._stamp, options.places)
                self._latch(marks, f"{robot.prefix}zones")
            self._topics.append(
                RobotPublishers(
                    self,
                    self._schedule,
                    self._stamp,
                    robot,
                    command_type=self.command_type,
                    localises=options.localises,
                )
            )
            if options.localises and not lean:
                localise(self, self._schedule, self._stamp, robot)
            for sensor in robot.sensors:
                if options.camera or not sensor.is_camera:
                    publish_sensor(self, self._schedule, self._stamp, robot, sensor)
            for warning in unseen(world, robot.robot):
                self._log.warning(warning)
        self.create_service(Trigger, "reset_simulation", self._on_reset, qos_profile=REQUESTS)

    # ---- time ----------------------------------------------------------------------------

    @property
    def next_due_ns(self) -> int:
        """The next instant at which something is published, ns."""
        return self._schedule.next_due_ns

    def advance_to(self, time_ns: int) -> None:
        """Step the physics up to `time_ns`, and publish what is due at or before it.

        Physics moves in whole steps of 5 ms, so it stops at the last one that is not after
        `time_ns`. Raises ValueError where that time is past.
        """
        physics, schedule = self.physics, self._schedule
        while schedule.next_due_ns <= time_ns:
            physics.advance_to(schedule.next_due_ns)
            self.publish_clock()
            schedule.run(physics.time_ns)
        physics.advance_to(time_ns - (time_ns - physics.time_ns) % STEP_NS)

    def publish_clock_at(self, rate_hz: float) -> None:
        """Publish /clock at this rate, too, and not only when a sensor is due."""
        self._schedule.every(rate_hz, "clock", lambda _: None)

    @property
    def time_ns(self) -> int:
        """The present instant of the physics, ns; it never goes back."""
        return self.physics.time_ns

    @property
    def clock_ns(self) -> int:
        """The present time on `/clock`, ns: since the start, or since it was set back."""
        return self._schedule.clock_ns(self.physics.time_ns)

    def publish_clock(self) -> None:
        """Publish the time, if there are subscriptions."""
        set_ns(self._stamp, self._schedule.clock_ns(self.physics.time_ns))
        if self._time_out.get_subscription_count():
            self._time_out.publish(self._time)

    def set_clock_back(self) -> None:
        """Restart `/clock` at the first instant, at once. Nothing else changes."""
        self._schedule.set_clock_back(self.physics.time_ns)
        self.publish_clock()

    def reset(self, *, keep_props: bool = False) -> list[str]:
        """Restore the state at the start, random streams too. Time continues.

        All sensors are due at once, so the following equals what followed the start. Returns the
        names of kept props whose place is occupied.
        """
        removed = self.physics.reset(keep_props=keep_props)
        self._schedule.restart(self.physics.time_ns)
        for topics in self._topics:
            topics.restart()
        return removed

    def _on_reset(self, _: Any, response: Any) -> Any:
        self.reset()
        response.success, response.message = True, "everything is as it was at the start"
        return response

    def _declare_command_type(self, options: SimOptions) -> CommandType:
        """Declare the parameter `cmd_vel_type`; the stage, without parameters, uses the option."""
        if options.lean:
            return options.command_type
        description = "Type of cmd_vel: TwistStamped (stamped) or Twist (plain)."
        spec = ParameterSpec(options.command_type, description, choices=tuple(COMMAND_TYPES))
        chosen: CommandType = self.declare("cmd_vel_type", spec)
        return chosen

    def _latch(self, message: Any, topic: str) -> None:
        """Publish a message once, at the start."""
        publisher = self.create_publisher(type(message), topic, LATCHED)
        self._schedule.once(lambda _: publisher.publish(message))

    def destroy_node(self) -> None:
        """Give back the renderers with the node."""
        for robot in self.robots:
            for sensor in robot.sensors:
                sensor.close()
        super().destroy_node()
