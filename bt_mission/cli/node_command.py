"""Commands that run one part of a robot's software alone, as an ordinary ROS node, until Ctrl-C."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bt_mission.cli.network import add_duplicates_option, add_network_option, prepare_graph
from bt_mission.cli.ros_arguments import EPILOG, TAKEN, checked
from bt_mission.cli.view import add_view_option
from bt_mission.core.files import find


def add_sim_parser(commands: Any) -> None:
    """Add ``sim`` to the command line."""
    parser = commands.add_parser(
        "sim",
        description="Simulates a TurtleBot3 in a world and speaks the robot's own topics "
        "(cmd_vel, scan, odom, imu, tf, camera, ...) and /clock. Start `bt-mission servers` and "
        "`bt-mission run FILE --attach` in other terminals.",
    )
    parser.add_argument("--world", default="empty_arena", help="a world's name or file")
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--robot", default="waffle", help="a robot's name or file")
    who.add_argument(
        "--robots",
        nargs="+",
        metavar="NAME=ROBOT@X,Y,YAW",
        help="several robots, each in the namespace of its name (metres, degrees)",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the sensors' noise")
    parser.add_argument(
        "--speed", type=float, default=1.0, help="simulated seconds per second (default 1)"
    )
    _add_namespace(parser)
    parser.add_argument("--no-camera", action="store_true", help="never render images")
    parser.add_argument(
        "--no-map",
        action="store_true",
        help="publish neither map nor the transform from map to odom: SLAM or localisation does",
    )
    parser.add_argument(
        "--props",
        type=int,
        default=8,
        metavar="N",
        help="how many things can be spawned at a time (default 8, at most 64)",
    )
    parser.add_argument(
        "--cmd-vel-type",
        choices=("stamped", "plain"),
        default="stamped",
        help="take commands as TwistStamped (default) or as Twist",
    )
    add_view_option(parser)
    _set_command(parser, sim)


def add_servers_parser(commands: Any) -> None:
    """Add ``servers`` to the command line."""
    parser = commands.add_parser(
        "servers",
        description="Offers driving, turning, pictures, colours, distances, exploration, and "
        "Nav2's navigation and recoveries as actions ('bt-mission actions list' names them), and "
        "the services /stop and /release, for a robot, simulated or real, that it knows by its "
        "topics alone.",
    )
    parser.add_argument("--robot", default="waffle", help="a robot's name or file")
    _add_namespace(parser)
    parser.add_argument(
        "--images", type=Path, default=Path("images"), help="where pictures are written"
    )
    _add_wall_clock(parser, ", as with a real robot")
    parser.add_argument(
        "--real",
        action="store_true",
        help="serve a real robot: this machine's clock, and commands of the type it listens for",
    )
    _add_parameters(parser, ", or the name of a shipped one")
    add_duplicates_option(parser)
    _set_command(parser, servers)


def add_mapper_parser(commands: Any) -> None:
    """Add ``mapper`` to the command line."""
    parser = commands.add_parser(
        "mapper",
        description="Publishes map and coverage while the robot moves, out of scan, odom and the "
        "transform from map to odom, which something else has to know. The service save_map "
        "writes the map as Nav2's map server reads it.",
    )
    parser.add_argument("--robot", default="waffle", help="a robot's name or file")
    _add_namespace(parser)
    parser.add_argument(
        "--save-as", default="map", metavar="PREFIX", help="where save_map writes (default: map)"
    )
    _add_parameters(parser)
    _add_wall_clock(parser, ", as with a real robot")
    parser.set_defaults(real=False)
    _set_command(parser, mapper)


def add_arbiter_parser(commands: Any) -> None:
    """Add ``arbiter`` to the command line."""
    parser = commands.add_parser(
        "arbiter",
        description="Stands between several topics of commands and cmd_vel: cmd_vel_stop over "
        "cmd_vel_joy over cmd_vel_mission (all TwistStamped). A source that falls silent counts "
        "no longer, and the base is told to stand while nobody speaks. Have the servers send to "
        "cmd_vel_mission: a parameter file with topics.cmd_vel.",
    )
    _add_namespace(parser)
    _add_wall_clock(parser)
    parser.add_argument(
        "--real",
        action="store_true",
        help="drive a real robot: this machine's clock, and the type of command it listens for",
    )
    _add_parameters(parser)
    _set_command(parser, arbiter)


def _set_command(parser: argparse.ArgumentParser, command: Callable[..., int]) -> None:
    def interruptible(options: argparse.Namespace) -> int:
        from bt_mission.cli.run import leaving_at_once

        # rclpy, while it is loaded, reports Ctrl-C as an extension that is not there.
        with leaving_at_once():
            return command(options)

    parser.set_defaults(command=interruptible, **TAKEN)
    parser.epilog = EPILOG


def _add_namespace(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--namespace", default="", help="namespace of the robot's topics")
    add_network_option(parser)


def _add_wall_clock(parser: argparse.ArgumentParser, when: str = "") -> None:
    words = f"keep to this machine's clock instead of /clock{when}"
    parser.add_argument("--wall-clock", action="store_true", help=words)


def _add_parameters(parser: argparse.ArgumentParser, more: str = "") -> None:
    words = f"values of parameters: a ROS parameter file{more}"
    parser.add_argument("--params", metavar="FILE", help=words)


def sim(options: argparse.Namespace) -> int:
    """Simulate until interrupted."""
    prepare_graph(options)
    from sim.ros.live import main
    from sim.ros.node import SimOptions

    return main(
        world=options.world,
        robot=options.robots or options.robot,
        options=SimOptions(
            seed=options.seed,
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
    from action_servers.robot_io.node import ProcessOptions

    return {
        "namespace": options.namespace,
        "use_sim_time": not (options.wall_clock or options.real),
        "process": ProcessOptions(
            parameters=find("parameters", options.params) if options.params else None,
            ros_args=checked(options.ros_args),
        ),
    }
