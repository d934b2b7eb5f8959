"""Proofs and simulated runs of proposals: commands in other processes, one at a time."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import write_file
from bt_mission.cli.children import ChildCommand
from bt_mission.commands.agents.folder import Proposal
from bt_mission.commands.agents.site import Site

MOST_WALL_S = 1800.0
PROOF_BUDGET = "60s"
WAIT_S = 20.0
"""Wall time after which a call returns while its job still runs."""

_EVIDENCE_KEYS = (
    *("scenarios", "succeeded", "failed", "errors", "success_rate", "interval", "collisions"),
    *("orphaned_goals", "virtual_s", "distance_m", "failures", "plans", "requirements"),
)


class JobError(BtMissionError):
    """A job that cannot start now, or has not given a result."""

    code = "BT-1409"


@dataclass(frozen=True)
class CommandEnd:
    """The end of a command: its output as JSON, or None, and its lines on standard error."""

    result: Any
    lines: Sequence[str]


Run: TypeAlias = Callable[[Sequence[str]], Awaitable[CommandEnd]]
"""Runs a command of this program."""


async def run_in_child(words: Sequence[str]) -> CommandEnd:
    """Run a command in another process, and end it if it takes too long or nobody waits."""
    child = ChildCommand(None, words)
    try:
        await asyncio.wait_for(child.wait(), MOST_WALL_S)
    except TimeoutError:
        return CommandEnd(None, [f"not done within {MOST_WALL_S:g} s"])
    finally:
        await child.stop()
    return CommandEnd(child.result, child.lines)


@dataclass(frozen=True)
class Trial:
    """Simulated runs that an agent wishes for itself; they are no evidence.

    Attributes:
        seeds: The number of runs of each plan.
        faults: Injected in each run.
    """

    seeds: int
    faults: tuple[str, ...] = ()


class Workbench:
    """Makes the files and words of commands in a separate folder.

    World and robot are those that the site has read, whatever has become of their files.

    Args:
        folder: Empty; a command reads and writes only here.
    """

    def __init__(self, folder: Path, proposal: Proposal, site: Site) -> None:
        self.results = folder / "results"
        self._folder, self._proposal, self._site = folder, proposal, site
        self._mission = folder / f"{proposal.name}.yaml"
        write_file(self._mission, proposal.text)
        world, robot = site.files.write_to(folder / "site")
        self._given = [f"--world={world}", f"--robot={robot}"]
        self._given += [f"--set={name}={value}" for name, value in proposal.inputs.items()]

    def proof(self) -> list[str]:
        """Return the words of a proof."""
        require = self._json("requirements.yaml", self._site.requirements_file())
        return [
            *("prove", str(self._mission), "--json", f"--budget={PROOF_BUDGET}", "--no-python"),
            *(f"--require={require}", *self._given),
        ]

    def runs(self, trial: Trial | None) -> list[str]:
        """Return the words of simulated runs: those of the site, or those of a trial."""
        written = self._site.written
        seeds = self.seeds if trial is None else range(trial.seeds)
        plans = self._site.plans if trial is None else {"trial": list(trial.faults)}
        require = self._json("requirements.yaml", self._site.requirements_file())
        within = self._json("ranges.yaml", {"seeds": list(seeds), "plans": plans})
        return [
            *("sweep", str(self._mission), "--json", "--plain", "--yes", "--no-python"),
            *("--workers=1", "--record-worst=1", f"--output={self.results}"),
            *(f"--require={require}", f"--within={within}", f"--limit={written.limit:g}"),
            *(f"--nature={written.nature}", *self._given),
        ]

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of the runs that are evidence."""
        return self._site.seeds(self._proposal)

    def recordings(self) -> list[Path]:
        """Return the recordings that the runs have left."""
        return sorted(self.results.glob("recordings/*.mcap"))

    @staticmethod
    def picture(recording: Path) -> list[str]:
        """Return the words that draw a recorded run, in a file beside it."""
        return ["report", str(recording), f"--output={recording.with_suffix('.png')}"]

    def _json(self, name: str, data: Any) -> Path:
        path = self._folder / name
        write_file(path, json.dumps(data))
        return path


def kept(end: CommandEnd) -> dict[str, Any]:
    """Return what is kept of the result of simulated runs. Raises JobError without a result."""
    if not isinstance(end.result, dict) or "scenarios" not in end.result:
        raise no_result(end)
    return {key: end.result[key] for key in _EVIDENCE_KEYS if key in end.result}


def no_result(end: CommandEnd) -> JobError:
    """Return the error of a command without a result, with its last lines."""
    return JobError("no result: " + (" | ".join(end.lines[-5:]) or "the command has ended"))
