"""Who may import whom (docs/architecture.md), read from the sources' syntax trees."""

import ast
import fnmatch
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("bt_mission", "action_servers", "sim")
MAX_LINES = 350

# The modules that translate between ROS and the rest. All others are pure: they hold the thinking,
# and a test of theirs takes microseconds.
ROS_MODULES = (
    "action_servers/actions.py",
    "action_servers/adapter.py",
    "action_servers/mapping/node.py",
    "action_servers/navigation/actions.py",
    "action_servers/node.py",
    "action_servers/parameters.py",
    "action_servers/plan_topic.py",
    "action_servers/real_arbiter.py",
    "action_servers/real_base.py",
    "action_servers/real_executive.py",
    "action_servers/real_parameters.py",
    "action_servers/sensors.py",
    "action_servers/switches.py",
    "bt_mission/__main__.py",
    "bt_mission/against.py",
    "bt_mission/attached.py",
    "bt_mission/cli/*",
    "bt_mission/controls.py",
    "bt_mission/courier.py",
    "bt_mission/detail_topics.py",
    "bt_mission/details.py",
    "bt_mission/doctor_probes.py",
    "bt_mission/fleet.py",
    "bt_mission/hand/about.py",
    "bt_mission/hand/calling.py",
    "bt_mission/hand/canceling.py",
    "bt_mission/hand/echo.py",
    "bt_mission/hand/feedback_table.py",
    "bt_mission/hand/form.py",
    "bt_mission/hand/form_fields.py",
    "bt_mission/hand/goal_lines.py",
    "bt_mission/hand/goal_picture.py",
    "bt_mission/hand/joining.py",
    "bt_mission/hand/listening.py",
    "bt_mission/hand/listing.py",
    "bt_mission/hand/looking.py",
    "bt_mission/hand/rate_lines.py",
    "bt_mission/hand/rejections.py",
    "bt_mission/hand/sending.py",
    "bt_mission/hand/watch_views.py",
    "bt_mission/hand/watching.py",
    "bt_mission/joined.py",
    "bt_mission/leaving.py",
    "bt_mission/journal/keep.py",
    "bt_mission/journal/messages.py",
    "bt_mission/link.py",
    "bt_mission/lockstep/*",
    "bt_mission/node.py",
    "bt_mission/observer.py",
    "bt_mission/observing.py",
    "bt_mission/recording/goals.py",
    "bt_mission/recording/pictures.py",
    "bt_mission/recording/recorder.py",
    "bt_mission/recording/tapping.py",
    "bt_mission/recording/telling.py",
    "bt_mission/recording/topics.py",
    "bt_mission/robot_relay.py",
    "bt_mission/ros_types.py",
    "bt_mission/service_caller.py",
    "bt_mission/serve_node.py",
    "bt_mission/stage.py",
    "bt_mission/status_feed.py",
    "bt_mission/status_topics.py",
    "bt_mission/testing/*",
    "bt_mission/topic_reader.py",
    "bt_mission/topic_writer.py",
    "bt_mission/waypoint_topic.py",
    "sim/live.py",
    "sim/node.py",
    "sim/pictures.py",
    "sim/topics.py",
    "sim/zones.py",
)
# Compares goals with the ROS types where ROS is installed, and says that it did not elsewhere.
ASKS_FOR_TYPES = ("bt_mission/mission/check.py",)
# Put the world and the servers on one clock, or start them: the only ones to know all folders.
MEETING_PLACES = ("bt_mission/stage.py", "bt_mission/fleet.py", "bt_mission/cli/*")
# Paces a live run against the wall.
WALL_CLOCK_MODULES = ("bt_mission/pacing.py",)
EXCEPTIONS = sorted({*ROS_MODULES, *ASKS_FOR_TYPES, *MEETING_PLACES, *WALL_CLOCK_MODULES})

ROS_NAMES = ("rclpy", "rosidl_*", "unique_identifier_msgs", "*_msgs", "*_srvs", "*_interfaces")
WALL_CLOCK_NAMES = (
    "time.time",
    "time.time_ns",
    "time.monotonic",
    "time.monotonic_ns",
    "time.perf_counter",
    "time.perf_counter_ns",
    "time.sleep",
    "asyncio.sleep",
    "datetime.datetime.now",
    "datetime.datetime.today",
    "datetime.datetime.utcnow",
    "datetime.date.today",
    "py_trees.decorators.Timeout",
    "py_trees.timers",
    "py_trees.timers.*",
    "*.tick_tock",
)


