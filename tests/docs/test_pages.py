"""What pages of the documentation list and show is what the program has and does."""

from __future__ import annotations

import math
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base import files
from bt_mission.base.yaml.document import read, read_text
from bt_mission.cli import main
from bt_mission.cli.argument_types import FileType
from bt_mission.cli.main import make_parser
from bt_mission.requirements.checks import with_requirements
from bt_mission.requirements.language.formula import Formula, vacuous_verdict
from bt_mission.requirements.language.parser import JOINING
from bt_mission.requirements.language.signals import SIGNALS
from bt_mission.robots.model import load_robot
from bt_mission.scenarios.concrete.ranges import FaultRanges, ObstacleRanges, Ranges, RangesFile
from bt_mission.scenarios.faults import parse_fault
from bt_mission.sessions.load import load
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world
from tests.support.project import ROOT
from tools.make_generated import GENERATED


def page(name: str) -> str:
    """The text of a page of docs/."""
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def blocks(text: str, language: str) -> list[str]:
    """The blocks of a page in a language."""
    matches = re.findall(r"^```([^\n]*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [block for name, block in matches if name == language]


@pytest.mark.parametrize("path", GENERATED, ids=lambda path: path.name)
def test_a_generated_file_is_up_to_date(path: Path) -> None:
    """`make generated` writes it."""
    text = path.read_text(encoding="utf-8")
    assert GENERATED[path](text) == text


# ---- the README ------------------------------------------------------------------------------

SHELL = [
    [line for line in block.splitlines() if line.startswith("bt-mission ")]
    for block in re.findall(
        r"^```\w*\n(.*?)^```", (ROOT / "README.md").read_text("utf-8"), re.MULTILINE | re.DOTALL
    )
]


@pytest.mark.parametrize("lines", [*filter(None, SHELL)])
def test_what_a_command_reads_is_there(lines: list[str]) -> None:
    """In the checkout, by its name, or made by a line above."""
    made: set[str] = set()
    parser = make_parser()
    for line in lines:
        words = shlex.split(line.partition(" | ")[0].partition(" > ")[0], comments=True)[1:]
        options = parser.parse_args(words)
        for option in options.parser.options:
            given = getattr(options, option.attribute, None) or []
            if not isinstance(option.type, FileType):
                continue
            for path in given if isinstance(given, list) else [given]:
                if option.type.role != "input":
                    made.add(str(path))
                else:
                    known = files.look_for("missions", path) or "*" in path.name
                    assert str(path) in made or known or (ROOT / path).is_file(), line


# ---- fleets ----------------------------------------------------------------------------------

FLEETS = page("how-to/fleet.md")
FLEET = "fleets/two_wanderers.fleet.yaml"
WALL_TIME = re.compile(r"in [\d.]+ s of wall time \([\d.]+ x")


def test_the_fleet_is_the_shipped_one() -> None:
    """Apart from its comment."""
    text, _ = blocks(FLEETS, "yaml")
    assert read_text(text).data == read(files.find("missions", FLEET)).data


@pytest.mark.thorough
def test_the_output_of_the_fleet_is_that_of_a_run(capsys: pytest.CaptureFixture[str]) -> None:
    """Apart from wall time."""
    shown = next(block for block in blocks(FLEETS, "") if block.startswith("two wanderers in"))
    first, last = shown.split("...\n")
    assert main(["run", FLEET, "--plain"]) == 0
    out = WALL_TIME.sub("in W (F x", capsys.readouterr().out)
    assert out.startswith(first)
    assert out.endswith(WALL_TIME.sub("in W (F x", last))


@pytest.mark.thorough
def test_the_code_for_fleets_works(tmp_path: Path) -> None:
    """As it stands there."""
    test, steps = blocks(FLEETS, "python")
    names: dict[str, Any] = {
        "tmp_path": tmp_path,
        "distance": lambda pose, other: math.dist(pose[:2], other[:2]),
    }
    exec(compile(test + "\ntest_they_keep_apart()\n", "fleet.md", "exec"), names)  # noqa: S102 - the page's own code
    exec(compile(steps, "fleet.md", "exec"), names)  # noqa: S102 - the page's own code
    assert names["stage"].is_done


# ---- requirements ----------------------------------------------------------------------------

REQUIREMENTS = page("reference/requirements.md")
MISSION = blocks(REQUIREMENTS, "yaml")[0]


def test_the_mission_has_its_requirements_and_those_of_a_file(tmp_path: Path) -> None:
    """All five, and that of the file behind them."""
    file = tmp_path / "slow.yaml"
    file.write_text(blocks(REQUIREMENTS, "yaml slow.yaml")[0])
    mission = load(MISSION)
    assert len(mission.requirements) == 5
    names = [requirement.name for requirement in with_requirements(mission, [file]).requirements]
    assert (len(names), names[-1]) == (6, "is slow")


@pytest.mark.parametrize("form", blocks(REQUIREMENTS, "yaml-requirement"))
def test_a_requirement_in_parts_is_one(form: str) -> None:
    """A mapping below a name, put into the mission of the page."""
    indented = "".join(f"  {line}\n" for line in form.splitlines())
    mission = load(re.sub(r"  keeps .*?(?=tree:)", lambda _: indented, MISSION, flags=re.DOTALL))
    (requirement,) = mission.requirements
    assert (requirement.on_violation, vacuous_verdict(requirement)) != ("report", "not exercised")


@pytest.mark.parametrize("text", "".join(blocks(REQUIREMENTS, "requirements")).splitlines())
def test_an_example_is_a_requirement(text: str) -> None:
    """It is parsed, and its types, units and windows fit."""
    assert Formula(text).text == text


def test_every_signal_and_word_is_described() -> None:
    """In a table or an example."""
    code = "".join(re.findall(r"`[^`]*`|```.*?```", REQUIREMENTS, re.DOTALL))
    assert set(SIGNALS) | JOINING <= set(re.findall(r"[A-Za-z_.]+", code))


# ---- faults and ranges -------------------------------------------------------------

SCENARIOS, RANGES = (page(f"reference/{n}.md") for n in ("scenarios", "ranges"))
ON_COMMAND_LINE = re.findall(r"--fault '([^']*)'", SCENARIOS)


@pytest.mark.parametrize(
    "text", ["".join(blocks(SCENARIOS, "faults")).splitlines(), ON_COMMAND_LINE], ids=len
)
def test_the_faults_are_read(text: list[str]) -> None:
    """Those of files, and those behind `--fault`."""
    assert len(text) >= 2
    assert all(parse_fault(line).text for line in text)


def test_the_file_of_ranges_is_read() -> None:
    """The example of the page."""
    texts = blocks(RANGES, "yaml")
    pattern = re.compile(r"(# ranges.yaml\n)?(seeds|inputs):")
    ranges = [RangesFile(read_text(text)) for text in texts if pattern.match(text)]
    assert len(ranges) == 1


def test_every_key_of_ranges_has_a_row() -> None:
    """With its default."""
    parts = {"obstacles": ObstacleRanges.model_fields, "faults": FaultRanges.model_fields}
    for key in Ranges.model_fields:
        for inner in parts.get(key, ()):
            assert re.search(rf"^\| [^|]*`({key})?\.{inner}`", RANGES, re.MULTILINE), inner
        assert key in parts or f"| `{key}` |" in RANGES


# ---- robots ----------------------------------------------------------------------------------

YOUR_ROBOT = page("how-to/your-robot.md")


def test_the_robot_of_the_page_slides_on_three_wheels() -> None:
    """To the left, and to no other side; it sees all around."""
    [example] = blocks(YOUR_ROBOT, "yaml")
    robot = load_robot(read_text(example, "trike.yaml"))
    assert (len(robot.drive.places), len(robot.all_lidars), robot.sees_behind) == (3, 2, True)
    simulation = Simulation(load_world("empty_arena"), [RobotSpawn(robot)], seed=1)
    driven = simulation.robots[0]
    for _ in range(40):
        driven.command(0.0, 0.0, 0, 0.2)
        simulation.advance_to(driven.physics.time_ns + 50_000_000)
    assert driven.pose == pytest.approx((0.0, 0.38, 0.0), abs=0.01)


def test_the_page_lists_every_shipped_robot() -> None:
    """Each by its name."""
    assert [name for name in files.names("robots") if f"`{name}`" not in YOUR_ROBOT] == []
