"""The layers of the packages (docs/explanation/architecture.md), read from the sources."""

import ast
import fnmatch
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from py_trees.behaviour import Behaviour
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.service import Service
from rclpy.subscription import Subscription

from tests.support.command_cases import named_cases
from tests.support.project import ROOT
from tools import check_layers
from tools.check_layers import SPEAKS_ROS, TOPS, Import, is_in, names_imported_by, nodes_of

MAX_LINES = 700
ROS_NAMES = ("rclpy", "rosidl_*", "unique_identifier_msgs", "*_msgs", "*_srvs", "*_interfaces")
IN_ONE_PROCESS = "bt_mission.ros.virtual_time.self_test"
"""The one module whose service has no clients but its own."""

HOOKS = ("__getattr__", "text_factory")
"""What Python itself asks for in that way: of modules (PEP 562), of connections of sqlite3."""

KNOWN = check_layers.modules()

STARTS_PYTHON = "bt_mission.base.python_process"
"""The one module that names the interpreter of other processes."""

PROCESSES = ("subprocess.run", "subprocess.Popen", "asyncio.create_subprocess_exec")
OTHER_WAYS = (
    *("subprocess.call", "subprocess.check_call", "subprocess.check_output", "os.popen"),
    *("os.system", "os.execv", "os.execve", "os.execvp", "os.posix_spawn", "os.spawnv"),
    *("asyncio.create_subprocess_shell", "multiprocessing.Process", "multiprocessing.Pool"),
)

PATCHABLE = frozenset(
    name
    for kind in (Behaviour, Node, Publisher, Subscription, Client, Service, ActionClient, Executor)
    for name, _ in inspect.getmembers(kind, inspect.isroutine)
    if not name.startswith("__")
)
"""Methods of other people's classes."""


def _imports(text: str) -> Iterator[str]:
    yield from (name for name, _ in names_imported_by(text))


def _is_own(target: ast.expr) -> bool:
    """Does an object here change itself, or a class itself?"""
    return isinstance(target, ast.Name) and target.id in ("self", "cls")


def _sets(function: ast.expr) -> bool:
    match function:
        case ast.Name(id="setattr" | "delattr"):
            return True
        case ast.Attribute(value=ast.Name(id="object"), attr="__setattr__"):
            return True
    return False


def _changed(node: ast.AST) -> Iterator[tuple[ast.expr, str | None, ast.expr | None]]:
    """Each attribute that a statement sets or deletes: of what, its name if known, and to what."""
    targets: list[ast.expr] = []
    value: ast.expr | None = None
    if isinstance(node, ast.Assign):
        targets, value = node.targets, node.value
    elif isinstance(node, ast.AnnAssign) and node.value is not None:
        targets, value = [node.target], node.value
    elif isinstance(node, ast.Delete):
        targets = node.targets
    elif isinstance(node, ast.Call) and _sets(node.func):
        name = node.args[1]
        known = str(name.value) if isinstance(name, ast.Constant) else None
        yield node.args[0], known, node.args[2] if len(node.args) > 2 else None
    for target in targets:
        pairs = [(target, value)]
        if isinstance(target, ast.Tuple):
            values = value.elts if isinstance(value, ast.Tuple) else [None] * len(target.elts)
            pairs = list(zip(target.elts, values, strict=False))
        for first, its in pairs:
            if isinstance(first, ast.Attribute):
                yield first.value, first.attr, its


def patches(text: str) -> Iterator[str]:
    """What text does to live objects that their classes do not provide for."""
    nodes = nodes_of(text)
    methods = {
        id(child_node)
        for scope in nodes
        if isinstance(scope, ast.ClassDef)
        for child_node in scope.body
    }
    functions = {
        node.name for node in nodes if isinstance(node, ast.FunctionDef) and id(node) not in methods
    }
    for node in nodes:
        if not isinstance(node, ast.Assign | ast.AnnAssign | ast.Delete | ast.Call):
            continue
        for target, attribute, value in _changed(node):
            is_function = isinstance(value, ast.Lambda) or (
                isinstance(value, ast.Name) and value.id in functions
            )
            if attribute != "__class__" and _is_own(target):
                continue
            if attribute == "__class__":
                broken = "changes the class of an object"
            elif attribute in PATCHABLE or (is_function and attribute not in HOOKS):
                broken = "replaces a method of another object; give its class a hook"
            else:
                continue
            yield f"line {target.lineno}: {ast.unparse(node).splitlines()[0]} {broken}"
    for number, line in enumerate(text.splitlines(), start=1):
        if "type: ignore[method-assign]" in line and not any(hook in line for hook in HOOKS):
            yield f"line {number}: replaces a method of an object; give its class a hook"