@dataclass(frozen=True)
class Source:
    """One module: its path below the project, and its syntax tree."""

    path: str
    tree: ast.Module

    @property
    def package(self) -> str:
        """The folder that the rules are about: `bt_mission/common`, or the top-level package."""
        common = "bt_mission/common"
        return common if self.path.startswith(f"{common}/") else self.path.split("/", 1)[0]

    def is_among(self, patterns: tuple[str, ...]) -> bool:
        """Whether one of the path patterns names this module."""
        return _matches(self.path, patterns)


@dataclass(frozen=True)
class Use:
    """A dotted name that a module imports or reads, and the line where."""

    name: str
    line: int


def _matches(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def _imports(source: Source) -> Iterator[Use]:
    """The full name of each import, wherever it stands: at the top, in a function, in a string."""
    for node in ast.walk(source.tree):
        match node:
            case ast.Import(names=aliases):
                yield from (Use(alias.name, node.lineno) for alias in aliases)
            case ast.ImportFrom(names=aliases):
                parent = _parent(source, node)
                yield from (Use(f"{parent}.{alias.name}", node.lineno) for alias in aliases)
            case ast.Call(func=function, args=[ast.Constant(value=str(name)), *_]) if ast.unparse(
                function
            ) in {"importlib.import_module", "import_module", "__import__"}:
                yield Use(name, node.lineno)


def _parent(source: Source, node: ast.ImportFrom) -> str:
    """The absolute name of the module that `from ... import` takes its names from."""
    above = source.path.removesuffix(".py").split("/")[: -node.level] if node.level else []
    return ".".join([*above, *([node.module] if node.module else [])])


def _names(source: Source) -> Iterator[Use]:
    """Each dotted name that is read, with local names replaced by what they were imported as."""
    bound: dict[str, str] = {}
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Import):
            bound |= {alias.asname: alias.name for alias in node.names if alias.asname}
        elif isinstance(node, ast.ImportFrom):
            parent = _parent(source, node)
            bound |= {alias.asname or alias.name: f"{parent}.{alias.name}" for alias in node.names}
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Attribute):
            first, dot, rest = ast.unparse(node).partition(".")
            yield Use(bound.get(first, first) + dot + rest, node.lineno)
    yield from _imports(source)


def _is_below(name: str, package: str) -> bool:
    return name == package or name.startswith(f"{package}.")


def _foreign(source: Source, name: str) -> str | None:
    """Why this module may not import that name of ours, or None when it may."""
    if not any(_is_below(name, package) for package in PACKAGES):
        return None
    match source.package:
        case "bt_mission/common":
            allowed: tuple[str, ...] = ("bt_mission.common",)
        case "sim" | "action_servers" as package:
            allowed = (package, "bt_mission.common")
        case _ if source.is_among(MEETING_PLACES):
            allowed = PACKAGES
        case _:
            allowed = ("bt_mission",)
    if any(_is_below(name, package) for package in allowed):
        return None
    return f"{source.package} may import of ours only {', '.join(allowed)}"


def _impure(source: Source, name: str) -> str | None:
    """Why a pure module may not import that name, or None when it may."""
    if source.is_among(ROS_MODULES):
        return None
    if _matches(name.partition(".")[0], ROS_NAMES):
        return "a pure module knows no ROS; translate in one of ROS_MODULES"
    if source.package == "bt_mission/common" and _is_below(name, "mujoco"):
        return "bt_mission/common knows no simulator"
    if _is_below(name, "bt_mission.ros_types") and source.is_among(ASKS_FOR_TYPES):
        return None
    if _speaks_ros(name):
        return "a pure module does not import one that speaks ROS"
    return None


def _speaks_ros(name: str) -> bool:
    """Whether that is the name of a module of ours in ROS_MODULES, or of something in one."""
    path = name.replace(".", "/")
    # `from bt_mission import stage` and `from bt_mission.stage import Stage` both name the module.
    files = (f"{path}.py", f"{path}/__init__.py", f"{path.rpartition('/')[0]}.py")
    return any(_matches(file, ROS_MODULES) for file in files)


def faults(path: str, text: str) -> list[str]:
    """What breaks the rules in the module at `path` (below the project), one line each."""
    found = []
    lines = text.count("\n")
    if lines > MAX_LINES:
        found.append(f"{path}: {lines} lines, at most {MAX_LINES}; split it by concern")
    source = Source(path, ast.parse(text))
    found += [
        f"{path}:{use.line}: imports {use.name}: {why}"
        for use in _imports(source)
        for why in (_foreign(source, use.name), _impure(source, use.name))
        if why is not None
    ]
    if not source.is_among(WALL_CLOCK_MODULES):
        found += [
            f"{path}:{use.line}: {use.name} reads the wall clock; use the node's ROS clock"
            for use in _names(source)
            if _matches(use.name, WALL_CLOCK_NAMES)
        ]
    return found


def _modules() -> list[str]:
    return sorted(
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
    )


