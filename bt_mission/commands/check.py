"""``bt-mission check``: mistakes in files, before anything moves."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base.commands import hints, loaded
from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import (
    MISSIONS,
    PLAIN,
    RUNS,
    format_named,
    format_of,
    refuse_other_formats,
)
from bt_mission.base.files import docs_folder, kind_of
from bt_mission.base.text import counted
from bt_mission.cli.checked import examine_options, examined_file, examined_fleet, goes_to_a_graph
from bt_mission.cli.exits import BAD_INPUT, SUCCESS
from bt_mission.cli.options import (
    JSON,
    MISSION,
    NETWORK,
    NO_PYTHON,
    OVERRIDES,
    REQUIRE,
    mission_file,
    prepare_graph,
)
from bt_mission.cli.parser import Command, Option, each, refuse_for_kind

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission


def check_files(options: argparse.Namespace) -> int:
    """Print every diagnostic of every file, or that it is valid; the exit code is the worst."""
    each = [argparse.Namespace(**vars(options), file=file) for file in options.files]
    if options.json:
        return _check_for_programs(each)
    codes = [_check_file(of_file) for of_file in each]
    if len(codes) > 1:
        kinds = {format_of(mission_file(of_file)) for of_file in each}
        what = "missions" if kinds <= {*MISSIONS, None} else "files"
        print(f"{codes.count(SUCCESS)} of {len(codes)} {what} are valid")
    return max(codes)


def _check_file(options: argparse.Namespace) -> int:
    """Print every diagnostic, or that the file is valid."""
    from bt_mission.base.diagnostics import InputError

    try:
        model, warnings = _located(options)
    except InputError as error:
        print(error, file=sys.stderr)
        count = sum(each.severity == "error" for each in error.diagnostics)
        first = next((each.code for each in error.diagnostics if each.severity == "error"), "")
        print(f"{counted(count, 'error')}; see 'bt-mission explain {first}'", file=sys.stderr)
        return BAD_INPUT
    for warning in warnings:
        print(warning, file=sys.stderr)
    kind = kind_to_check(mission_file(options))
    print(f"{model.file}: {kind} '{model.name}' is valid ({_summary(kind, model)})")
    if kind in ("mission", "scenario"):
        _explain_windows(model if kind == "mission" else model.mission)
    code = _check_against(model, options) if options.against or options.graph else SUCCESS
    is_alone = kind == "mission" and len(options.files) == 1
    if code == SUCCESS and is_alone and sys.stdout.isatty():
        _print_hints(model, options.file)
    return code


def _print_hints(mission: Mission, file: str) -> None:
    """Print which commands find more, for a mission with goals."""
    from bt_mission.language.nodes.action import GoalNode
    from bt_mission.language.trees import all_steps

    if any(isinstance(step, GoalNode) for step in all_steps(mission)):
        for hint in hints("checked"):
            print(f"  {hint.format(file)}")


def kind_to_check(path: Path) -> str:
    """Return the kind of a file that can be checked.

    Raises:
        InputError: It is recognized as one that cannot.
    """
    kind = format_of(path)
    if kind is not None and format_named(kind).check:
        return kind
    refuse_other_formats(path, (*RUNS, *PLAIN))
    return kind_of(path)


def _summary(kind: str, model: Any) -> str:
    """Return what a valid file holds."""
    if kind == "mission":
        return counted(sum(1 for _ in model.tree.walk()), "node")
    if kind == "fleet":
        each = (f"{robot.name}: {robot.mission.name}" for robot in model.robots)
        return f"{counted(len(model.robots), 'robot')}; {', '.join(each)}"
    if kind == "scenario":
        requirements = counted(len(model.mission.requirements), "requirement")
        faults = counted(len(model.faults), "fault")
        return f"mission '{model.mission.name}', {faults}, {requirements}"
    return str(model.summary)


def _explain_windows(mission: Any) -> None:
    """Print which requirements decide nothing at first, since they look back further than that."""
    from bt_mission.requirements.language.formula import full_after, root_of

    for requirement in mission.requirements:
        if full_s := full_after(root_of(requirement)):
            print(
                f"  requirement {requirement.name}: its window that looks back is full at "
                f"{full_s:g} s and decides nothing before; with 'so far' it counts from the start"
            )


def _located(options: argparse.Namespace) -> tuple[Any, tuple[Any, ...]]:
    """Load and check a file; an error without a place in it is one of the whole file.

    Raises:
        InputError: With every error.
    """
    from bt_mission.base.diagnostics import Diagnostic, InputError

    try:
        return _checked(options)
    except InputError:
        raise
    except BtMissionError as error:
        raise InputError([Diagnostic(error.code, str(error), str(options.file))]) from error


def _checked(options: argparse.Namespace) -> tuple[Any, tuple[Any, ...]]:
    """Load and check a file; names in a scenario's faults are looked for on its stage."""
    kind = kind_to_check(mission_file(options))
    refuse_for_kind(options, kind)
    if check := format_named(kind).check:
        checked: tuple[Any, tuple[Any, ...]] = loaded(check)(
            mission_file(options), options.robot, options.world
        )
        return checked
    if kind == "fleet":
        return examined_fleet(options)
    examined, diagnostics = examined_file(options)
    if kind == "scenario":
        from bt_mission.scenarios.run import look_for_names

        # A stage imports all Python code that the files name.
        if all(diagnostic.code != "BT-217" for diagnostic in diagnostics):
            look_for_names(examined)
        return examined, diagnostics
    if goes_to_a_graph(options):
        return examined, diagnostics
    from bt_mission.base.diagnostics import InputError, in_order
    from bt_mission.sessions.stage_checks import stage_problems

    diagnostics = in_order([*diagnostics, *stage_problems(examined)])
    if any(each.severity == "error" for each in diagnostics):
        raise InputError(diagnostics)
    return examined, diagnostics