def shallow(text: str) -> Iterator[str]:
    """Clients and services that read with the depth of ROS's default, 10.

    DDS brings the requests of all clients to a service, and its answers to each of them: with ten
    that wait, a client that floods a service has those of others dropped.
    """
    for node in nodes_of(text):
        if not isinstance(node, ast.Call):
            continue
        is_made = any(
            isinstance(part, ast.Attribute) and part.attr in ("create_client", "create_service")
            for part in (node.func, *node.args[:1])
        )
        if is_made and "qos_profile" not in [keyword.arg for keyword in node.keywords]:
            yield f"line {node.lineno}: a service with no depth; pass qos_profile"


def starts(text: str) -> Iterator[str]:
    """Processes whose Python would import from the working folder."""
    for node in nodes_of(text):
        match node:
            case ast.Attribute(value=ast.Name(id="sys"), attr="executable"):
                yield f"line {node.lineno}: names the interpreter; call python_command"
            case ast.Call(func=ast.Attribute(value=ast.Name(id=module), attr=name)) as call:
                function = f"{module}.{name}"
                if function in OTHER_WAYS:
                    instead = " or ".join(PROCESSES)
                    yield f"line {node.lineno}: {function} starts a process; use {instead}"
                elif function in PROCESSES and "env" not in [word.arg for word in call.keywords]:
                    yield f"line {node.lineno}: a process with no env; pass python_environment()"


def faults(name: str, text: str) -> list[str]:
    """What breaks the rules in the module of this name, one line each."""
    violations = []
    if text.count("\n") > MAX_LINES:
        violations.append(f"{name}: {text.count(chr(10))} lines, at most {MAX_LINES}")
    imports = check_layers.imports_of(name, text, {**KNOWN, name: Path()})
    violations += check_layers.upward(imports)
    if not any(is_in(name, package) for package in SPEAKS_ROS):
        violations += [
            f"{name}: imports {imported}: it is not among SPEAKS_ROS of tools/check_layers.py"
            for imported in _imports(text)
            if any(
                fnmatch.fnmatchcase(imported.partition(".")[0], pattern) for pattern in ROS_NAMES
            )
        ]
    violations += [f"{name}: {patch}" for patch in patches(text)]
    if name != IN_ONE_PROCESS:
        violations += [f"{name}: {fault}" for fault in shallow(text)]
    if name != STARTS_PYTHON:
        violations += [f"{name}: {fault}" for fault in starts(text)]
    return violations


def test_every_module_keeps_the_rules():
    """No module imports upwards, speaks ROS where it may not, or patches."""
    texts = {name: path.read_text(encoding="utf-8") for name, path in KNOWN.items()}
    assert {name: broken for name in KNOWN if (broken := faults(name, texts[name]))} == {}


def test_no_modules_import_each_other():
    """There is no cycle of imports, those for annotations and inside functions included."""
    assert check_layers.cycles(check_layers.all_imports()) == []


def test_the_root_of_the_package_holds_folders():
    """Every module of bt_mission lies in a package, but for the two that Python asks for."""
    files = {path.name for path in (ROOT / "bt_mission").glob("*.py")}
    assert files == {"__init__.py", "__main__.py"}


def test_no_test_file_is_too_long():
    """Tests are held to the same length as what they test."""
    lengths = {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8").count("\n")
        for path in (ROOT / "tests").rglob("*.py")
    }
    assert {path: lines for path, lines in lengths.items() if lines > MAX_LINES} == {}


@pytest.mark.parametrize("name", SPEAKS_ROS)
def test_what_may_speak_ros_is_there(name):
    """A package that is renamed or removed takes its permission with it."""
    assert name in KNOWN