@pytest.mark.parametrize("path", _modules())
def test_every_module_keeps_the_rules(path):
    """No module of the project imports against the direction, or reads the wall clock."""
    assert faults(path, (ROOT / path).read_text(encoding="utf-8")) == []


def test_no_test_file_is_too_long():
    """Tests are held to the same length as what they test."""
    lengths = {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8").count("\n")
        for path in (ROOT / "tests").rglob("*.py")
    }
    assert {path: lines for path, lines in lengths.items() if lines > MAX_LINES} == {}


@pytest.mark.parametrize("pattern", EXCEPTIONS)
def test_every_exception_names_a_module_that_exists(pattern):
    """A module that is renamed or removed takes its exception with it."""
    assert [path for path in _modules() if fnmatch.fnmatchcase(path, pattern)] != []


@pytest.mark.parametrize(
    ("path", "text", "expected"),
    [
        ("sim/world.py", "import action_servers.pilot\n", "sim may import of ours only"),
        ("sim/world.py", "from bt_mission.stage import Stage\n", "sim may import of ours only"),
        ("sim/world.py", "from bt_mission import mission\n", "sim may import of ours only"),
        ("sim/world.py", "from rclpy.node import Node\n", "a pure module knows no ROS"),
        ("sim/lidar.py", "from sensor_msgs.msg import LaserScan\n", "a pure module knows no ROS"),
        ("sim/world.py", "from sim.node import SimNode\n", "does not import one that speaks ROS"),
        ("sim/world.py", "from . import node\n", "does not import one that speaks ROS"),
        ("action_servers/pilot.py", "def f():\n    import sim\n", "action_servers may import"),
        ("action_servers/maneuver.py", "import nav2_msgs.action\n", "a pure module knows no ROS"),
        ("bt_mission/tree.py", "import sim.world\n", "bt_mission may import of ours only"),
        ("bt_mission/tree.py", "from bt_mission import stage\n", "does not import one that"),
        ("bt_mission/tree.py", "import bt_mission.lockstep\n", "does not import one that"),
        ("bt_mission/stage.py", "import time\ntime.monotonic()\n", "time.monotonic reads"),
        ("bt_mission/common/data.py", "import bt_mission.tree\n", "bt_mission/common may import"),
        ("bt_mission/common/data.py", "import mujoco\n", "knows no simulator"),
        (
            "bt_mission/common/data.py",
            "import importlib\nimportlib.import_module('rclpy')\n",
            "ROS",
        ),
        ("bt_mission/tree.py", "import time\nnow = time.monotonic()\n", "time.monotonic reads"),
        ("bt_mission/tree.py", "import time as t\nt.sleep(1)\n", "time.sleep reads the wall"),
        ("bt_mission/tree.py", "from time import time as now\n", "time.time reads the wall"),
        ("sim/node.py", "import datetime\ndatetime.datetime.now()\n", "datetime.now reads"),
        ("sim/node.py", "from datetime import datetime\ndatetime.now()\n", "datetime.now reads"),
        ("bt_mission/tree.py", "from py_trees.decorators import Timeout\n", "Timeout reads"),
        ("bt_mission/tree.py", "import py_trees\npy_trees.timers.Timer('t')\n", "Timer reads"),
        ("bt_mission/tree.py", "def run(tree):\n    tree.tick_tock(100)\n", "tick_tock reads"),
        ("bt_mission/tree.py", "x = 1\n" * (MAX_LINES + 1), "split it by concern"),
    ],
)
def test_a_violation_is_found(path, text, expected):
    """Each rule, broken by a small invented module, is reported with its place and its reason."""
    found = faults(path, text)
    assert found, "nothing was found"
    assert all(line.startswith(path) for line in found)
    assert any(expected in line for line in found)


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("sim/node.py", "import rclpy\nfrom sim.world import World\n"),
        ("sim/world.py", "import mujoco\nfrom bt_mission.common.errors import BtMissionError\n"),
        ("bt_mission/stage.py", "import rclpy\nfrom sim.node import SimNode\n"),
        ("bt_mission/pacing.py", "import time\nnow = time.monotonic\n"),
        ("bt_mission/mission/check.py", "def f():\n    from bt_mission.ros_types import fill\n"),
        ("bt_mission/cli/run.py", "import action_servers.node\n"),
        ("bt_mission/tree.py", "from py_trees.composites import Sequence\nimport time\n"),
        ("bt_mission/tree.py", "from bt_mission.common import located\nlocated.time.time\n"),
        ("bt_mission/common/located.py", "from bt_mission.common.errors import BtMissionError\n"),
    ],
)
def test_what_is_allowed_is_not_reported(path, text):
    """The rules do not cry wolf."""
    assert faults(path, text) == []
