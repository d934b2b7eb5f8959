"""The gateway as a server of the Model Context Protocol."""

from __future__ import annotations

import base64
import json
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from mcp.server.context import CallNext, ServerRequestContext
from mcp.server.mcpserver import MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp.server.mcpserver.resources import FunctionResource
from mcp.shared.exceptions import MCPError
from mcp_types import CallToolResult, ContentBlock, ImageContent, TextContent, ToolAnnotations

from bt_mission.base.diagnostics import listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.commands.agents.call_log import LogError
from bt_mission.commands.agents.capabilities import OVERVIEW, TEXTS
from bt_mission.commands.agents.folder import ProposalError
from bt_mission.commands.agents.gateway import AgentGateway

LONGEST_CALL = 100_000
"""Characters of the parameters of a call."""
BURST, A_SECOND = 40.0, 5.0
"""Calls of all clients together: at once, and in the long run."""
STOPS_EVERY_S = 10.0
"""The time for which further stops share a line of the log."""
TOO_MUCH = "BT-1405"
REFUSED = -32000
"""The code of JSON-RPC for a call that is refused before it is looked at."""

FIXED = frozenset(
    f"{group}/list" for group in ("tools", "resources", "resources/templates", "prompts")
) | {"initialize", "server/discover", "ping"}
"""Methods with a fixed answer, which are neither limited nor logged: a client may ask for the list
of tools before it calls `stop`."""

_P = ParamSpec("_P")
_R = TypeVar("_R")


class CallGuard:
    """Limits calls by number and size, and logs each with its outcome. `stop` is never refused.

    Args:
        gateway: With the log.
        elapsed_s: Returns the seconds that have passed, for the rate.
    """

    def __init__(self, gateway: AgentGateway, elapsed_s: Callable[[], float] | None = None) -> None:
        self._log = gateway.log
        self._elapsed_s = elapsed_s or _stopwatch()
        self._left, self._at_s = BURST, 0.0
        self._stops, self._next_stop_s = 0, 0.0

    async def __call__(self, context: ServerRequestContext[Any, Any], call_next: CallNext) -> Any:
        """Pass a message on, or refuse it."""
        call, arguments = _named(context)
        client = _client(context)
        if (context.method, call) == ("tools/call", "stop"):
            try:
                return await call_next(context)
            finally:
                self._note_stop(client)
        if context.request_id is None or context.method in FIXED:
            return await call_next(context)
        if why := self._refusal(arguments):
            self._note(client, call, {}, why)
            raise MCPError(code=REFUSED, message=why)
        try:
            result = await call_next(context)
        except Exception as error:
            self._note(client, call, arguments, f"error: {error}")
            raise
        self._note(client, call, arguments, _outcome(result))
        return result

    def _note_stop(self, client: str) -> None:
        """Log the first of many stops at once, and the others together, a line for each period."""
        self._stops += 1
        now_s = self._elapsed_s()
        if now_s < self._next_stop_s or self._log.is_full:
            return
        others = f", {self._stops} since the last line" if self._stops > 1 else ""
        self._stops, self._next_stop_s = 0, now_s + STOPS_EVERY_S
        self._note(client, "stop", {}, f"passed on{others}")

    def _refusal(self, arguments: Any) -> str:
        now_s = self._elapsed_s()
        self._left = min(BURST, self._left + (now_s - self._at_s) * A_SECOND)
        self._at_s = now_s
        if self._log.is_full:
            return f"the log of calls is full; a person must move it away [{LogError.code}]"
        if self._left < 1:
            return f"more than {A_SECOND:g} calls a second [{TOO_MUCH}]"
        self._left -= 1
        size = len(json.dumps(arguments, default=str))
        if size > LONGEST_CALL:
            return f"a call of {size:,} characters, at most {LONGEST_CALL:,} [{TOO_MUCH}]"
        try:
            self._log.write()  # no call is passed on while the lines of earlier ones wait
        except LogError as error:
            return error.headline
        return ""

    def _note(self, client: str, call: str, arguments: Any, outcome: str) -> None:
        with suppress(LogError):  # the line waits, and the next call is refused until it is there
            self._log.note(client, call, arguments, outcome)


def _refused(act: Callable[_P, Awaitable[_R]]) -> Callable[_P, Awaitable[_R]]:
    """Answer errors that a client can act on with their text and code."""

    @wraps(act)
    async def answer(*arguments: _P.args, **named: _P.kwargs) -> _R:
        try:
            return await act(*arguments, **named)
        except BtMissionError as error:
            raise ToolError(error.headline) from None

    return answer