def test_the_tool_says_what_it_found(capsys):
    """The tool prints layers, cycles and upward imports, and ends with 0 where all is well."""
    assert check_layers.main() == 0
    output = capsys.readouterr().out
    assert "layer 0: bt_mission.base" in output
    assert "0 cycles" in output
    assert "0 upward imports" in output


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("sim.world.world", "import action_servers.core.pilot\n", "imports of bt_mission only"),
        (
            "sim.world.world",
            "from bt_mission.executive.goals.goal import Goal\n",
            "only bt_mission.base",
        ),
        ("sim.world.world", "from sim.ros.node import SimNode\n", "part 0 imports part 6"),
        ("sim.world.world", "from rclpy.node import Node\n", "SPEAKS_ROS"),
        ("action_servers.core.pilot", "def f():\n    import sim.world\n", "imports of bt_mission"),
        (
            "action_servers.core.pilot",
            "import action_servers.server.node\n",
            "part 0 imports part 3",
        ),
        (
            "bt_mission.base.text",
            "import bt_mission.executive.goals.goal\n",
            "layer 0 imports layer ",
        ),
        ("bt_mission.ros.graph", "from bt_mission.cli import run\n", "imports layer "),
        ("bt_mission.ros.executors.live", "import bt_mission.ros.graph\n", "imports layer "),
        (
            "bt_mission.commands.verify",
            "import bt_mission.commands.report\n",
            "a command imports another one",
        ),
        ("bt_mission.new.room", "from bt_mission.cli import run\n", "a package without a layer"),
        ("bt_mission.executive.trace", "import sim.world.world\n", "import servers and simulator"),
        ("bt_mission.executive.trace", "import nav2_msgs.action\n", "SPEAKS_ROS"),
        ("bt_mission.base.text", "x = 1\n" * (MAX_LINES + 1), "at most"),
        ("bt_mission.base.text", "def f(x):\n    x.__class__ = int\n", "changes the class of"),
        ("bt_mission.base.text", "setattr(x, '__class__', int)\n", "changes the class of"),
        ("bt_mission.base.text", "node.tick = wrapped(node)\n", "replaces a method of another"),
        ("bt_mission.base.text", "a, b.update = 1, c\n", "replaces a method of another"),
        ("bt_mission.base.text", "del node.tick\n", "replaces a method of another"),
        ("bt_mission.base.text", "x.any_name = lambda: 1\n", "replaces a method of another"),
        (
            "bt_mission.base.text",
            "def f(x, name):\n    def call(): ...\n    setattr(x, name, call)\n",
            "replaces a method of another",
        ),
        (
            "bt_mission.base.text",
            "leaf.begin = g()  # type: ignore[method-assign]\n",
            "replaces a method of an object",
        ),
        ("bt_mission.base.text", "node.create_client(T, 'x')\n", "a service with no depth"),
        ("bt_mission.base.text", "partial(node.create_service, T)\n", "a service with no depth"),
        ("bt_mission.commands.run", "x = [sys.executable, '-m', 'y']\n", "names the interpreter"),
        ("bt_mission.commands.run", "subprocess.run(command)\n", "a process with no env"),
        ("bt_mission.commands.run", "os.system('ls')\n", "starts a process"),
    ],
)
def test_a_violation_is_found(name, text, expected):
    """Each rule, broken by a small invented module, is reported with its place and its reason."""
    violations = faults(name, text)
    assert violations, "nothing was found"
    assert all(line.startswith(name) for line in violations)
    assert any(expected in line for line in violations)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("sim.ros.node", "import rclpy\nfrom sim.world.world import World\n"),
        ("sim.world.world", "import mujoco\nfrom bt_mission.base.errors import BtMissionError\n"),
        ("bt_mission.sessions.stage", "import rclpy\nfrom sim.ros.node import SimNode\n"),
        ("bt_mission.commands.run", "import action_servers.server.node\n"),
        ("bt_mission.base.text", "ledger.on_event = self._on_goal\nself.call = lambda: 1\n"),
        ("bt_mission.base.text", "node.start_hook = self._stop\nsetattr(x, name, value)\n"),
        ("bt_mission.executive.trace", "from py_trees.composites import Sequence\nimport time\n"),
    ],
)
def test_what_is_allowed_is_not_reported(name, text):
    """The rules do not cry wolf."""
    assert faults(name, text) == []


def test_a_cycle_is_found():
    """Three modules that import each other in a ring are one cycle."""
    ring = [Import("sim.a", "sim.b", 1), Import("sim.b", "sim.c", 1), Import("sim.c", "sim.a", 1)]
    assert check_layers.cycles([*ring, Import("sim.d", "sim.a", 1)]) == [
        ["sim.a", "sim.b", "sim.c"]
    ]


def test_every_top_level_package_is_read():
    """Modules of all three packages are among those that are checked."""
    assert {name.partition(".")[0] for name in KNOWN} == set(TOPS)


WRITERS = {
    "bt_mission/base/output.py": "the one place",
    "bt_mission/scenarios/concrete/worker.py": "the null device",
    "bt_mission/testing/failure_recording.py": "a folder that is made for each test",
    "bt_mission/testing/live_graph.py": "logs and locks below a temporary folder",
    "bt_mission/testing/results.py": "a folder that is made for each test",
    "bt_mission/testing/stages.py": "a temporary folder",
    "action_servers/camera/camera_sweep.py": "a folder that is made for each goal",
    **named_cases("WRITERS"),
}
"""Modules that write files by themselves, and why an old file is in no danger."""


