"""Whole programs: a file that runs as ``python FILE`` runs it, with its own view of the process."""

from __future__ import annotations

import importlib.util
import io
import sys
from collections.abc import Callable, Sequence
from concurrent.futures.thread import _worker  # what its threads run
from dataclasses import dataclass
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from itertools import pairwise
from pathlib import Path
from traceback import StackSummary, TracebackException
from types import ModuleType
from typing import Any

from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from typing_extensions import override

from bt_mission.base import user_loops
from bt_mission.base.code_owner import is_ours, owner_of
from bt_mission.programs.calls import Call, Host, Program, StandIn, current_call
from bt_mission.programs.executors import SingleThreadedExecutor
from bt_mission.programs.threads import LoopLocal

INTERRUPTED = 130
"""The exit code of a program that a KeyboardInterrupt ends."""


def hint_for_commands(error: BaseException) -> str | None:
    """Return what helps where code publishes velocity commands of the other type."""
    text = str(error)
    if "cmd_vel with incompatible type" not in text:
        return None
    is_plain = "TwistStamped" in text
    taken, other = ("Twist", "stamped") if is_plain else ("TwistStamped", "plain")
    return (
        f"the robot takes {taken}; have the node publish that, or use --cmd-vel-type {other} (in "
        f'pytest: command_type="{other}")'
    )


class ProgramContext(Context, metaclass=StandIn):
    """A context of rclpy in a program: one that it shares with the stage, and alone shuts down."""

    _stands_for = Context
    _is_up = False

    @override
    def init(self, args: Any = None, **_: Any) -> None:
        call = current_call()
        if call is None:
            raise RuntimeError("a context of a program is initialized by its code")
        if self.handle is not None:
            raise RuntimeError("Context.init() must only be called once")
        shared = call.program.host.clock.context
        self._Context__context = shared.handle
        self._is_up = True
        call.program.contexts.append(self)
        if isinstance(call.program, MainProgram):
            call.program.take_ros_args(sys.argv if args is None else args)

    @override
    def ok(self) -> bool:
        return self._is_up

    @override
    def shutdown(self) -> None:
        if self.handle is None:
            raise RuntimeError("Context must be initialized before it can be shutdown")
        if not self._is_up:
            raise _rclpy.RCLError(
                "failed to shutdown: rcl_shutdown already called on the given context"
            )
        self.try_shutdown()

    @override
    def try_shutdown(self) -> None:
        if self._is_up:
            self._is_up = False
            self._call_on_shutdown_callbacks()

    def end(self) -> None:
        """Shut down as the handler of a signal does: nothing is called."""
        self._is_up = False

    @override
    def on_shutdown(self, callback: Callable[[], None]) -> None:
        if self.handle is not None and not self._is_up:
            callback()
        else:
            super().on_shutdown(callback)

    @override
    def destroy(self) -> None:
        """Leave the context to the stage."""


class RclpyOfNodes:
    """rclpy's compiled module, as ``rclpy.node`` sees it in a program."""

    def __getattr__(self, name: str) -> Any:
        """Return the rest as it is."""
        return getattr(_rclpy, name)

    def Node(self, name: str, namespace: Any, context: Any, arguments: Any, *rest: Any) -> Any:  # noqa: N802 - of rclpy
        """Return a new node, to which the arguments of its program apply."""
        call = current_call()
        if call is not None and isinstance(call.program, MainProgram) and call.program.ros_args:
            arguments = [*(arguments or []), *call.program.ros_args]
        return _rclpy.Node(name, namespace, context, arguments, *rest)


class LoopFinder:
    """Finds the modules that code of programs imports, and has their loops noted."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Return the file of a module that is the user's, or of the package of the program."""
        call = current_call()
        if call is None:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is None or type(spec.loader) is not SourceFileLoader or spec.origin is None:
            return None
        package = getattr(call.program, "package", "")
        if owner_of(spec.origin) == "user" or name.partition(".")[0] == package:
            spec.loader = user_loops.LoopLoader(name, spec.origin)
        return spec