def _check_against(mission: Any, options: argparse.Namespace) -> int:
    """Print what a graph has of what the mission uses."""
    from bt_mission.ros.graph_check import find_missing, find_missing_in

    if options.graph:
        findings = find_missing_in(options.graph, mission, options.namespace)
    else:
        prepare_graph(options)
        findings = find_missing(mission, options.namespace)
    width = max((len(finding.wanted.name) for finding in findings), default=0)
    for finding in findings:
        sign = "there" if finding.is_there else "of another type" if finding.types else "missing"
        wanted = finding.wanted
        print(f"  {wanted.what:7}  {wanted.name:{width}}  {wanted.type}  {sign}")
    missing = [finding.diagnostic() for finding in findings if not finding.is_there]
    for diagnostic in missing:
        print(diagnostic, file=sys.stderr)
    print(f"{len(findings) - len(missing)} of {len(findings)} are in the graph")
    refused = options.against and _print_refusals(options)
    return BAD_INPUT if missing or refused else SUCCESS


def _print_refusals(options: argparse.Namespace) -> bool:
    """Print which goals the servers of a graph refuse by their parameters; tell if there is one."""
    from action_servers.server.node import NODE_NAME
    from bt_mission.ros.graph_check import find_servers
    from bt_mission.sessions.goal_checks import limiting_parameters, with_parameters

    servers = find_servers(NODE_NAME, limiting_parameters(), options.namespace)
    if servers is None:
        print(f"no node {NODE_NAME} answers, so the limits of goals were not checked")
        return False
    settings = with_parameters(servers.parameters, servers.actions)
    known = set(examine_options(options, None)[1])
    refused = [each for each in examine_options(options, settings)[1] if each not in known]
    for diagnostic in refused:
        print(diagnostic, file=sys.stderr)
    print(f"goals that do not fit the limits of {NODE_NAME}: {len(refused)}")
    return any(each.severity == "error" for each in refused)


def _check_for_programs(each: Sequence[argparse.Namespace]) -> int:
    """Print all diagnostics as one JSON list."""
    import json

    from bt_mission.base.diagnostics import InputError

    diagnostics: list[Any] = []
    code = SUCCESS
    for options in each:
        try:
            diagnostics += _located(options)[1]
        except InputError as error:
            diagnostics += error.diagnostics
            code = BAD_INPUT
    objects = [{**each.as_dict(), "url": _url_of(each.code)} for each in diagnostics]
    print(json.dumps(objects, indent=2))
    return code


def _url_of(code: str) -> str | None:
    """Return where a page explains a code; None where the pages are not installed."""
    from bt_mission.base.error_catalogue import page_of

    folder = docs_folder()
    return f"{(folder / page_of(code)).as_uri()}#{code.lower()}" if folder else None


COMMANDS = {
    "check": Command(
        check_files,
        "Checks missions against the real ROS types, worlds and robots, and prints every error "
        "with its file, line and column. Nothing moves, and no code of a mission runs unless "
        "--import-python is given. Also checks files of worlds, robots, requirements and ranges.",
        (
            MISSION.but(
                form="files file",
                nargs="+",
                takes=(),
                type=Path,
                help="files of missions, scenarios, fleets, worlds, robots, requirements or "
                "ranges (the content decides), XML files of Groot 2, or names of shipped missions",
            ),
            *OVERRIDES,
            REQUIRE,
            Option(
                "--import-python",
                "import and check the missions' Python leaves and nodes, which runs their code "
                "(default: only list them)",
            ),
            NO_PYTHON,
            JSON.but(
                help="print a JSON list with an object for each error and warning, for editors "
                "and programs"
            ),
            Option(
                "--against",
                "also check that the running ROS graph has the mission's actions, services and "
                "topics, and that its servers accept the mission's goals",
                not_for=each(
                    *PLAIN, "scenario", "fleet", why="only missions can be compared with a graph"
                ),
            ),
            Option(
                "--graph FILE",
                "also check that a saved listing of a graph has them: lines of 'ros2 action list "
                "-t', 'ros2 service list -t' and 'ros2 topic list -t'" + "".join(hints("listing")),
                type=Path,
                not_for=each(
                    *PLAIN, "scenario", "fleet", why="only missions can be compared with a graph"
                ),
                excludes=each("against", why="it compares with the running graph"),
            ),
            Option(
                "--namespace NAMESPACE",
                "with --against and --graph: the robot's namespace (default: none)",
                completes="namespaces",
            ),
            NETWORK,
        ),
    ),
}
