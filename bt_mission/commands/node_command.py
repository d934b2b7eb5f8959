"""Commands that run one part of a robot's software alone, as an ordinary ROS node, until Ctrl-C."""

from __future__ import annotations

import argparse
from typing import Any

from bt_mission.base.file_kinds import PARAMETERS
from bt_mission.base.files import find
from bt_mission.cli.argument_types import whole
from bt_mission.cli.options import (
    ALLOW_DUPLICATES,
    CMD_VEL_TYPE,
    IMAGES,
    NAMESPACE,
    NETWORK,
    NO_PYTHON,
    ROBOT,
    SEED,
    SIMULATOR,
    SPEED,
    WALL_CLOCK,
    WORLD,
    prepare_graph,
    simulator_of,
)
from bt_mission.cli.parser import Command, Option, each
from bt_mission.cli.ros_arguments import EPILOG, checked
from bt_mission.cli.view import VIEW

ROBOT_MODEL = "waffle"


def sim(options: argparse.Namespace) -> int:
    """Simulate until interrupted."""
    prepare_graph(options)
    from bt_mission.robots.model import load_robot
    from bt_mission.sessions.own_nodes import imported
    from sim.physics.spawn import RobotSpawn, read
    from sim.ros.live import main
    from sim.ros.node import SimOptions

    simulator = simulator_of(options)
    alone = [] if options.robots else [RobotSpawn(load_robot(options.robot or ROBOT_MODEL))]
    return main(
        world=options.world,
        robots=[*alone, *map(read, options.robots or ())],
        options=SimOptions(
            seed=options.seed,
            simulator=None if simulator is None else imported(simulator),
            namespace=options.namespace,
            camera=not options.no_camera,
            with_map=not options.no_map,
            localises=not options.no_map,
            command_type=options.cmd_vel_type,
            props=options.props,
        ),
        speed=options.speed,
        view=options.view,
        ros_args=checked(options.ros_args),
    )


def servers(options: argparse.Namespace) -> int:
    """Serve until interrupted."""
    prepare_graph(options)
    from action_servers.server.node import main

    return main(
        robot=options.robot,
        image_folder=options.images,
        allow_duplicates=options.allow_duplicates,
        **_driving(options),
    )


def mapper(options: argparse.Namespace) -> int:
    """Map until interrupted."""
    prepare_graph(options)
    from action_servers.mapping.node import main

    return main(robot=options.robot, map_prefix=options.save_as, **_common(options))


def arbiter(options: argparse.Namespace) -> int:
    """Arbitrate until interrupted."""
    prepare_graph(options)
    from action_servers.arbiter.node import main

    return main(**_driving(options))


def _driving(options: argparse.Namespace) -> dict[str, Any]:
    """The arguments of nodes that command a base."""
    return {"command_type": "auto" if options.real else "stamped", **_common(options)}


def _common(options: argparse.Namespace) -> dict[str, Any]:
    """The arguments of every node but the simulated robot's."""
    from bt_mission.ros.executors.process import ProcessOptions

    return {
        "namespace": options.namespace,
        "use_sim_time": not (options.wall_clock or getattr(options, "real", False)),
        "process": ProcessOptions(
            parameters=find("parameters", options.params) if options.params else None,
            ros_args=checked(options.ros_args),
        ),
    }


_ROBOT = ROBOT.but(help="name or file of a robot", default=ROBOT_MODEL)
_REAL = Option(
    "--real",
    "drive a real robot: use this machine's clock and the command type that the robot "
    "subscribes to",
)
_WALL_CLOCK = WALL_CLOCK.but(help="use this machine's clock instead of /clock")
_WALL_CLOCK_REAL = WALL_CLOCK.but(help=f"{_WALL_CLOCK.help}, as with a real robot")
_PARAMETERS = Option(
    "--params FILE", "ROS parameter file", completes="parameters", takes=PARAMETERS
)


def _node(function: Any, description: str, *options: Option) -> Command:
    # rclpy, while it is loaded, reports Ctrl-C as an extension that is not there.
    return Command(
        function,
        description,
        options,
        EPILOG,
        takes_ros_args=True,
        leaves_at_once=True,
    )


COMMANDS = {
    "sim": _node(
        sim,
        "Simulates a TurtleBot3 in a world, with the topics of the real robot (cmd_vel, scan, "
        "odom, imu, tf, camera, ...) and /clock. Start `bt-mission servers` and `bt-mission run "
        "FILE --attach` in other terminals.",
        WORLD.but(help="name or file of a world", default="empty_arena"),
        _ROBOT.but(default=None),
        Option(
            "--robots NAME=ROBOT@X,Y,YAW",
            "several robots, each in a namespace with its name (metres, degrees)",
            nargs="+",
            excludes=each("robot"),
        ),
        SIMULATOR.but(excludes=each("robots", why="it moves one robot")),
        NO_PYTHON,
        SEED.but(help="seed of the sensor noise", default=0),
        SPEED.but(help="simulated seconds per second (default: 1)", default=1.0),
        NAMESPACE,
        NETWORK,
        Option("--no-camera", "never render images"),
        Option(
            "--no-map",
            "do not publish the map and the transform from map to odom, for use with SLAM or "
            "localization",
        ),
        Option(
            "--props N",
            "how many objects can be spawned at a time (default: 8, at most 64)",
            whole,
            8,
        ),
        CMD_VEL_TYPE,
        VIEW,
    ),
    "servers": _node(
        servers,
        "Serves the actions of a simulated or real robot: driving, turning, camera, colours, "
        "distances, exploration, and the navigation and recoveries of Nav2. Also serves /stop "
        "and /release. Needs only the robot's topics.",
        _ROBOT,
        NAMESPACE,
        NETWORK,
        IMAGES.but(help="folder for pictures (default: images)"),
        _WALL_CLOCK_REAL,
        _REAL.but(
            help="serve a real robot: use this machine's clock and the command type that the "
            "robot subscribes to"
        ),
        _PARAMETERS.but(help=f"{_PARAMETERS.help}, or the name of a shipped one"),
        ALLOW_DUPLICATES,
    ),
    "mapper": _node(
        mapper,
        "Publishes the topics map and coverage while the robot moves. Needs scan, odom and the "
        "transform from map to odom, which another node publishes. The service save_map saves "
        "the map in the format of Nav2's map server.",
        _ROBOT,
        NAMESPACE,
        NETWORK,
        Option("--save-as PREFIX", "path prefix of the saved map (default: map)", default="map"),
        _PARAMETERS,
        _WALL_CLOCK_REAL,
    ),
    "arbiter": _node(
        arbiter,
        "Forwards the command topic with the highest priority to cmd_vel: cmd_vel_stop over "
        "cmd_vel_joy over cmd_vel_mission (all TwistStamped). A source that stops sending is "
        "ignored; while no source sends, the base is stopped. Let the servers publish to "
        "cmd_vel_mission with a parameter file that sets topics.cmd_vel.",
        NAMESPACE,
        NETWORK,
        _WALL_CLOCK,
        _REAL,
        _PARAMETERS,
    ),
}
