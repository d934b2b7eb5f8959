"""A site of agents: its file, missions, the server that obeys permits, and scripted commands."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from mcp.client import Client
from mcp.shared.exceptions import MCPError

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.agents.approval_page import ApprovalServer
from bt_mission.commands.agents.evidence import evidence_of
from bt_mission.commands.agents.examiner import Examination
from bt_mission.commands.agents.folder import AgentFolder, Proposal
from bt_mission.commands.agents.gateway import AgentGateway
from bt_mission.commands.agents.jobs import WAIT_S, CommandEnd
from bt_mission.commands.agents.permits import Permit, grant
from bt_mission.commands.agents.permitted import PERMIT, PermittedMissions
from bt_mission.commands.agents.server import agent_server
from bt_mission.commands.agents.site import Site, load_site
from tests.support.web_pages import play_with

SITE = """\
site: lab
robot: burger
world: arena.yaml
requirements:
  keeps clear: always clearance > 0.05
  is slow: always speed < 0.3
seeds: 2
"""
TURN = """\
mission: look
tree:
  turn: {angle: 90}
  timeout: 20
"""
HOLDS = {"violated": 0, "open": 0, "unknown": 0, "least_margin": 0.2, "unit": "m"}


def runs_of(count: int) -> dict[str, Any]:
    """Return what `sweep` prints of so many runs that hold everything."""
    holds = {name: {"holds": count, **HOLDS} for name in ("keeps clear", "is slow")}
    ends = {"scenarios": count, "succeeded": count, "failed": 0, "errors": 0}
    return {**ends, "requirements": holds}


RUNS = runs_of(2)
PROOF = {"findings": [], "why_not": [], "exhaustive": True, "proved": ["ends"]}
T = TypeVar("T")
PASSPHRASE = "open sesame"  # noqa: S105 - of a key that tests make


@dataclass(frozen=True)
class Attack:
    """An attempt; it returns what it was answered.

    Attributes:
        stopped_by: A part of the answer: the code of what stops it, mostly.
        drives: The drives that a person has permitted in it.
    """

    name: str
    stopped_by: str
    act: Callable[[Played], Any]
    drives: int = 0


@dataclass
class Robot:
    """A robot whose server obeys permits, as `serve --site` does; it counts what it drives."""

    missions: PermittedMissions
    driven: list[Any]
    stops: int = 0
    feedback: str = ""

    def status(self) -> dict[str, Any]:
        return {"state": self.feedback}

    async def drive(self, proposal: str) -> dict[str, Any]:
        return self.send(f"{PERMIT}{proposal}")

    def send(self, path: str = "", **fields: Any) -> dict[str, Any]:
        """Send a goal, as any node of the graph may."""
        goal = SimpleNamespace(**{"path": path, "text": "", "inputs": [], "seed": -1, **fields})
        try:
            self.driven.append(self.missions.begin(goal, self.missions.load(goal)))
        except BtMissionError as error:
            return {"is_driving": False, "why": error.headline}
        return {"is_driving": True, "why": ""}

    async def stop(self) -> dict[str, Any]:
        self.stops += 1
        return {"is_stopped": True, "why": ""}


class Played:
    """A site with its gateway, robot and person; commands answer at once.

    Args:
        root: The folder of the site's file.
        key: That of the person.
        page_key: The file of another key of the person, with `PASSPHRASE`.
    """

    def __init__(self, root: Path, key: Ed25519PrivateKey, page_key: Path) -> None:
        self.root, self.key, self.page_key = root, key, page_key
        self.folder = AgentFolder(root / "agents")
        self.answers: dict[str, Any] = {"prove": PROOF, "sweep": RUNS}
        self.commands: list[Sequence[str]] = []
        self.driven: list[Any] = []
        """The missions that were started, also before a restart."""
        self.seconds = 0.0
        """The time of the limits of calls."""
        self.clock_s = 0.0
        """How far the clock of the machine was set forward."""
        self._start(WAIT_S)

    def read_site(self) -> Site:
        """Read the file of the site."""
        return load_site(self.root / "site.yaml")

    def restart(self, wait_s: float = WAIT_S) -> None:
        """Start the server of agents and that of the robot again."""
        self.gateway.log.close()
        self._start(wait_s)

    def _start(self, wait_s: float) -> None:
        self.site = self.read_site()
        self.robot = Robot(PermittedMissions(site=self.site, folder=self.folder), self.driven)
        self.gateway = AgentGateway(
            self.site, self.folder, self.robot, self.command, self.examine, wait_s
        )
        self.server = agent_server(self.gateway, lambda: self.seconds)

    async def examine(self, proposal: Proposal) -> Examination:
        """Check a proposal in this process."""
        return Examination.of(self.site, proposal)

    async def command(self, words: Sequence[str]) -> CommandEnd:
        """Answer a command at once."""
        self.commands.append(words)
        return CommandEnd(self.answers[words[0]], ["a line"])

    def talk(self, act: Callable[[Client], Awaitable[T]]) -> T:
        """Connect a client of the SDK, and let it act."""

        async def session() -> T:
            async with Client(self.server) as client:
                return await act(client)

        return asyncio.run(session())

    async def ask(self, tool: str, **arguments: Any) -> Any:
        """Call one tool; return its answer, or the text of the refusal."""
        self.seconds += 1.0
        async with Client(self.server) as client:
            try:
                result = await client.call_tool(tool, arguments)
            except MCPError as error:
                return str(error)
        return result.content[0].text if result.is_error else result.structured_content

    def call(self, tool: str, **arguments: Any) -> Any:
        """Do the same outside of an event loop."""
        return asyncio.run(self.ask(tool, **arguments))

    async def collect(self, name: str = "look", text: str = TURN, **more: Any) -> None:
        """Propose a mission and collect its evidence."""
        await self.ask("propose", name=name, text=text, **more)
        await self.ask("prove", name=name)
        await self.ask("simulate", name=name)

    def prepare(self, name: str = "look", text: str = TURN, **more: Any) -> None:
        """Do the same outside of an event loop."""
        asyncio.run(self.collect(name, text, **more))

    def on_page(self, act: Callable[[ApprovalServer], Awaitable[T]]) -> T:
        """Serve the page of approvals while a scene is played."""
        results: list[T] = []

        async def scene(server: ApprovalServer) -> None:
            results.append(await act(server))

        play_with(ApprovalServer(self.root / "site.yaml", self.folder, self.page_key), scene)
        return results[0]

    def approve(self, name: str = "look") -> Permit:
        """Sign what is there now, as a person who has looked at it."""
        proposal = self.folder.proposal(name)
        evidence = evidence_of(self.folder, proposal, self.site)
        return grant(self.folder, self.site, proposal, evidence, self.key)