def test_files_are_written_in_one_place():
    """An old file is replaced only once the new one is whole, whoever writes it."""
    opens = {"write_text", "write_bytes", "copyfile"}
    writers = set()
    for top in ("bt_mission", "action_servers", "sim"):
        for path in (ROOT / top).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            if not any(name in text for name in (*opens, "open(")):
                continue
            for node in nodes_of(text):
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                    modes = [
                        argument.value
                        for argument in node.args
                        if isinstance(argument, ast.Constant)
                    ]
                    is_open = node.func.attr == "open" and any(
                        isinstance(mode, str) and set(mode) & set("wax") for mode in modes
                    )
                    if node.func.attr in opens or is_open:
                        writers.add(path.relative_to(ROOT).as_posix())
    assert writers == set(WRITERS)


MOST_SHARED_NAMES = 10
"""Names of classes that `bt_mission`, `action_servers` and `sim` share; at most."""


def test_the_name_of_a_class_has_one_meaning():
    """Within `bt_mission` each; a few are in several packages, which do not import each other."""
    places: dict[str, list[str]] = {}
    for top in ("bt_mission", "action_servers", "sim"):
        for path in sorted((ROOT / top).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ClassDef):
                    places.setdefault(node.name, []).append(path.relative_to(ROOT).as_posix())
    shared = {name: paths for name, paths in places.items() if len(paths) > 1}
    ours = {name: [path for path in paths if path[:3] == "bt_"] for name, paths in shared.items()}
    assert {name: paths for name, paths in ours.items() if len(paths) > 1} == {}
    assert len(shared) <= MOST_SHARED_NAMES, shared


EMPTY_NAMES = frozenset({"found", "heard", "in_short", "news", "one", "said", "story", "told"})
"""Names that do not say what their value is, with or without underscores around them."""

WITH_EMPTY_NAMES = ("tests/fuzz/corpus/", "tests/language/broken/")
"""Files of users that tests load."""


_WORD = rf"_*({'|'.join(EMPTY_NAMES)})_*\b"
A_WORD = re.compile(rf"\b(as|class|def)\s+{_WORD}|\b{_WORD}\s*([-+*/|&%@]?=|[]:,)(]|in\b)")
"""One of them where a name may be bound; most are words of a docstring."""


def bound_names(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and name of each variable, argument, function, class, attribute and alias."""
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield node.lineno, name
            case ast.arg(arg=name):
                yield node.lineno, name
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                yield node.lineno, name
            case ast.ClassDef(name=name) | ast.alias(asname=str(name)):
                yield node.lineno, name


def empty_names(text: str) -> list[str]:
    """Return the names of `EMPTY_NAMES` that a text binds, each with its line."""
    if not A_WORD.search(text):
        return []
    return [
        f"line {line}: {name}" for line, name in bound_names(text) if name.strip("_") in EMPTY_NAMES
    ]


WITHOUT_FAULTS = ("base", "cdr", "language", "programs", "requirements", "ros", "sessions")
"""Packages of `bt_mission` that inject no faults."""


def test_a_fault_is_injected():
    """An error of a file is a diagnostic: see the glossary of CONTRIBUTING.md."""
    wrong = {}
    for room in WITHOUT_FAULTS:
        for path in sorted((ROOT / "bt_mission" / room).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            names = [
                f"line {line}: {name}"
                for line, name in (bound_names(text) if "fault" in text else ())
                if {"fault", "faults"} & {*name.lower().split("_")}
            ]
            if names:
                wrong[path.relative_to(ROOT).as_posix()] = names
    assert wrong == {}


def test_names_say_what_their_value_is():
    """A name such as `told` or `one` is replaced by the name of the thing."""
    empty = {}
    for top in (*TOPS, "benchmarks", "campaigns", "tools", "tests"):
        for path in sorted((ROOT / top).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            if name.startswith(WITH_EMPTY_NAMES):
                continue
            if names := empty_names(path.read_text(encoding="utf-8")):
                empty[name] = names
    assert empty == {}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("for one in nodes:\n    pass\n", ["line 1: one"]),
        ("def told(x, *, _found=1): ...\n", ["line 1: told", "line 1: _found"]),
        ("self._heard = [said for said in lines]\n", ["line 1: _heard", "line 1: said"]),
        ("for node in nodes:\n    telling = one_of(node, found=1)\n", []),
    ],
)
def test_an_empty_name_is_found(text, expected):
    """Variables, arguments, functions and attributes count; names that are only used do not."""
    assert sorted(empty_names(text)) == sorted(expected)
