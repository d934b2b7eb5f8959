"""``bt-mission verify``: requirements over a recording."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import MISSIONS
from bt_mission.base.text import escape_control, seconds
from bt_mission.cli.argument_types import input_file
from bt_mission.cli.exits import MISSION_FAILED, SUCCESS, UNKNOWN
from bt_mission.cli.options import JSON, RECORDING, REQUIRE, mission_file, recorded_robot
from bt_mission.cli.parser import Command, Option

if TYPE_CHECKING:
    from bt_mission.language.mission import Requirement
    from bt_mission.recording.verification import RecordedRequirements, Verification

EPILOG = """\
examples:
  bt-mission run missions/explore.yaml --record explore.mcap
  bt-mission verify explore.mcap                      the recorded requirements
  bt-mission verify explore.mcap --require slow.yaml  and more requirements of a file
  bt-mission verify explore.mcap --mission new.yaml   the requirements of another mission file
  bt-mission verify drive_0.mcap --require slow.yaml  a recording of any robot (ros2 bag record)

slow.yaml:
  requirements:
    is slow: always speed < 0.3

exit codes: 0 none fails; some may be open because the run ended before they were decided
            1 at least one is violated or not exercised
            2 bad input
            3 at least one cannot be determined from this recording, and none fails
"""


def verify(options: argparse.Namespace) -> int:
    """Evaluate the requirements; gives the exit code."""
    from bt_mission.recording.reading import is_recording
    from bt_mission.recording.robots import recorded_robots

    if not is_recording(options.file):
        raise BtMissionError(
            f"{options.file}: a trace does not contain the signals of a run; use a recording "
            f"(bt-mission run --record)",
            code="BT-1102",
        )
    robots = [options.robot] if options.robot else recorded_robots(options.file)
    if len(robots) == 1:
        recorded, verification = _verified(options, options.robot)
        if options.json:
            print(json.dumps(_as_dict(options, recorded, verification)))
        else:
            print("\n".join(map(escape_control, _lines(options, recorded, verification))))
        return _code([verification])
    each = {
        robot: _verified(options, robot)
        for robot in robots
        if options.require or options.mission or _has_requirements(options, robot)
    }
    if not each:
        raise BtMissionError(
            f"{options.file}: no recorded mission has requirements; add some with --require FILE",
            code="BT-1102",
        )
    if options.json:
        objects = [{"robot": name, **_as_dict(options, *pair)} for name, pair in each.items()]
        print(json.dumps({"recording": str(options.file), "robots": objects}))
    else:
        for robot, verified in each.items():
            first, *others = _lines(options, *verified)
            name = f"{options.file}: {robot}: "
            lines = [first.replace(f"{options.file}: ", name, 1), *others]
            print("\n".join(map(escape_control, lines)))
    return _code([verification for _, verification in each.values()])


def _has_requirements(options: argparse.Namespace, robot: str) -> bool:
    from bt_mission.recording.verification import RecordedRequirements

    return bool(RecordedRequirements(options.file, options.namespace, robot).own())


def _verified(
    options: argparse.Namespace, robot: str | None
) -> tuple[RecordedRequirements, Verification]:
    from bt_mission.recording.verification import RecordedRequirements

    recorded = RecordedRequirements(options.file, options.namespace, robot)
    return recorded, recorded.verify(_requirements(options, recorded))


def _code(verifications: Sequence[Verification]) -> int:
    """Return the exit code: the worst of all."""
    from bt_mission.base.verdicts import FAILING

    verdicts = {result.verdict for each in verifications for result in each.results}
    if verdicts & FAILING:
        return MISSION_FAILED
    is_open = any(
        each.why_cut and result.verdict == "open"
        for each in verifications
        for result in each.results
    )
    return UNKNOWN if "unknown" in verdicts or is_open else SUCCESS


def _requirements(
    options: argparse.Namespace, recorded: RecordedRequirements
) -> tuple[Requirement, ...]:
    """Return the requirements to evaluate. Raises BtMissionError where there are none."""
    from bt_mission.base.diagnostics import InputError
    from bt_mission.requirements.checks import diagnostics_of_names, read_requirements
    from bt_mission.sessions.load import load

    if options.mission:
        mission = load(mission_file(argparse.Namespace(file=options.mission)))
        assert mission.document is not None, "it comes from a file"
        if wrong := [*diagnostics_of_names(mission.document, recorded.names)]:
            raise InputError(wrong)
        own = mission.requirements
    else:
        own = recorded.own()
    more = read_requirements(options.require, recorded.names)
    requirements = {requirement.name: requirement for requirement in (*own, *more)}
    if requirements:
        return tuple(requirements.values())
    if options.mission:
        why = f"{options.mission} has no requirements"
    elif recorded.is_of_mission:
        why = "the recorded mission has no requirements"
    else:
        why = "contains no mission, so no requirements"
    raise BtMissionError(f"{options.file}: {why}; add some with --require FILE", code="BT-1102")


def _as_dict(
    options: argparse.Namespace, recorded: RecordedRequirements, verification: Verification
) -> dict[str, Any]:
    return {
        "recording": str(options.file),
        "mission": recorded.mission,
        "requirements": [asdict(result) for result in verification.results],
        "notes": list(verification.notes),
        "recording_lacks": "; ".join(filter(None, (verification.why_cut, verification.lacks))),
    }


def _lines(
    options: argparse.Namespace, recorded: RecordedRequirements, verification: Verification
) -> list[str]:
    what = recorded.mission or "no mission"
    lines = [f"{options.file}: {what}, {seconds(recorded.duration_s)}"]
    lines += [f"  {note}" for note in verification.notes]
    lines += [f"  requirement {result}" for result in verification.results]
    if verification.why_cut:
        lines.append(f"  {verification.why_cut}")
    if verification.lacks:
        lines.append(f"  it lacks {verification.lacks}")
    return lines


COMMANDS = {
    "verify": Command(
        verify,
        "Evaluates requirements on a recording: the recorded ones (bt-mission run --record), and "
        "those of files. For a simulated run, verdicts, margins and times equal those of the "
        "run. A recording of any other robot (ros2 bag record) is evaluated every 0.05 s; "
        "signals that no topic provides are unknown, with the reason.",
        (
            RECORDING.but(help="a recording (MCAP), or the folder of a bag"),
            REQUIRE.but(
                help="a YAML file with more requirements, which replace recorded ones of the "
                "same name; may be repeated"
            ),
            Option(
                "--mission FILE",
                "use the requirements of this mission file instead of the recorded ones",
                input_file,
                completes="missions",
                takes=MISSIONS,
            ),
            Option(
                "--namespace NAME",
                "namespace of the robot's topics (default: that of the recorded mission)",
                completes="namespaces",
            ),
            recorded_robot("all"),
            JSON.but(help="print one JSON object"),
        ),
        EPILOG,
    )
}
