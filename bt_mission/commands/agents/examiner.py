"""A process that checks proposals: `stop` waits for no check, and one that takes long is ended.

``python -m bt_mission.commands.agents.examiner SITE.yaml`` reads a proposal from each line of the
standard input, as JSON, and answers each with a line.
"""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias

from bt_mission.base.diagnostics import Diagnostic
from bt_mission.cli.children import started
from bt_mission.commands.agents.folder import Proposal, ProposalError
from bt_mission.commands.agents.site import Site, SiteChangedError, load_site

MOST_WALL_S = 10.0
SMALL = "mission: small\ntree: {navigate_to_pose: {pose: [0, 0, 0]}, timeout: 9}\n"
"""A mission for a first check, which loads what all checks use."""
LONGEST_ANSWER = 50_000_000
"""Bytes."""


@dataclass(frozen=True)
class Examination:
    """The result of the check of a proposal."""

    is_valid: bool
    diagnostics: tuple[Diagnostic, ...]

    @classmethod
    def of(cls, site: Site, proposal: Proposal) -> Examination:
        """Check a proposal in this process."""
        mission, diagnostics = site.examine(proposal)
        return cls(mission is not None, tuple(diagnostics))


Examine: TypeAlias = Callable[[Proposal], Awaitable[Examination]]
"""Checks a proposal for a site."""


class Examiner:
    """Checks proposals for a site in another process, one after another.

    Args:
        most_wall_s: Wall time after which a check is ended.
    """

    def __init__(self, site: Site, most_wall_s: float = MOST_WALL_S) -> None:
        self._site, self._most_wall_s = site, most_wall_s
        self._process: asyncio.subprocess.Process | None = None
        self._turn = asyncio.Lock()

    async def __call__(self, proposal: Proposal) -> Examination:
        """Check a proposal.

        Raises:
            ProposalError: The check has taken too long, or its process has ended.
            SiteChangedError: The process has read other files than this one.
        """
        async with self._turn:
            try:
                process = await self._ready()
                line = await asyncio.wait_for(_answer(process, proposal), self._most_wall_s)
            except TimeoutError:
                await self.close()
                raise ProposalError(
                    f"the check has not ended within {self._most_wall_s:g} s: write a mission with "
                    "fewer nodes and poses"
                ) from None
            except asyncio.CancelledError:
                await self.close()
                raise
        if not line:
            await self.close()
            raise ProposalError("the check has ended without a result")
        answer = json.loads(line)
        if answer["site"] != self._site.digest:
            raise SiteChangedError(f"{self._site.file} has changed: start this program again")
        diagnostics = tuple(Diagnostic(**each) for each in answer["diagnostics"])
        return Examination(answer["is_valid"], diagnostics)

    async def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            with suppress(ProcessLookupError):
                process.kill()
            await process.wait()

    async def _ready(self) -> asyncio.subprocess.Process:
        if self._process is None:
            file = str(self._site.file.absolute())
            process = await started(
                "bt_mission.commands.agents.examiner",
                file,
                longest_line=LONGEST_ANSWER,
                is_quiet=True,
            )
            self._process = process
            assert process.stdout is not None
            await process.stdout.readline()
        return self._process


async def _answer(process: asyncio.subprocess.Process, proposal: Proposal) -> bytes:
    assert process.stdin is not None
    assert process.stdout is not None
    with suppress(ConnectionError):
        process.stdin.write(json.dumps(asdict(proposal)).encode() + b"\n")
        await process.stdin.drain()
    return await process.stdout.readline()


def main() -> None:
    """Answer each line of the standard input."""
    site = load_site(Path(sys.argv[1]))
    site.examine(Proposal("small", SMALL))
    _write({})
    for line in sys.stdin:
        examination = Examination.of(site, Proposal(**json.loads(line)))
        _write({"site": site.digest, **asdict(examination)})


def _write(answer: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
