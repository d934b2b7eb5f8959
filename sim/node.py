"""The simulated TurtleBot3 as a ROS node: commands in, sensors out, on a virtual clock.

`SimNode` is moved from outside, by `advance_to`. `main` does that in a process of its own, paced
against the wall. Topics, types, QoS and frames are those of a TurtleBot3 on Jazzy; names are
relative, so that a namespace applies.
"""

from __future__ import annotations

import array
import signal
from collections.abc import Sequence
from typing import Any

import rclpy
from bt_mission_interfaces.msg import Collision as CollisionMessage
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.clock import Clock as RosClock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan
from tf2_msgs.msg import TFMessage

from bt_mission.common.robot import Camera as CameraSpec
from bt_mission.common.robot import RobotModel, load_robot
from sim import fill, frames
from sim.camera import Camera, NoCameraError
from sim.names import STEP_NS
from sim.occupancy import OccupancyMap, rasterise
from sim.pacing import FASTEST, SLOWEST, Pacer, check_speed
from sim.raycast import RaycastCamera
from sim.schedule import Schedule
from sim.simulation import Simulation
from sim.world import World, load_world

NODE_NAME = "bt_mission_sim"

RELIABLE = QoSProfile(depth=10)
SENSOR_DATA = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TRANSFORMS = QoSProfile(depth=100)  # what tf2's listeners and broadcasters use

LIVE_CLOCK_HZ = 100.0
_LIVE_TICK_S = 0.01


