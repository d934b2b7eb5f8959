"""What a tick costs in which nothing changes, against py_trees alone with a tree of the same shape.

Ours is a mission as it runs: its node, trace, ledger and status topics with a subscriber, and a
goal under way in each action leaf that runs. The goals do not cross the wire, since ten thousand
of them would take minutes to accept; while a goal runs, nothing but feedback crosses it anyway.
Whether the servers are still there is asked of the real graph.

And the delay of a tick by a revision of such a mission. Two versions take turns: the second one has
one more leaf, and a time limit around another one. `bt-mission revise` has the executive read the
new version, prepare the new tree and exchange the trees, each just after a tick. Reading is
measured by `benchmarks loading`. The preparation compares the versions and builds the new tree. The
mission is ticked once before the exchange, and the goals continue. The new tree is sent after the
next tick.
Run it as: python benchmarks/ticks.py [--only ticks|extras|revisions ...] [--rounds N] [--nodes N]
"""

from __future__ import annotations

import json
import tempfile
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any

import py_trees
import rclpy
from bt_mission_interfaces.action import Turn
from bt_mission_interfaces.msg import StatusChanges
from measuring import CpuWatch, arguments, figure, in_turns, ratios, spread, table, times
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.node import Node
from rclpy.time import Time

from bt_mission.base.dds.discovery import isolate
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.goals.goal import Goal, GoalTrigger
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.action import GoalNode
from bt_mission.ros.goal_client import RosGoalClient
from bt_mission.ros.graph import NodeOptions
from bt_mission.ros.journal import open_journal
from bt_mission.ros.mission_runner import MissionRunner, RunnerOptions
from bt_mission.ros.status_publisher import CHANGES
from bt_mission.ros.virtual_time.discovery import wait_for_matching
from bt_mission.sessions.load import load
from bt_mission.sessions.scripted_server import ScriptedServer

WIDTH = 10
"""Children of a composite."""

SIZES = (100, 1000, 10_000)
REVISED = (100, 300, 1000)
TICK_NS = 50_000_000
TICKS = 20
"""Ticks of one measurement: a second of ROS time, to include periodic work."""

LEAVES: tuple[dict[str, Any], ...] = (
    {"turn": {"angle": 90}, "timeout": 3600},
    {"explore_forward": {"fwd_velocity": 0.2, "stopping_distance": 0.5}, "timeout": 3600},
    {"camera_sweep": {"sweep_angle": 180, "image_count": 8}, "timeout": 3600},
)
TURNS = ({"turn": {"angle": 90}, "timeout": 3600, "cancel_when": "current_angle > 400"},)
CHECKS = [{"check": "battery > 0.2"}, {"check": "is_ready and battery < 1"}]


@dataclass(frozen=True)
class Shape:
    """A tree that fans out by ten.

    :param kind: of its composites: ``parallel`` or ``sequence``.
    :param leaves: the actions of the leaves, in turn.
    :param guarded: the last level are reactive sequences, each of two checks before its actions.
    """

    title: str
    kind: str
    leaves: tuple[dict[str, Any], ...] = LEAVES
    guarded: bool = False


ALL_RUN = Shape("parallels: every leaf runs", "parallel")
SHAPES = (
    ALL_RUN,
    Shape("reactive sequences in parallels", "parallel", guarded=True),
    Shape("sequences with memory: one leaf runs", "sequence"),
)