class AgentTools:
    """The tools: the docstring of each is its description for the agent."""

    def __init__(self, gateway: AgentGateway) -> None:
        self._gateway = gateway

    @_refused
    async def language(self, part: str = "overview") -> str:
        """Read about missions: overview, schema, examples, glossary, nodes, actions, and others."""
        if part not in TEXTS:
            raise ProposalError(f"unknown part {quoted(part)} (known: {listed(TEXTS)})")
        return TEXTS[part]()

    @_refused
    async def site(self) -> dict[str, Any]:
        """Read what this robot offers: actions with units and limits, zones, requirements."""
        return self._gateway.capabilities

    @_refused
    async def check(self, text: str, inputs: dict[str, str] | None = None) -> dict[str, Any]:
        """Check the text of a mission; returns every error with line, column and hint."""
        return await self._gateway.check(text, inputs)

    @_refused
    async def propose(
        self, name: str, text: str, inputs: dict[str, str] | None = None, seed: int | None = None
    ) -> dict[str, Any]:
        """Keep a valid mission as a proposal; returns the diff and the missing evidence."""
        return await self._gateway.propose(name, text, inputs, seed)

    @_refused
    async def prove(self, name: str) -> dict[str, Any]:
        """Check a proposal against every answer that its servers can give."""
        return await self._gateway.prove(name)

    @_refused
    async def simulate(
        self, name: str, seeds: int | None = None, faults: list[str] | None = None
    ) -> dict[str, Any]:
        """Simulate a proposal: without arguments the runs that are evidence, else a trial."""
        return await self._gateway.simulate(name, seeds, faults)

    @_refused
    async def results(self, name: str, *, picture: bool = True) -> CallToolResult:
        """Read the evidence of a proposal, its margins, and what is missing for an approval.

        With a picture of the worst simulated run: its path over the map, and its verdicts.
        """
        results = self._gateway.results(name)
        content: list[ContentBlock] = [TextContent(type="text", text=json.dumps(results))]
        if picture and (image := self._gateway.picture(name)) is not None:
            data = base64.b64encode(image).decode()
            content.append(ImageContent(type="image", data=data, mime_type="image/png"))
        return CallToolResult(content=content, structured_content=results)

    @_refused
    async def drive(self, name: str) -> dict[str, Any]:
        """Run a proposal on the robot, once, with the permit that a person has given."""
        return await self._gateway.drive(name)

    @_refused
    async def status(self) -> dict[str, Any]:
        """Read the state of the robot, the proposals and the running job."""
        return self._gateway.status()

    @_refused
    async def stop(self) -> dict[str, Any]:
        """Stop the mission of the robot. It is always possible."""
        return await self._gateway.stop()


def agent_server(
    gateway: AgentGateway, elapsed_s: Callable[[], float] | None = None
) -> MCPServer[Any]:
    """Return the server of a gateway; `elapsed_s` is the time of its limits."""
    server: MCPServer[Any] = MCPServer(
        "bt-mission",
        instructions=OVERVIEW,
        log_level="CRITICAL",
        middleware=[CallGuard(gateway, elapsed_s)],
    )
    tools = AgentTools(gateway)
    reads: tuple[Callable[..., Any], ...] = (tools.language, tools.site, tools.check)
    for tool in (*reads, tools.results, tools.status):
        server.add_tool(tool, annotations=ToolAnnotations(read_only_hint=True))
    for tool in (tools.propose, tools.prove, tools.simulate, tools.stop):
        server.add_tool(tool, annotations=ToolAnnotations(destructive_hint=False))
    server.add_tool(tools.drive, annotations=ToolAnnotations(destructive_hint=True))
    for name, text in TEXTS.items():
        resource = FunctionResource(
            uri=f"bt-mission://language/{name}", name=name, mime_type="text/plain", fn=text
        )
        server.add_resource(resource)
    server.add_resource(
        FunctionResource(
            uri="bt-mission://site",
            name="site",
            mime_type="application/json",
            fn=lambda: json.dumps(gateway.capabilities),
        )
    )
    return server


def _named(context: ServerRequestContext[Any, Any]) -> tuple[str, Any]:
    """Return the name of a call, that of its tool if it calls one, and its arguments."""
    params: Mapping[str, Any] = context.params or {}
    if context.method != "tools/call":
        return context.method, {key: params[key] for key in params if key != "_meta"}
    return str(params.get("name")), params.get("arguments") or {}


def _client(context: ServerRequestContext[Any, Any]) -> str:
    """Return the name that a client gives itself; nothing proves it."""
    params = context.session.client_params
    return "" if params is None else f"{params.client_info.name} {params.client_info.version}"


def _outcome(result: Any) -> str:
    if isinstance(result, Mapping):
        is_error, content = result.get("isError", False), result.get("content", "")
    else:
        is_error, content = getattr(result, "is_error", False), getattr(result, "content", "")
    return f"refused: {content}" if is_error else "done"


def _stopwatch() -> Callable[[], float]:
    since = Stopwatch()
    return lambda: since.elapsed_s
