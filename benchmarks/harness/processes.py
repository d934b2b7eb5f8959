"""The processes of a benchmark: started one after another, ended with all that they started."""

from __future__ import annotations

import asyncio
import os
import signal
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness.benchmark import Benchmark
from benchmarks.harness.measurement import Given, WrongCodeError, read_figures
from benchmarks.harness.starting import ForkStarter, Start, Starter
from benchmarks.harness.tree import Tree
from benchmarks.measuring import FIGURES_FILE, NOT_SOUND

LAST_LINES = 12
"""How much of its output is shown of a process that has failed."""

DOMAINS = 102
"""DDS domain ids that do not reach into Linux' range of ephemeral ports."""


class FailedError(Exception):
    """A process of a benchmark has failed; the message has the end of its output."""


class NotSoundError(FailedError):
    """A benchmark has run, and found what should not be."""


@dataclass(frozen=True)
class Round:
    """How one round of a benchmark is run.

    Args:
        rounds: That the script itself does.
        smoke: As small as it can be.
        quiet: Keep its output, and show it only where it fails.
        limit_s: It has failed when it takes longer, on the wall; None waits for ever.
        slot: Of those that run at the same time; each has its own ROS domain.
    """

    rounds: int = 1
    smoke: bool = False
    quiet: bool = True
    limit_s: float | None = None
    slot: int = 0


async def run_round(
    benchmark: Benchmark, how: Round, tree: Tree, *, scripts: Path, starter: Starter | ForkStarter
) -> dict[str, Given]:
    """Start the processes of a benchmark one after another; gives their figures.

    Args:
        benchmark: What is run.
        how: How it is.
        tree: The software that is measured; its folder is the working folder.
        scripts: The folder of the scripts.
        starter: Starts its processes.

    Raises:
        FailedError: Where one ends with an error, takes too long or measures something else.
    """
    with tempfile.TemporaryDirectory(prefix="benchmark_") as name:
        folder = Path(name)
        figures = folder / "figures.jsonl"
        environment = _environment(tree, how, figures)
        for script, *arguments in benchmark.processes(how.rounds, folder, smoke=how.smoke):
            command = [str(scripts / script), *arguments]
            output = folder / "output" if how.quiet else None
            try:
                async with asyncio.timeout(how.limit_s):
                    await _run(Start(command, tree.root, environment, output), starter)
            except TimeoutError:
                raise FailedError(
                    f"{script} did not end within {how.limit_s:g} s{_end_of(output)}"
                ) from None
        try:
            return read_figures(figures, tree.root)
        except WrongCodeError as error:
            raise FailedError(str(error)) from error


def _environment(tree: Tree, how: Round, figures: Path) -> dict[str, str]:
    variables = tree.environment() | {FIGURES_FILE: str(figures), "PYTHONUNBUFFERED": "1"}
    variables.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if how.slot:
        domain = int(variables.get("ROS_DOMAIN_ID") or 0) + how.slot
        variables["ROS_DOMAIN_ID"] = str(domain % DOMAINS)
    return variables


async def _run(what: Start, starter: Starter | ForkStarter) -> None:
    """Run a process to its end, and kill what it has started and left, however this ends."""
    process = await starter.start(what)
    try:
        code = await process.wait()
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
    if code:
        script = Path(what.command[0]).name
        ended = f"exit code {code}" if code > 0 else f"signal {-code}"
        kind = NotSoundError if code == NOT_SOUND else FailedError
        raise kind(f"{script} ended with {ended}{_end_of(what.output)}")


def _end_of(output: Path | None) -> str:
    """The last lines of what a process has said, each indented; nothing where it was shown."""
    if output is None or not output.exists():
        return ""
    lines = output.read_text(encoding="utf-8", errors="replace").splitlines()[-LAST_LINES:]
    return ":\n" + "\n".join(f"    {line}" for line in lines) if lines else ""