class _Lines(io.TextIOBase):
    """What a program prints, line by line."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say, self._begun = say, ""
        self.lines: list[str] = []
        """Those to pass on."""

    @override
    def write(self, text: str) -> int:
        *lines, self._begun = (self._begun + text).split("\n")
        self.lines += lines
        return len(text)

    def pass_on(self) -> None:
        """Pass the lines on, once nothing of the program runs."""
        lines, self.lines = self.lines, []
        for line in lines:
            self._say(line)

    def close(self) -> None:
        """Pass on what there is, and nothing that is written later."""
        self.pass_on()
        self._say = lambda _: None

    def end(self) -> None:
        """Pass on a last line that has no end."""
        if self._begun:
            self.write("\n")


class _Input:
    """What a program reads from, after what it has printed was shown, such as a question."""

    def __init__(self, program: MainProgram) -> None:
        self._program = program

    def __getattr__(self, name: str) -> Any:
        """Return the rest as it is."""
        return getattr(self._program.show_lines(), name)

    def __iter__(self) -> Any:
        """Read line by line."""
        return iter(self._program.show_lines())


@dataclass(frozen=True)
class WholeProgram:
    """A program to run.

    Attributes:
        file: The file, absolute.
        arguments: After its name on the command line.
        say: Receives the lines that it prints, each after its virtual time, s.
        end: Receives its exit code.
        module: Its module, as for ``python -m``; empty for a file.
        function: What a console script calls in that module.
    """

    file: Path
    arguments: Sequence[str]
    say: Callable[[float, str], None]
    end: Callable[[int], None]
    module: str = ""
    function: str = ""

    @property
    def name(self) -> str:
        """That of the file, or of the module."""
        return self.module.rpartition(".")[2] or self.file.stem


class MainProgram(Program):
    """A file that runs as ``__main__``.

    Args:
        seed: Of its random numbers.
        file: The file, absolute.
        arguments: After its name on the command line.
        say: Receives the lines that it prints.
        module: Its module, as for ``python -m``; empty for a file.
        function: What a console script calls in that module.
    """

    def __init__(
        self,
        host: Host,
        seed: str,
        file: Path,
        arguments: Sequence[str],
        say: Callable[[str], None],
        module: str = "",
        function: str = "",
    ) -> None:
        super().__init__(host, module.rpartition(".")[2] or file.stem, seed, None)
        self.file, self.argv = file, [str(file), *arguments]
        self._module, self._function = module, function
        self.package = module.partition(".")[0]
        """The package of its module; empty for a file."""
        self.output, self._input = _Lines(say), _Input(self)
        self.exit_code: int | None = None
        """None while it runs."""
        self.ros_args: list[str] = []
        self.log_levels: dict[str, int] = {}
        """Of its loggers, by name; that of the empty name is for all others."""
        self.threads: list[Any] = []
        """Those that its end waits for."""
        self.at_exit: list[Callable[[], Any]] = []
        self.main_call: Call | None = None
        """Its main thread, once it runs."""
        self.has_ros = False
        """Whether it has called ``rclpy.init``."""
        self._folder = str(file.parent)
        self._modules: dict[str, ModuleType] = {}
        self._hidden: dict[str, ModuleType | None] = {}
        """Modules of others with the same names, while its code runs."""
        self._known: set[str] = set()
        """The names of all modules, when it was last looked."""
        self._count = 0
        self._outside: tuple[Any, ...] = ()
        self._own_loops = LoopLocal()
        self._loops: Any = import_module("asyncio").DefaultEventLoopPolicy()
        self._loops._local = self._own_loops

    def take_ros_args(self, argv: Sequence[str]) -> None:
        """Take the arguments of ``rclpy.init`` that are for ROS."""
        self.has_ros, self.ros_args = True, []
        is_ros = False
        for word in argv:
            if word in ("--ros-args", "--"):
                is_ros = word == "--ros-args"
            elif is_ros:
                self.ros_args.append(word)
        if self.ros_args:
            self.ros_args.insert(0, "--ros-args")
        for word, value in pairwise(self.ros_args):
            name, _, level = value.rpartition(":=")
            if word == "--log-level" and level.upper() in LoggingSeverity.__members__:
                self.log_levels[name] = LoggingSeverity[level.upper()].value

    @override
    def serving(self) -> Any:
        executor = self.executor
        if executor is None or executor._is_shutdown or not executor.context.ok():
            self.executor = made = SingleThreadedExecutor.of(self)

            def end() -> None:
                made.shutdown()

            made.context.on_shutdown(end)
        return self.executor

    @override
    def swap_in(self) -> None:
        events: Any = sys.modules["asyncio.events"]
        self._outside = (sys.argv, sys.stdout, sys.stderr, sys.stdin, events._event_loop_policy)
        sys.argv, sys.stdin, events._event_loop_policy = self.argv, self._input, self._loops
        sys.stdout = sys.stderr = self.output
        modules, hidden = sys.modules, self._hidden
        for name, module in self._modules.items():
            hidden[name] = modules.get(name)
            modules[name] = module
        if len(modules) != self._count:
            self._known, self._count = set(modules), len(modules)
        if not self._module:
            sys.path.insert(0, self._folder)

    @override
    def swap_out(self) -> None:
        events: Any = sys.modules["asyncio.events"]
        self._loops = events._event_loop_policy
        sys.argv, sys.stdout, sys.stderr, sys.stdin, events._event_loop_policy = self._outside
        modules, path, folder = sys.modules, sys.path, self._folder
        if not self._module:
            if path[0] == folder:
                del path[0]
            elif folder in path:
                path.remove(folder)
        if len(modules) != self._count:
            self._take_new_modules()
        for name, hidden in self._hidden.items():
            if hidden is not None:
                modules[name] = hidden
            else:
                modules.pop(name, None)
        if self.output.lines:
            self.output.pass_on()

    def show_lines(self) -> Any:
        """Pass on what it has printed, also an unfinished line. Return the real input."""
        inside = sys.stdout, sys.stderr
        _, sys.stdout, sys.stderr, real, _ = self._outside
        try:
            self.output.end()
            self.output.pass_on()
        finally:
            sys.stdout, sys.stderr = inside
        return real

    def _take_new_modules(self) -> None:
        """Take the modules that its code has imported, if their files lie beside it."""
        for name in sys.modules.keys() - self._known:
            file = getattr(sys.modules[name], "__file__", None) or ""
            if Path(file).is_relative_to(self._folder):
                self._modules[name] = sys.modules[name]
                self._hidden[name] = None
        self._known, self._count = set(sys.modules), len(sys.modules)

    def run(self) -> None:
        """Run the program to its end, in a call."""
        try:
            code = self._code_of(self._run_file)
            self._wait_for_threads()
            for function in reversed(self.at_exit):
                function()
            if self.exit_code is None:
                self.exit_code = code
        finally:
            self.output.end()

    def close_loops(self) -> None:
        """Close the event loops that it has left open, as the end of a process does."""
        for loop in self._own_loops.all:
            if not loop.is_running():
                loop.close()

    def _wait_for_threads(self) -> None:
        """Wait for callbacks in the threads of executors, then for threads, as Python does."""
        for executor in tuple(self.host.executors):
            if executor.program is self and executor.hands_over:
                executor.wait_for_callbacks()
        for thread in self.threads:
            if thread.is_alive() and getattr(thread, "_target", None) is _worker:
                pool = thread._args[0]()
                if pool is not None:
                    pool.shutdown(wait=False)
            if not thread.daemon:
                thread.join()

    def _code_of(self, function: Callable[[], None]) -> int:
        try:
            function()
        except SystemExit as end:
            if end.code is None or isinstance(end.code, int):
                return end.code or 0
            self.output.write(f"{end.code}\n")
        except KeyboardInterrupt as error:
            self.show(error)
            return INTERRUPTED
        except Exception as error:  # noqa: BLE001 - whatever a program raises
            self.show(error)
        else:
            return 0
        return 1

    def show(self, error: BaseException) -> None:
        """Print a traceback, without the frames of bt-mission, which are not there on a robot."""
        shown: TracebackException | None = TracebackException.from_exception(error)
        assert shown is not None
        text = shown
        while shown is not None:
            own = [frame for frame in shown.stack if not is_ours(frame.filename)]
            while own and own[0].filename != str(self.file):  # what runs the file
                del own[0]
            shown.stack = StackSummary.from_list(own)
            shown = shown.__cause__ or shown.__context__
        self.output.write("".join(text.format()))
        if hint := hint_for_commands(error):
            self.output.write(f"{hint} [BT-215]\n")
        if isinstance(error, ModuleNotFoundError) and error.name:
            name = error.name.partition(".")[0]
            self.output.write(
                f"The package of the module '{name}' is not installed in {sys.prefix}. Install it "
                "with pip, or source the workspace that has it. [BT-215]\n"
            )

    def _run_file(self) -> None:
        """Run the file, and its `main` if it only defines one, as a console script does."""
        if self._function:
            main: Any = import_module(self._module)
            for name in self._function.split("."):
                main = getattr(main, name)
            raise SystemExit(main())
        name = self._module or "__main__"
        if self._module and self.file.name == "__main__.py":
            name += ".__main__"
        loader = user_loops.LoopLoader(name, str(self.file))
        spec = importlib.util.spec_from_file_location(name, self.file, loader=loader)
        assert spec is not None
        module = importlib.util.module_from_spec(spec)
        module.__name__ = "__main__"
        vars(module)[user_loops.NAME] = user_loops
        if not self._module:
            module.__spec__ = None
        elif module.__package__:
            import_module(module.__package__)
        self._hidden["__main__"] = sys.modules.get("__main__")
        self._modules["__main__"] = sys.modules["__main__"] = module
        exec(loader.get_code(name), vars(module))  # noqa: S102 - what it is for
        main = getattr(module, "main", None)
        if not self.has_ros and callable(main):
            main()
        if not self.has_ros:
            raise SystemExit(self._why_nothing(vars(module)))

    def _why_nothing(self, names: dict[str, Any]) -> str:
        """Say why a program did nothing, and how its nodes can be used."""
        file = self.file.name
        nodes = [
            f"{file}:{name}"
            for name, value in names.items()
            if isinstance(value, type)
            and issubclass(value, Node)
            and value.__module__ == "__main__"
        ]
        if nodes:
            return (
                f"{file} has no main() that calls rclpy.init(). Write one, or have a mission make "
                f"its node: nodes: [{', '.join(nodes)}]. [BT-215]"
            )
        return f"{file} has ended without rclpy.init(): it uses no ROS. [BT-215]"
