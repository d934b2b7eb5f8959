"""Nature on the stage: where robots start, and how late messages are."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product

from bt_mission.base.nature import Nature, generator
from bt_mission.base.stamps import NS
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.trees import all_steps
from bt_mission.ros.virtual_time import ACTION_PARTS, Delivery, Passing, Side
from bt_mission.ros.virtual_time.executor import VirtualTimeExecutor
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions, StageRun
from sim.world.world import Spawn, World

TOPICS = ("scan", "odom", "tf", "camera/image_raw", "cmd_vel")
"""The topics that are late, by their relative names."""

STARTS = ("start_x", "start_y", "start_yaw")
SHARES = (1.0, 0.5, 0.25, 0.0)
"""A start without space is moved towards the nominal start: by these shares of its offset one after
another.
"""


def natures(
    members: Sequence[FleetRobot], options: StageOptions, world: World
) -> list[dict[str, float]]:
    """Return what is drawn for each robot: that of the options, the mission or the world."""
    seed = members[0].mission.seed if options.seed is None else options.seed
    drawn = []
    for member in members:
        given: Iterable[Nature | None] = (options.nature, member.mission.nature, world.nature)
        chosen = next((nature for nature in given if nature is not None), options.default_nature)
        drawn.append(chosen.drawn(seed, member.name))
    return drawn


def moved(spawn: Spawn, nature: Mapping[str, float], share: float) -> Spawn:
    """Return a start moved by a share of a nature's offset."""
    if not nature:
        return spawn
    x, y, yaw = (share * nature[name] for name in STARTS)
    # In degrees as a world has them: from -180 up to 180.
    heading = (spawn.yaw + yaw + 180) % 360 - 180 if yaw else spawn.yaw
    return Spawn(x=spawn.x + x, y=spawn.y + y, yaw=heading)


def delay(clock: VirtualTimeExecutor, runs: Iterable[StageRun], seed: int) -> None:
    """Have the topics and action servers of robots be late."""
    for run in runs:
        if run.nature:
            _delay(clock, run.member, run.nature, seed)


def _delay(
    clock: VirtualTimeExecutor, member: FleetRobot, nature: Mapping[str, float], seed: int
) -> None:
    namespace = f"/{member.name}" if member.name else ""
    if mean_s := nature["topic_latency"]:
        for topic in TOPICS:
            name = f"{namespace}/{topic}"
            clock.taps.add(name, Side.MESSAGE, _late(mean_s, seed, name))
    if mean_s := nature["server_latency"]:
        known = {named.name for named in ACTION_NAMES.values()}
        known |= {step.ros_name for step in all_steps(member.mission) if isinstance(step, GoalNode)}
        for action in sorted(known):
            full = action if action.startswith("/") else f"{namespace}/{action}"
            for part, side in _PARTS:
                name = f"{full}/_action/{ACTION_PARTS[part]}"
                clock.taps.add(name, side, _late(mean_s, seed, f"{name} {side}"))


_PARTS = (
    *product(("goal", "cancel", "result"), (Side.REQUEST, Side.RESPONSE)),
    ("feedback", Side.MESSAGE),
)


def _late(mean_s: float, seed: int, name: str) -> Callable[[Passing], Iterable[Delivery]]:
    """Return a tap that delivers in order, each after half to one and a half times the mean."""
    generators: dict[str, random.Random] = {}
    last_ns: dict[str, int] = {}

    def tap(passing: Passing) -> Iterable[Delivery]:
        receiver = passing.receiver
        if receiver not in generators:  # each receiver has a separate delay
            generators[receiver] = generator(seed, f"{name} {receiver}")
        after_ns = round(mean_s * (0.5 + generators[receiver].random()) * NS)
        due_ns = max(passing.time_ns + after_ns, last_ns.get(receiver, 0))
        last_ns[receiver] = due_ns
        return (Delivery(passing.message, after_ns=due_ns - passing.time_ns),)

    return tap
