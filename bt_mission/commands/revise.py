"""``bt-mission revise``: continue a running mission with another version of its file."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING, Any

from bt_mission.cli.argument_types import seconds
from bt_mission.cli.executives import look_for
from bt_mission.cli.exits import MISSION_FAILED, SUCCESS
from bt_mission.cli.options import JSON, MISSION, NETWORK, mission_file, prepare_graph
from bt_mission.cli.parser import Command, Option

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission

ANSWER_S = 20.0
"""Wall time to wait for the response: the executive checks the new version first."""

YAML = (".yaml", ".yml")

EPILOG = """\
examples:
  bt-mission run mine.yaml --editable --speed 1      in one terminal
  bt-mission revise mine.yaml --dry-run              in another: what would change
  bt-mission revise mine.yaml                        change it
  bt-mission revise robot1 mine.yaml --json | jq .cancels

exit codes: 0 applied, or can be applied; 1 refused, with the reason, or no such mission; 2 bad
input, such as a file with errors
"""


def revise(options: argparse.Namespace) -> int:
    """Send the new version; return the exit code.

    The executive checks it. One that it refuses is checked here, too, where errors have places.
    """
    request = _request(options)
    prepare_graph(options)
    from bt_mission.ros.discovery import ExecutiveDirectory

    with ExecutiveDirectory() as graph:
        executive = look_for(graph, options)
        if executive is None:  # the reason was printed
            _examined(options)
            print("Only missions that run with --editable can be changed", file=sys.stderr)
            return _refused(options, f"{options.executive or 'an executive'} was not found")
        answer = graph.revise(executive.name, request, ANSWER_S)
    if answer is None or not answer.success:
        _examined(options)
    if answer is None:
        print(f"{executive.name}/revise does not answer", file=sys.stderr)
        return _refused(options, f"{executive.name}/revise does not answer")
    if not options.json:
        print(answer.message, file=sys.stdout if answer.success else sys.stderr)
    elif not answer.revision:
        return _refused(options, answer.message)
    else:
        print(answer.revision)
    return SUCCESS if answer.success else MISSION_FAILED


def _refused(options: argparse.Namespace, reason: str) -> int:
    """Print the result of a version that no executive has taken; return the exit code."""
    if options.json:
        print(json.dumps({"is_applied": False, "reasons": [reason]}))
    return MISSION_FAILED


def _examined(options: argparse.Namespace) -> Mission:
    """Check the file here, so that its errors show their places; Python code is not imported.

    The executive knows the world, and checks the names of places.

    Raises:
        InputError: With every error.
    """
    from bt_mission.language.loader import required
    from bt_mission.language.permissions import Permissions
    from bt_mission.sessions.check import ELSEWHERE, examine

    path = mission_file(options)
    permissions = Permissions(python="name")
    return required(examine(path, servers=None, permissions=permissions, given=ELSEWHERE))


def _request(options: argparse.Namespace) -> Any:
    """Return the request; only a file that may include others is examined, which takes a second.

    Raises:
        InputError: It cannot be read.
    """
    from bt_mission.base.yaml.document import read_source

    path, included = mission_file(options), {}
    text = read_source(path) if path.suffix in YAML else "include"
    if "include" in text:
        mission = _examined(options)
        text = mission.document.text
        included = {mission.portable_name(each.file): each.text for each in mission.included}
    from bt_mission_interfaces.srv import ReviseMission

    return ReviseMission.Request(
        file=str(path),
        text=text,
        include_names=list(included),
        include_texts=list(included.values()),
        dry_run=options.dry_run,
        keep_goals=options.keep_goals,
    )


COMMANDS = {
    "revise": Command(
        revise,
        "Sends a new version of a mission to the executive that runs it (`run --editable`, "
        "`serve --editable`). Prints which nodes change, are new and are gone, and which goals "
        "that touches. The change is applied between two ticks: nodes that stay continue with "
        "their goals; goals of nodes that change or are gone are cancelled, and no goal is sent "
        "before these have ended. A version that the running mission cannot become is refused, "
        "and nothing changes.",
        (
            Option(
                "executive",
                "name or namespace of the executive, such as /robot1/bt_mission or robot1, or the "
                "name of the mission that it runs (default: the only one)",
                nargs="?",
                completes="executives",
            ),
            MISSION,
            Option("--dry-run", "only print what would change"),
            Option(
                "--keep-goals",
                "let running goals of nodes that change finish with their present values",
            ),
            JSON,
            Option(
                "--wait SECONDS",
                "wait at most this time for the executive (default: 5)",
                seconds,
                5.0,
            ),
            NETWORK,
        ),
        EPILOG,
    )
}
