"""The commands, each one row: what it is, what it brings, and what it adds to other commands.

A row names modules by text, and each is imported when it is used. A command is taken away by
deleting its folder and its row; a row whose folder is absent is not listed.

Packages of other people give rows through the entry point ``bt_mission.commands``. To look for them
takes a tenth of a second, so it is done where they are listed, or where a name is not ours: they
bring commands, kinds of files, errors and pages, and add nothing to our commands.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bt_mission.base.entry_points import entry_points

FOLDER = "bt_mission.commands"
ENTRY_POINTS = "bt_mission.commands"

POINTS: Mapping[str, str] = {
    "completion.KIND": "returns names of a kind that shells complete",
    "display.TYPE": "returns the page that a notebook shows of an object of this type",
    "mission_file.SUFFIX": "the `MissionFormat` of mission files with this suffix",
    "pytest.MARKER": "is called before a test with the arguments of this marker of it",
    "recording": "a `RunFileKind`: an option of commands that keep a run, and its file",
    "replay": "a `ReplayAddition`: what a replay can start",
    "serve": "a `ServeAddition`: options of `serve`, and the missions that it serves",
    "show": "a `ShowAddition`: options of commands that show a mission, and what they do",
}
"""The extension points of commands, each with the meaning of what is added there."""


@dataclass(frozen=True)
class FileFormat:
    """A kind of file.

    Attributes:
        noun: What messages call a file of it, with its article.
        way: What to do with one, where no command takes it; ``{}`` stands for its path.
        keys: Keys at the top of a YAML file, each of which only this kind has.
        check: The function that `check` calls, as ``module:function``. Its arguments are the path,
            and the robot and the world of the options; it returns a `CheckedFile` and warnings.
        schema: The function that returns its JSON Schema, as ``module:function``.
    """

    noun: str
    way: str = ""
    keys: frozenset[str] = frozenset()
    check: str = ""
    schema: str = ""


@dataclass(frozen=True)
class CommandRow:
    """A command, or something that only adds to other commands.

    Its error codes are in ``errors.toml`` of its folder, which `explain` reads.

    Attributes:
        name: The word that calls it, or a name of what is added.
        help: Its line in the list of commands; empty where it cannot be called.
        module: Has its declaration, in ``COMMANDS``; that below `FOLDER` of its name by default.
        pages: The pages of the documentation about it, which its help names; those of another
            package are files of its folder, ``NAME.md``.
        extra: The extra of the distribution that installs what it imports.
        needs: Other rows, of whose folders it imports.
        ways: The kinds of files that it takes, each with the words that say so; ``{}`` stands for
            the path.
        kinds: The kinds of files that it brings, by name.
        missions: The kinds of files that hold missions where it is there.
        adds: What it adds to other commands, as ``module:name``, by extension point (`POINTS`).
        hints: What texts elsewhere say about it, by subject; ``{}`` stands for a name.
        example: Its line in the examples of ``bt-mission --help``.
    """

    name: str
    help: str = ""
    module: str = ""
    pages: tuple[str, ...] = ()
    extra: str = ""
    needs: tuple[str, ...] = ()
    ways: Mapping[str, str] = field(default_factory=dict)
    kinds: Mapping[str, FileFormat] = field(default_factory=dict)
    missions: tuple[str, ...] = ()
    adds: Mapping[str, str] = field(default_factory=dict)
    hints: Mapping[str, str] = field(default_factory=dict)
    example: str = ""

    @property
    def declared_in(self) -> str:
        """The module of its declaration."""
        return self.module or f"{FOLDER}.{self.name}"

    @property
    def folder(self) -> str:
        """Its package, or its module where that is all: what is deleted to take it away."""
        if not self.declared_in.startswith(f"{FOLDER}."):
            return self.declared_in.rpartition(".")[0] or self.declared_in
        return ".".join(self.declared_in.split(".")[:3])

    @property
    def is_there(self) -> bool:
        """Whether its folder is there, and those that it needs."""
        return not self.absent

    @property
    def absent(self) -> Sequence[str]:
        """The folders that it lacks: its own, and those that it needs."""
        try:
            own = [] if find_spec(self.folder) is not None else [self.folder]
        except ImportError:
            own = [self.folder]
        return list(
            dict.fromkeys(
                [*own, *(folder for name in self.needs for folder in row_of(name).absent)]
            )
        )

    @property
    def errors(self) -> Path | None:
        """The file of the errors that only it reports; None without one."""
        spec = find_spec(self.folder)
        places = spec and spec.submodule_search_locations
        file = Path(places[0], "errors.toml") if places else None
        return file if file and file.is_file() else None


def _graph(
    name: str, words: str, *pages: str, completed: tuple[str, ...] = (), **hints: str
) -> CommandRow:
    query = f"{FOLDER}.graph.completion:complete_"
    adds = {f"completion.{kind}": f"{query}{kind}" for kind in completed}
    return CommandRow(name, words, f"{FOLDER}.graph.{name}", pages, adds=adds, hints=hints)


def _files(name: str, words: str) -> CommandRow:
    return CommandRow(name, words, f"{FOLDER}.listed_files", ("own-project", "files"))


def _node(name: str, words: str, *pages: str, **more: Any) -> CommandRow:
    return CommandRow(name, words, f"{FOLDER}.node_command", pages, **more)


_LIVE = ("actions", "topics", "services", "executives", "namespaces")

ROWS = (
    CommandRow(
        "run",
        "run a mission",
        pages=("first-mission", "scenarios", "recording"),
        ways={
            **dict.fromkeys(("mission", "scenario", "fleet"), "`bt-mission run {}`"),
            "world": "`bt-mission run MISSION --world {}`",
            "robot": "`bt-mission run MISSION --robot {}`",
            "requirements": "`bt-mission run MISSION --require {}`",
            "journal": "`bt-mission run MISSION --attach --journal {} --resume`",
        },
        example="""\
  bt-mission run explore              a shipped mission, as fast as possible
  bt-mission run mine.yaml --speed 1  your own mission, in real time""",
    ),
    CommandRow(
        "play",
        "run programs of rclpy with the simulated robot, without a mission",
        pages=("test-the-server-you-have", "own-nodes"),
    ),
    CommandRow(
        "watch",
        "monitor a running mission; pause, step or stop it",
        pages=("terminal", "watch-in-a-browser"),
        example="  bt-mission watch                    monitor it from another terminal",
    ),
    CommandRow(
        "revise",
        "continue a running mission with another version of its file",
        pages=("change-while-it-drives",),
    ),
    CommandRow(
        "edit",
        "write, check, draw and run missions in a browser",
        f"{FOLDER}.edit.command",
        ("edit-in-a-browser", "mission-language"),
        extra="web",
    ),
    CommandRow(
        "check",
        "check mission files and report every error",
        pages=("mission-language", "nodes", "errors"),
        example="  bt-mission check mine.yaml          report every error before anything moves",
    ),
    CommandRow(
        "convert",
        "convert missions between YAML and the XML of Groot 2",
        f"{FOLDER}.convert.command",
        ("groot",),
        ways={"tree": "`bt-mission run {}` or `bt-mission convert {}`"},
        missions=("tree",),
        adds={"mission_file.xml": f"{FOLDER}.convert.xml_format:XML_FORMAT"},
        example="  bt-mission convert mine.yaml        the same mission as XML, for Groot 2",
    ),
    CommandRow(
        "new",
        "create a project: a mission, a world, a test, and editor settings",
        f"{FOLDER}.new.command",
        ("own-project", "first-mission"),
    ),
    CommandRow(
        "missions",
        "list shipped and local missions; copy one to edit",
        f"{FOLDER}.listed_files",
        ("own-project", "mission-language"),
    ),
    _files("worlds", "list worlds; copy one to edit"),
    _files("robots", "list robots; copy one to edit"),
    CommandRow(
        "tree",
        "draw the tree of a mission as text, DOT, SVG or PNG",
        pages=("command-line-tools",),
    ),
    CommandRow(
        "schema",
        "print the JSON Schema of a kind of file, for editors",
        pages=("own-project", "files", "ranges"),
    ),
    CommandRow(
        "serve",
        "run missions that other nodes send as goals of /execute_mission",
        pages=("serving", "deploy"),
    ),
    CommandRow(
        "mcp",
        "let agents propose missions, collect evidence, and drive with a permit",
        f"{FOLDER}.agents.mcp_command",
        ("let-an-agent-propose-missions", "agents"),
        extra="mcp",
        needs=("edit", "prove", "sweep"),
        ways={"site": "`bt-mission serve --site {}`"},
        kinds={"site": FileFormat("the file of a site", keys=frozenset(("site", "approvers")))},
        adds={"serve": f"{FOLDER}.agents.mcp_command:ADDITION"},
        hints={
            "serve": "  bt-mission serve --site site.yaml                   proposals of agents, "
            "with a permit"
        },
    ),
    CommandRow(
        "approve",
        "permit one drive of a mission that an agent has proposed",
        f"{FOLDER}.agents.approve_command",
        ("let-an-agent-propose-missions", "agents"),
        extra="mcp",
        needs=("mcp",),
    ),
    _graph(
        "actions",
        "list actions; send, cancel and watch goals",
        *("command-line-tools", "actions"),
        completed=_LIVE,
        listing=", or of 'bt-mission actions list' and its like",
        serve='  bt-mission actions send /execute_mission "{path: missions/patrol.yaml, seed: 3}"',
    ),
    _graph(
        "topics",
        "list topics; show their messages and rates",
        "command-line-tools",
        topic_type="'bt-mission topics list' names the types of a running graph",
    ),
    _graph(
        "services",
        "list and call services",
        "command-line-tools",
        serve="""\
  bt-mission services call /bt_mission/pause
  bt-mission services call /bt_mission/resume""",
    ),
    _node("sim", "run the simulated robot alone, as a ROS node", "simulator", "files"),
    _node(
        "servers",
        "run the action servers alone, as a ROS node",
        *("actions", "real-robot", "safety"),
        ways={"parameters": "`bt-mission servers --params {}`"},
    ),
    _node("mapper", "run the mapper alone, as a ROS node", "exploration", "real-robot"),
    _node(
        "arbiter",
        "give stop, joystick and missions access to one base, in this order of priority",
        *("real-robot", "safety"),
    ),
    CommandRow(
        "replay",
        "play back a recording or a trace",
        pages=("terminal", "recording"),
        ways=dict.fromkeys(("recording", "trace"), "`bt-mission replay {}`"),
    ),
    CommandRow(
        "fork",
        "repeat a recorded run up to an instant, then continue with a change",
        f"{FOLDER}.fork.command",
        ("fork",),
        adds={"replay": f"{FOLDER}.fork.command:ADDITION"},
    ),
    CommandRow(
        "report",
        "generate an HTML report of a recorded run",
        pages=("recording",),
        ways={"bag folder": "`bt-mission report {}`"},
    ),
    CommandRow(
        "verify",
        "evaluate requirements on a recording",
        pages=("how-to/requirements", "reference/requirements"),
        ways={"foreign recording": "`bt-mission verify {} --require FILE`"},
        example="  bt-mission verify run.mcap          evaluate the requirements of a recorded run",
    ),
    CommandRow(
        "sweep",
        "run a mission with many seeds, inputs, worlds and faults",
        f"{FOLDER}.sweep.command",
        ("cluster", "sweeps", "ranges"),
        extra="sweep",
        ways={"ranges": "`bt-mission sweep MISSION --within {}`"},
    ),
    CommandRow(
        "sweep-report",
        "show the results of a sweep as tables and an HTML page",
        f"{FOLDER}.sweep.report_command",
        ("sweeps", "cluster"),
        extra="sweep",
        ways={"sweep folder": "`bt-mission sweep-report {}`"},
    ),
    CommandRow(
        "falsify",
        "search for a scenario that breaks a mission",
        f"{FOLDER}.falsify.command",
        ("break-your-mission", "search", "ranges"),
        extra="sweep",
        ways={"ranges": "`bt-mission falsify MISSION --within {}`"},
    ),
    CommandRow(
        "reproduce",
        "turn a recording into a scenario that repeats its run in the simulation",
        f"{FOLDER}.reproduce.command",
        ("from-a-recording-to-a-test", "recording"),
        needs=("falsify",),
        ways=dict.fromkeys(("foreign recording", "bag folder"), "`bt-mission reproduce {}`"),
    ),
    CommandRow(
        "prove",
        "check a mission against every answer that its servers can give",
        f"{FOLDER}.prove.command",
        ("prove-a-mission", "prove", "proofs"),
        adds={
            f"display.{FOLDER}.prove.proof.Proof": f"{FOLDER}.prove.page:page_alone",
            "pytest.prove": f"{FOLDER}.prove.testing:prove",
        },
        hints={"checked": "'bt-mission prove {}' explores every answer of its servers"},
    ),
    CommandRow(
        "diff",
        "show the first difference between the traces of two runs",
        pages=("trace",),
        ways={"trace": "`bt-mission diff {} OTHER`"},
    ),
    CommandRow(
        "explain",
        "explain an error code, such as BT-203, with an example",
        pages=("errors", "troubleshooting"),
    ),
    CommandRow(
        "doctor",
        "check this machine and list what to install",
        pages=("install", "troubleshooting"),
        example="  bt-mission doctor                   check that everything required is installed",
    ),
    CommandRow(
        "docs",
        "show or search the documentation",
        f"{FOLDER}.docs.command",
        adds={"completion.pages": "bt_mission.views.manual:page_names"},
        hints={"page": "bt-mission docs {}"},
        example="  bt-mission docs two robots          search the documentation in the terminal",
    ),
    CommandRow(
        "completion",
        "print the completion script for bash, zsh or fish",
        pages=("command-line-tools",),
    ),
    CommandRow(
        "foxglove",
        module=f"{FOLDER}.foxglove.command",
        pages=("foxglove",),
        extra="web",
        adds={"show": f"{FOLDER}.foxglove.command:ADDITION"},
        hints={
            "watch": "  bt-mission watch --foxglove                 all topics, for Foxglove and "
            "Lichtblick"
        },
    ),
    CommandRow(
        "video",
        module=f"{FOLDER}.video.command",
        pages=("recording",),
        extra="video",
        adds={"recording": f"{FOLDER}.video.command:VIDEO_FILE"},
    ),
)
"""Ours, in the order of the list of commands."""


@cache
def rows() -> Mapping[str, CommandRow]:
    """Return our rows whose folders are there, by name."""
    return {row.name: row for row in ROWS if row.is_there}


@cache
def all_rows() -> Mapping[str, CommandRow]:
    """Return our rows and those of other packages, by name."""
    return {**rows(), **{row.name: row for row in _others()[0]}}


@cache
def _others() -> tuple[tuple[CommandRow, ...], tuple[str, ...]]:
    """Return the rows of other packages, and why others of them cannot be used."""
    usable, unusable = [], []
    for entry in entry_points(ENTRY_POINTS):
        try:
            row = entry.load()
        except Exception as error:  # noqa: BLE001 - whatever the package of somebody else raises
            unusable.append(f"{entry.value}: {type(error).__name__}: {error}")
            continue
        if not isinstance(row, CommandRow):
            unusable.append(f"{entry.value}: expected a CommandRow, got {type(row).__name__}")
        elif why_not := _refusal(row):
            unusable.append(why_not)
        else:
            usable.append(row)
    return tuple(sorted(usable, key=lambda row: row.name)), tuple(unusable)


def _refusal(row: CommandRow) -> str:
    """Return why the row of another package cannot be used; nothing where it can."""
    import tomllib  # noqa: PLC0415 - only for those

    if any(ours.name == row.name for ours in ROWS):
        return f"{row.declared_in}: '{row.name}' is a command of bt-mission"
    if not row.is_there:
        return f"{row.name}: {row.folder} is absent"
    try:
        if row.errors is not None:
            tomllib.loads(row.errors.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        return f"{row.errors}: {type(error).__name__}: {error}"
    return ""


def unusable_rows() -> tuple[str, ...]:
    """Return why rows of other packages cannot be used, a line each."""
    return _others()[1]


def row_of(name: str) -> CommandRow:
    """Return the row of a command, whether its folder is there or not.

    Raises:
        KeyError: No such row exists.
    """
    ours = next((row for row in ROWS if row.name == name), None)
    return ours or all_rows()[name]


def added(point: str) -> Iterator[Any]:
    """Yield what our commands add at an extension point, in the order of the rows."""
    for row in ROWS:
        if point in row.adds and row.is_there:
            yield loaded(row.adds[point])


def points(prefix: str) -> Mapping[str, str]:
    """Return what is added at the points of a prefix, not yet imported, by the rest of the name."""
    return {
        point.removeprefix(prefix): target
        for row in ROWS
        for point, target in row.adds.items()
        if point.startswith(prefix) and row.is_there
    }


def loaded(target: str) -> Any:
    """Import what a ``module:name`` says."""
    module, _, name = target.partition(":")
    return getattr(import_module(module), name)


def ways(kind: str) -> str:
    """Return the commands that take a kind of file, as words; ``{}`` stands for its path."""
    return " or ".join(row.ways[kind] for row in all_rows().values() if kind in row.ways)


def hints(subject: str) -> Sequence[str]:
    """Return what our commands that are there say about a subject, in the order of the rows."""
    return [row.hints[subject] for row in ROWS if subject in row.hints and row.is_there]


def page(name: str, mark: str = "`") -> str:
    """Return how to read a page of the documentation: a command between marks, or its name."""
    return next((f"{mark}{line.format(name)}{mark}" for line in hints("page")), f"the page {name}")


def brought_kinds(known: Mapping[str, CommandRow]) -> Mapping[str, FileFormat]:
    """Return the kinds of files that rows bring, by name."""
    return {name: kind for row in known.values() for name, kind in row.kinds.items()}
