"""What a simulation refuses at its start: places without space, rates, missing topics."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.interfaces import PublishNode, WaitForNode
from bt_mission.language.trees import all_steps, has_python
from bt_mission.robots.model import RobotModel, load_robot
from sim.physics.spawn import RobotSpawn
from sim.robot.fit import is_clear, off_floor
from sim.ros.schedule import RateError, period_of
from sim.sensors.topics import topics_of
from sim.world.loader import load_world
from sim.world.world import Spawn, World

TOPICS = frozenset(
    (
        *("amcl_pose", "clock", "cmd_vel", "collisions", "coverage", "ground_truth/odom"),
        *(
            "joint_states",
            "joint_commands",
            "map",
            "motors_on",
            "odom",
            "plan",
            "robot_description",
            "speed_limit",
            "tf",
        ),
        *("tf_static", "total_distance", "waypoints", "zones"),
    )
)
"""The topics of the simulator, the servers and the executive, besides the sensors' topics."""


def start_problem(world: World, robot: RobotModel, spawn: Spawn | None = None) -> str | None:
    """Return why a robot cannot start in a world, at the world's spawn or another one, or None.

    The physics decides only where the robot may touch something.
    """
    entrant, start = RobotSpawn(robot, spawn=spawn), spawn or world.spawn
    if outside := off_floor(world, entrant, start):
        return str(outside)
    if is_clear(world, entrant, start):
        return None
    from sim.simulation import Simulation  # noqa: PLC0415 - MuJoCo takes long

    try:
        Simulation(world, [entrant], seed=0)
    except BtMissionError as error:
        return str(error)
    return None


def model_problems(robot: RobotModel) -> list[tuple[tuple[str, ...], str]]:
    """Return what is wrong with the MuJoCo model of a robot's own, with keys of the robot."""
    if robot.model is None:
        return []
    from sim.physics.mjcf import problems  # noqa: PLC0415 - MuJoCo takes long

    return problems(robot)


def dragging_parts(robot: RobotModel) -> list[str]:
    """Return which parts besides wheels and casters touch the floor where the robot stands."""
    from sim.simulation import dragging  # noqa: PLC0415 - MuJoCo takes long

    return list(dragging(robot))


def rate_problems(robot: RobotModel) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the rates of sensors that do not fit the steps of the physics, with their keys."""
    for path, rate in robot.rates.items():
        try:
            period_of(rate, ".".join(path))
        except RateError as error:
            yield path, str(error)


def stage_problems(mission: Mission) -> Iterator[Diagnostic]:
    """Yield what the simulation of a mission would refuse at its start, at the mission's keys."""
    document = mission.document
    try:
        robot = load_robot(mission.robot, near=mission.file)
        world = load_world(mission.world, near=mission.file) if mission.world else None
    except (BtMissionError, InputError):
        return  # reported elsewhere
    for _, message in rate_problems(robot):
        yield document.diagnostic("BT-804", ("robot",), f"robot {robot.name}: {message}")
    unusable = model_problems(robot)
    for _, message in unusable:
        yield document.diagnostic("BT-813", ("robot",), f"robot {robot.name}: {message}")
    problem = None if world is None or unusable else start_problem(world, robot)
    if problem is not None:
        yield document.diagnostic("BT-803", ("world",), problem)
    elif robot.model is not None and not unusable:
        for text in dragging_parts(robot):
            message = f"robot {robot.name}: {text}"
            yield document.diagnostic("BT-814", ("robot",), message, severity="warning")
    yield from _missing_topics(mission, robot)


def _missing_topics(mission: Mission, robot: RobotModel) -> Iterator[Diagnostic]:
    """Yield a warning for each topic that is read and that nothing in the simulation publishes."""
    steps = list(all_steps(mission))
    if mission.nodes or has_python(mission):
        return  # these may publish anything
    own = {_plain(step.ros_name) for step in steps if isinstance(step, PublishNode)}
    known = TOPICS | own | topics_of(robot)
    read = [
        (tree.document, (*follow.place.path, "topic"), follow.settings.topic)
        for tree in mission.all_trees
        for follow in tree.follow
    ]
    read += [
        (tree.document, (*step.path, "wait_for", "topic"), step.ros_name)
        for tree in mission.all_trees
        for step in tree.body.walk()
        if isinstance(step, WaitForNode)
    ]
    for document, path, name in read:
        if _plain(name) not in known and not name.startswith("~"):
            message = f"nothing in the simulation publishes {quoted(name)}"
            near = did_you_mean(_plain(name), known)
            hint = near or f"topics: {listed(sorted(known), len(known))}"
            yield document.diagnostic("BT-509", path, message, hint, severity="warning")


def _plain(name: str) -> str:
    return name.strip("/")
