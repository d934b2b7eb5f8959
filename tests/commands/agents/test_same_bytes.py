"""What is simulated, what a person approves and what the robot drives: the same seed and bytes."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base import files
from bt_mission.base.diagnostics import InputError
from bt_mission.commands.agents.folder import Proposal
from bt_mission.commands.agents.jobs import CommandEnd
from bt_mission.commands.agents.shown import Shown
from bt_mission.commands.agents.site import load_site
from bt_mission.language.expressions.expression import resolve
from bt_mission.language.loader import required
from tests.commands.agents.played import TURN, Played, runs_of

CHOICE = """\
mission: look
tree:
  choose:
    - turn: {angle: 90}
      timeout: 20
    - turn: {angle: -90}
      timeout: 20
  weights: [1000000, 1]
"""
TO_ZONE = """\
mission: look
inputs: {place: zone A}
tree:
  follow_waypoints: {poses: [$place]}
  timeout: 60
"""


def _noted(played: Played, take: Callable[[dict[str, str]], Any]) -> list[Any]:
    """Note what `take` finds in the files that commands get, by their options."""
    read: list[Any] = []
    answer = played.command

    async def command(words: Sequence[str]) -> CommandEnd:
        if words[0] in ("prove", "sweep"):
            read.append(take({**dict(word[2:].split("=", 1) for word in words if "=" in word)}))
        return await answer(words)

    played.command = command  # type: ignore[method-assign]
    played.restart()
    return read


@pytest.mark.parametrize(
    ("text", "more", "seeds"),
    [
        (CHOICE, {"seed": 656_061}, [0, 1, 656_061]),
        (f"seed: 656061\n{CHOICE}", {}, [0, 1, 656_061]),
        (f"seed: 7\n{CHOICE}", {"seed": 2**63 - 1}, [0, 1, 2**63 - 1]),
        (CHOICE, {"seed": 1}, [0, 1]),
        (CHOICE, {}, [0, 1]),
    ],
)
def test_the_seed_of_the_drive_is_simulated_and_shown(
    played: Played, text: str, more: dict[str, Any], seeds: list[int]
) -> None:
    """Besides those of the site; a person reads it, and the robot drives with it."""
    played.answers["sweep"] = runs_of(len(seeds))

    def ranges(options: dict[str, str]) -> Any:
        return (
            json.loads(Path(options["within"]).read_text())["seeds"] if "within" in options else 0
        )

    simulated = _noted(played, ranges)
    played.prepare(text=text, **more)
    assert simulated == [0, seeds]
    drive = more.get("seed", 656_061 if "656061" in text else 0)
    shown = Shown.of(played.folder, played.site, "look")
    assert f"seed {drive}, which is simulated" in " ".join(shown.head)
    played.approve()
    assert played.call("drive", name="look") == {"is_driving": True, "why": ""}
    assert [mission.seed for mission in played.driven] == [drive]


def test_commands_get_the_world_that_was_read(played: Played) -> None:
    """Its file may change while a job runs: the result is that of what the digests are of."""

    def world(options: dict[str, str]) -> str:
        (played.root / "arena.yaml").write_text("another: world\n")
        return Path(options["world"]).read_text()

    before = (played.root / "arena.yaml").read_text()
    read = _noted(played, world)
    played.call("propose", name="look", text=TURN)
    played.call("prove", name="look")
    assert read == [before]
    refused = played.call("simulate", name="look")
    assert "the world has changed" in refused or "arena.yaml" in refused
    assert "[BT-1410]" in refused
    assert read == [before]


def test_a_goal_at_a_zone_is_that_of_the_world_that_was_read(played: Played) -> None:
    """Not of the file as it is when the robot's server reads the mission."""
    path = played.root / "arena.yaml"
    path.write_bytes(files.find("worlds", "nav_arena").read_bytes())
    site = load_site(played.root / "site.yaml")
    path.write_text(path.read_text().replace("x: -1.85, y: -1.76", "x: 1.0, y: -0.5"))
    mission: Any = required(site.examine(Proposal("look", TO_ZONE)))
    sent = resolve(mission.tree.goal, mission.inputs, random.Random(0))
    assert [late.as_value() for late in sent["poses"]] == [[-1.85, -1.76, 0.0]]
    with pytest.raises(Exception, match="the world has changed since this program has read it"):
        site.refuse_changed()


def test_the_files_of_a_model_are_compared(played: Played) -> None:
    """A byte of a mesh, and a file that is gone, are named."""
    model = played.root / "arm.yaml"
    xml = files.find("robots", "waffle_arm").with_suffix(".xml")
    model.write_bytes(files.find("robots", "waffle_arm").read_bytes())
    (played.root / "waffle_arm.xml").write_bytes(xml.read_bytes())
    path = played.root / "site.yaml"
    path.write_text(path.read_text().replace("robot: burger", "robot: arm.yaml"))
    site = load_site(path)
    assert site.files.model == {"waffle_arm.xml": xml.read_bytes()}
    _, robot = site.files.write_to(played.root / "copy")
    assert (robot.parent / "waffle_arm.xml").read_bytes() == xml.read_bytes()
    (played.root / "waffle_arm.xml").write_bytes(xml.read_bytes() + b"\n")
    with pytest.raises(Exception, match=r"the robot's waffle_arm.xml has changed"):
        site.refuse_changed()
    (played.root / "waffle_arm.xml").unlink()
    with pytest.raises(Exception, match=r"the robot's waffle_arm.xml has changed"):
        site.refuse_changed()


def test_a_world_that_is_gone_is_named(played: Played) -> None:
    """The error of the file is part of it."""
    (played.root / "arena.yaml").unlink()
    with pytest.raises(Exception, match=r"no such world.*\[BT-1410\]|no such world"):
        played.site.refuse_changed()
    with pytest.raises(InputError):
        load_site(played.root / "site.yaml")