class SimNode(Node):
    """One robot in one world. Messages are sent only where somebody subscribes to them.

    `lean` leaves out parameter services, /rosout and all log lines below warnings, `camera=False`
    the camera. Raises SpawnError and RateError.
    """

    def __init__(
        self,
        world: World,
        robot: RobotModel,
        *,
        seed: int,
        start_ns: int = 1_000_000_000,
        lean: bool = False,
        context: Context | None = None,
        namespace: str | None = None,
        camera: bool = True,
    ) -> None:
        self.simulation = Simulation(world, robot, seed=seed, start_ns=start_ns)
        super().__init__(
            NODE_NAME,
            context=context,
            namespace=namespace,
            start_parameter_services=not lean,
            enable_rosout=not lean,
            parameter_overrides=[Parameter("start_type_description_service", value=not lean)],
        )
        if lean:
            _log(self).set_level(LoggingSeverity.WARN)
        self._schedule = Schedule(start_ns)
        self._time = Clock()
        self._stamp = self._time.clock  # shared by all messages
        self._time_out = self.create_publisher(Clock, "clock", RELIABLE)
        self._camera: Camera | RaycastCamera | None = None
        self._make_map(rasterise(world))
        self._make_collisions()
        self._make_base(robot)
        self._make_imu(robot)
        self._make_lidar(robot)
        if camera and robot.camera is not None:
            self._make_camera(robot.camera)
        self.create_subscription(TwistStamped, "cmd_vel", self._on_command, RELIABLE)

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
        simulation, schedule = self.simulation, self._schedule
        while schedule.next_due_ns <= time_ns:
            simulation.advance_to(schedule.next_due_ns)
            fill.time(self._stamp, simulation.time_ns)
            if _wanted(self._time_out):
                self._time_out.publish(self._time)
            schedule.run(simulation.time_ns)
        simulation.advance_to(time_ns - (time_ns - simulation.time_ns) % STEP_NS)

    def publish_clock_at(self, rate_hz: float) -> None:
        """Publish /clock at this rate, too, and not only when a sensor is due."""
        self._schedule.every(rate_hz, "clock", lambda _: None)

    # ---- commands ------------------------------------------------------------------------

    def _on_command(self, message: Any) -> None:
        twist = message.twist
        try:
            self.simulation.command(twist.linear.x, twist.angular.z)
        except ValueError as error:
            _log(self).warning(f"cmd_vel refused: {error}", throttle_duration_sec=5.0)

    # ---- map and fixed frames, once ------------------------------------------------------

    def _make_map(self, drawn: OccupancyMap) -> None:
        grid, tree = OccupancyGrid(), TFMessage()
        fill.header(grid, self._stamp, frames.MAP)
        grid.info.map_load_time = self._stamp
        grid.info.resolution = drawn.resolution
        grid.info.height, grid.info.width = drawn.cells.shape
        grid.info.origin.position.x, grid.info.origin.position.y = drawn.origin
        grid.data = array.array("b", drawn.cells.tobytes())
        tree.transforms = [
            fill.transform(TransformStamped(), frame, self._stamp)
            for frame in frames.fixed_frames(self.simulation.robot)
        ]
        maps = self.create_publisher(OccupancyGrid, "map", LATCHED)
        trees = self.create_publisher(TFMessage, "tf_static", LATCHED)

        def publish(_: int) -> None:
            maps.publish(grid)
            trees.publish(tree)

        self._schedule.once(publish)

    # ---- sensors: each makes its message once, and refills it when it is due --------------

    def _make_collisions(self) -> None:
        publisher = self.create_publisher(CollisionMessage, "collisions", RELIABLE)

        def publish(_: int) -> None:
            for collision in self.simulation.take_collisions():
                _log(self).info(f"collision with {collision.obstacle}")
                publisher.publish(fill.collision(CollisionMessage(), collision))

        self._schedule.every(self.simulation.robot.odometry_rate, "odometry_rate", publish)

    def _make_base(self, robot: RobotModel) -> None:
        """Wheels, odometry, moving frames and true pose, all of one instant."""
        wheels = fill.header(JointState(name=list(frames.WHEEL_JOINTS)), self._stamp, "")
        wheels.position, wheels.velocity = array.array("d", (0, 0)), array.array("d", (0, 0))
        odometry = fill.header(OdometryMessage(), self._stamp, frames.ODOM, frames.BASE_FOOTPRINT)
        truth = fill.header(OdometryMessage(), self._stamp, frames.MAP, frames.BASE_FOOTPRINT)
        to_base = fill.header(TransformStamped(), self._stamp, frames.ODOM, frames.BASE_FOOTPRINT)
        to_odom = fill.header(TransformStamped(), self._stamp, frames.MAP, frames.ODOM)
        moving = TFMessage(transforms=[to_odom, to_base])
        wheels_out = self.create_publisher(JointState, "joint_states", RELIABLE)
        odometry_out = self.create_publisher(OdometryMessage, "odom", RELIABLE)
        moving_out = self.create_publisher(TFMessage, "tf", TRANSFORMS)
        truth_out = self.create_publisher(OdometryMessage, "ground_truth/odom", RELIABLE)
        simulation = self.simulation

        def publish(_: int) -> None:
            reading = simulation.read_odometry()
            if _wanted(wheels_out):
                fill.joints(wheels, *simulation.wheels)
                wheels_out.publish(wheels)
            if _wanted(odometry_out):
                fill.odometry(odometry, reading)
                odometry_out.publish(odometry)
            if _wanted(moving_out):
                here = (reading.x, reading.y, reading.yaw)
                fill.planar_transform(to_base, *here)
                fill.planar_transform(to_odom, *frames.map_to_odom(simulation.pose, here))
                moving_out.publish(moving)
            if _wanted(truth_out):
                fill.truth(truth, simulation.pose, simulation.velocity)
                truth_out.publish(truth)

        self._schedule.every(robot.odometry_rate, "odometry_rate", publish)

    def _make_imu(self, robot: RobotModel) -> None:
        message = fill.header(Imu(), self._stamp, frames.IMU_LINK)
        fill.inertial_limits(message, robot.imu)
        publisher = self.create_publisher(Imu, "imu", RELIABLE)

        def publish(index: int) -> None:
            if _wanted(publisher):
                fill.inertial(message, self.simulation.inertial(index))
                publisher.publish(message)

        self._schedule.every(robot.imu.rate, "imu.rate", publish)

    def _make_lidar(self, robot: RobotModel) -> None:
        message = fill.header(LaserScan(), self._stamp, frames.SCAN_FRAME)
        ranges = fill.scan_limits(message, robot.lidar)
        publisher = self.create_publisher(LaserScan, "scan", SENSOR_DATA)

        def publish(index: int) -> None:
            if _wanted(publisher):
                self.simulation.scan(index, ranges)
                publisher.publish(message)

        self._schedule.every(robot.lidar.rate, "lidar.rate", publish)

    def _make_camera(self, spec: CameraSpec) -> None:
        """Pictures are drawn only while somebody wants them: they cost more than all the rest."""
        message, info = fill.header(Image(), self._stamp, frames.CAMERA_FRAME), CameraInfo()
        pixels = fill.image_format(message, spec)
        fill.camera_info(fill.header(info, self._stamp, frames.CAMERA_FRAME), spec)
        images = self.create_publisher(Image, "camera/image_raw", RELIABLE)
        infos = self.create_publisher(CameraInfo, "camera/camera_info", RELIABLE)
        simulation = self.simulation

        def publish(_: int) -> None:
            if _wanted(infos):
                infos.publish(info)
            if _wanted(images):
                self._camera = self._camera or self._open_camera(spec)
                self._camera.draw(simulation.data, pixels)
                images.publish(message)

        self._schedule.every(spec.rate, "camera.rate", publish)

    def _open_camera(self, spec: CameraSpec) -> Camera | RaycastCamera:
        try:
            return Camera(self.simulation.model, spec)
        except NoCameraError as error:
            _log(self).warning(f"{error}; until then pictures are drawn ray by ray, more slowly")
            return RaycastCamera(self.simulation.model, spec)

    def destroy_node(self) -> None:
        """Give back the renderer with the node."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None
        Node.destroy_node(self)


def _wanted(publisher: Publisher) -> bool:
    return publisher.get_subscription_count() > 0


def _log(node: Node) -> Any:
    return node.get_logger()


# ---- in a process of its own -----------------------------------------------------------------


def main(
    *,
    world: str,
    robot: str,
    seed: int = 0,
    speed: float = 1.0,
    namespace: str = "",
    camera: bool = True,
    ros_args: Sequence[str] = (),
) -> int:
    """Run the simulator until SIGINT or SIGTERM, `speed` times as fast as the wall clock.

    `world` and `robot` are names or paths, `ros_args` what follows `--ros-args`. Returns the exit
    code 0. Raises BtMissionError for a world, a robot or a speed that cannot be used.
    """
    check_speed(speed)
    model, scene = load_robot(robot), load_world(world)
    # With handlers of our own: rclpy's would pull the context from under the callback that runs.
    rclpy.init(args=["--ros-args", *ros_args], signal_handler_options=SignalHandlerOptions.NO)
    ended: Future = Future()
    handlers = {
        number: signal.signal(number, lambda *_: ended.done() or ended.set_result(None))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        node = SimNode(scene, model, seed=seed, namespace=namespace, camera=camera)
        node.publish_clock_at(LIVE_CLOCK_HZ)
        _declare_parameters(node, seed)
        _pace(node, speed)
        _log(node).info(f"{model.name} in {scene.name}, seed {seed}, speed {speed:g}")
        rclpy.spin_until_future_complete(node, ended)
        node.destroy_node()
    finally:
        rclpy.shutdown()
        for number, handler in handlers.items():
            signal.signal(number, handler)
    return 0


def _declare_parameters(node: SimNode, seed: int) -> None:
    """Show what cannot be changed while it runs."""
    simulation = node.simulation
    for name, value, description in (
        ("world", simulation.world.name, "Name of the world."),
        ("robot", simulation.robot.name, "Model of the robot."),
        ("seed", seed, "Seed of all sensor noise."),
    ):
        descriptor = ParameterDescriptor(description=description, read_only=True)
        node.declare_parameter(name, value, descriptor, ignore_override=True)


def _pace(node: SimNode, speed: float) -> None:
    """Move the node from a timer on the wall clock; its parameter `speed` may be set any time."""
    wall = RosClock(clock_type=ClockType.STEADY_TIME)
    allowed = FloatingPointRange(from_value=SLOWEST, to_value=FASTEST)
    description = "How many times faster than the wall clock virtual time runs."
    descriptor = ParameterDescriptor(description=description, floating_point_range=[allowed])
    speed = node.declare_parameter("speed", speed, descriptor).value
    pacer = Pacer(speed, wall.now().nanoseconds, node.next_due_ns)

    def tick() -> None:
        now_ns = wall.now().nanoseconds
        node.advance_to(pacer.target(now_ns, node.simulation.time_ns))
        reached = pacer.shortfall(now_ns)
        if reached is not None:
            _log(node).warning(f"too slow for speed {pacer.speed:g}: reached {reached:.2g}")

    def on_parameters(parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == "speed":
                pacer.set_speed(parameter.value, wall.now().nanoseconds, node.simulation.time_ns)

    node.add_post_set_parameters_callback(on_parameters)
    node.create_timer(_LIVE_TICK_S, tick, clock=wall)