def step_of(shape: Shape, nodes: int) -> dict[str, Any]:
    """Return the step of a mission with a tree of some nodes."""
    if nodes > WIDTH + 1:
        sizes = [(nodes - 1 + index) // WIDTH for index in range(WIDTH)]
        return {shape.kind: [step_of(shape, size) for size in sizes]}
    leaves = [leaf for leaf, _ in zip(cycle(shape.leaves), range(nodes - 1), strict=False)]
    if shape.guarded:
        return {"sequence": CHECKS + leaves[len(CHECKS) :], "memory": False}
    return {shape.kind: leaves}


def mission_with(tree: dict[str, Any]) -> str:
    """Return the text of a mission with a tree."""
    head = {"mission": "ticked", "inputs": {"battery": 0.9, "is_ready": True}}
    return json.dumps({**head, "tree": tree})


class Constant(Behaviour):
    """A leaf that does nothing."""

    def __init__(self, status: Status) -> None:
        super().__init__(f"always {status.value}")
        self._answer = status

    def update(self) -> Status:
        """Return the same status."""
        return self._answer


def bare_tree(ours: Behaviour) -> Behaviour:
    """Return a tree of py_trees' composites with the shape of ours, its leaves doing nothing."""
    children = [bare_tree(child) for child in ours.children]
    if not children:
        return Constant(Status.RUNNING if isinstance(ours, ActionLeaf) else Status.SUCCESS)
    if isinstance(ours, py_trees.composites.Sequence):
        return py_trees.composites.Sequence(ours.name, ours.memory, children)
    policy = ParallelPolicy.SuccessOnAll(synchronise=True)
    return py_trees.composites.Parallel(ours.name, policy, children)


class HeldGoalClient(RosGoalClient):
    """A client whose goals are accepted at once, and run forever."""

    def send(self, goal: Goal, request: Any) -> None:  # noqa: ARG002 - the client's form
        """Accept the goal."""
        goal.on(GoalTrigger.ACCEPTED)

    def ask_result(self, goal: Goal) -> None:
        """Do nothing: the goal does not end."""


class HeldMission(MissionRunner):
    """A mission whose goals run forever."""

    def goal_client(self, action: str, type_name: str) -> RosGoalClient:
        """Return a goal client that keeps its goals."""
        full = self.node.resolve_topic_name(action)
        return self._client(
            HeldGoalClient, full, action, type_name, lambda _: lambda: "", self.exchanges
        )


class Ticked:
    """A mission in the middle of it, and py_trees' tree of the same shape.

    :param feedback: given to each goal before each tick, in turn; empty is none.
    """

    def __init__(self, runner: MissionRunner, feedback: tuple[Any, ...]) -> None:
        self.runner = runner
        self.size = len(runner.executive.nodes)
        self._bare = py_trees.trees.BehaviourTree(bare_tree(runner.executive.root))
        self._feedback = cycle(feedback)
        self._clock = runner.node.get_clock()
        with self._clock.handle:
            self._clock.handle.set_ros_time_override_is_enabled(True)
        self._now_ns = 1_000_000_000
        for work in (self.ours, self.theirs):
            work()  # every leaf starts

    def ours(self) -> float:
        """Return the seconds of one tick of the mission's runner."""
        return self._timed(self.runner.tick)

    def theirs(self) -> float:
        """Return the seconds of a tick of py_trees' ``BehaviourTree``, without visitors."""
        return self._timed(self._bare.tick)

    def _timed(self, tick: Callable[[], object]) -> float:
        spent_s = 0.0
        for _ in range(TICKS):
            self._move_on()
            watch = CpuWatch()
            tick()
            spent_s += watch.elapsed_s
        return spent_s / TICKS

    def _move_on(self) -> None:
        """Let 50 ms of ROS time pass."""
        self._now_ns += TICK_NS
        time = Time(nanoseconds=self._now_ns, clock_type=ClockType.ROS_TIME)
        self._clock.set_ros_time_override(time)
        for feedback in self._feedback:
            for goal in self.runner.ledger.open_goals:
                goal.on_feedback(feedback)
            break


@contextmanager
def ticked(
    shape: Shape, nodes: int, *, feedback: tuple[Any, ...] = (), with_journal: bool = False
) -> Iterator[Ticked]:
    """Yield a mission of some nodes with every goal under way, its servers, and a viewer."""
    mission = load(mission_with(step_of(shape, nodes)))
    with ExitStack() as made:
        context = Context()
        rclpy.init(context=context)
        made.callback(context.shutdown)
        others = Node("others", context=context, start_parameter_services=False)
        made.callback(others.destroy_node)
        steps = [step for step in mission.tree.walk() if isinstance(step, GoalNode)]
        for action, kind in sorted({(step.ros_name, step.type) for step in steps}):
            ScriptedServer(others, kind, action)
        others.create_subscription(StatusChanges, "/bt_mission/changes", lambda _: None, CHANGES)
        node = Node(**NodeOptions(context=context, lean=True).arguments())
        made.callback(node.destroy_node)
        runner = HeldMission(node, mission, RunnerOptions(has_presence=False))
        made.callback(runner.close)
        if with_journal:
            folder = made.enter_context(tempfile.TemporaryDirectory())
            journal = open_journal(Path(folder) / "journal", mission, runner, resume=False)
            made.callback(journal.close)
        wait_for_matching([others, node])
        yield Ticked(runner, feedback)


def sizes_up_to(nodes: int, sizes: tuple[int, ...] = SIZES) -> tuple[int, ...]:
    """Return the sizes of trees that are asked for."""
    return tuple(size for size in sizes if size <= nodes) or sizes[:1]


def ticks(options: Namespace) -> None:
    """Print the cost of a tick, by shape and size."""
    print("### One tick in which nothing changes\n")
    head = ("tree", "nodes", "ours, us a node", "py_trees, us a node", "ours to py_trees")
    sizes = sizes_up_to(options.nodes)
    table(head, (_row(shape, size, options.rounds) for shape in SHAPES for size in sizes))


def _row(shape: Shape, nodes: int, rounds: int) -> list[object]:
    with ticked(shape, nodes) as tree:
        ours, theirs = in_turns(rounds, tree.ours, tree.theirs)
        ours_us, theirs_us = (times(1e6 / tree.size, taken_s) for taken_s in (ours, theirs))
    figure(f"{shape.title}, {nodes}: a node", ours_us, "us")
    to_theirs = figure(f"{shape.title}, {nodes}: to py_trees", ratios(ours, theirs))
    return [shape.title, tree.size, *map(spread, (ours_us, theirs_us, to_theirs))]


def extras(options: Namespace) -> None:
    """Print the cost of feedback and a journal in a tick."""
    nodes = min(options.nodes, 1000)
    print(f"### The same with {nodes} nodes that all run, and more to do\n")
    shape = Shape(ALL_RUN.title, ALL_RUN.kind, TURNS)
    messages = (Turn.Feedback(current_angle=1.0), Turn.Feedback(current_angle=2.0))
    rows = []
    for title, more in (
        ("a condition on feedback in each leaf, and no feedback", {}),
        ("a journal", {"with_journal": True}),
        ("feedback for each leaf at each tick", {"feedback": messages}),
    ):
        with ticked(shape, nodes, **more) as tree:
            ours, theirs = in_turns(options.rounds, tree.ours, tree.theirs)
            ours_us = figure(f"{title}: a node", times(1e6 / tree.size, ours), "us")
            rows.append([title, spread(ours_us), spread(ratios(ours, theirs))])
    table(("", "us a node", "to py_trees"), rows)


def versions(nodes: int) -> tuple[Mission, Mission]:
    """Return a mission of some nodes, and another version of it."""
    tree = step_of(ALL_RUN, nodes)
    other = json.loads(json.dumps(tree))
    box = other["parallel"]
    while "parallel" in box[0]:
        box = box[0]["parallel"]
    box[0] = {"timeout": 3600, "do": box[0]}
    other["parallel"].append({"wait": 3600})
    return load(mission_with(tree)), load(mission_with(other))


def revisions(options: Namespace) -> None:
    """Print the delay of a tick by a revision, by size."""
    rows = []
    for nodes in sizes_up_to(options.nodes, REVISED):
        plain, other = versions(nodes)
        with ticked(ALL_RUN, nodes) as tree:
            goals = len(tree.runner.ledger.open_goals)
            prepared, taken, tick, sent = [], [], [], []
            for version, _ in zip(cycle((other, plain)), range(2 * options.rounds), strict=False):
                tick.append(1e3 * tree.ours())
                watch = CpuWatch()
                plan = tree.runner.plan_revision(version)
                plan.build(tree.runner.revising.emit)
                prepared.append(1e3 * watch.elapsed_s)
                tree.ours()
                watch = CpuWatch()
                revision = tree.runner.apply_revision(plan)
                taken.append(1e3 * watch.elapsed_s)
                assert revision.is_applied, revision.reasons
                assert len(revision.continues) == goals, "no goal is touched"
                watch = CpuWatch()
                tree.runner.status_publisher.publish_if_changed()
                sent.append(1e3 * watch.elapsed_s)
        figure(f"{nodes} nodes: a revision", taken, "ms")
        figure(f"{nodes} nodes: its preparation", prepared, "ms")
        figure(f"{nodes} nodes: sending its tree", sent, "ms")
        in_ticks = figure(f"{nodes} nodes: a revision in ticks", ratios(taken, tick))
        rows.append([tree.size, *map(spread, (prepared, taken, sent, tick, in_ticks))])
    print(f"### A revision while every leaf runs (a tick is the mean of {TICKS})\n")
    head = ("nodes", "preparation, ms", "exchange, ms", "sending, ms", "a tick, ms")
    table((*head, "exchange in ticks"), rows)


def main() -> None:
    """Print the tables."""
    options = arguments(
        __doc__,
        only={"ticks": ticks, "extras": extras, "revisions": revisions},
        rounds=15,
        nodes=(10_000, "of the largest tree"),
    )
    isolate(visible=False)
    for part in options.only:
        part(options)


if __name__ == "__main__":
    main()
