"""The page on which a person approves a proposal: plain HTML without any script.

It is served by the process of the person, never by that of agents. A form that is sent approves
only what its page has shown, once, with the passphrase of the person's key.
"""

from __future__ import annotations

import base64
import secrets
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs

from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from starlette.routing import Route
from typing_extensions import override

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.agents.folder import AgentFolder
from bt_mission.commands.agents.permits import (
    ApprovalError,
    PermitError,
    grant,
    has_passphrase,
    read_key,
)
from bt_mission.commands.agents.shown import Shown, states
from bt_mission.commands.agents.site import load_site
from bt_mission.commands.agents.site_files import differing
from bt_mission.views.drawing.path import path_png
from bt_mission.views.html.pages import render
from bt_mission.views.web.gate import HEADERS
from bt_mission.views.web.server import PageServer, WebOptions

MOST_SHOWN = 20
"""Pages whose forms are accepted: the newest."""
MOST_WRONG = 5
"""Forms with a wrong passphrase until no more are accepted."""
MOST_BODY = 4_000

PAGE_HEADERS = HEADERS | {
    "content-security-policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'",
    # With `no-referrer` a browser sends a form with `Origin: null`.
    "referrer-policy": "same-origin",
}


class ApprovalServer(PageServer):
    """Serves the proposals of a site to the person who approves.

    Args:
        site: Its file, read again for each page.
        folder: Of the proposals.
        key: The file of the person's key.
        port: 0 takes any that is free.

    Raises:
        ApprovalError: The key has no passphrase, so that the link alone could approve.
        BtMissionError: The port is in use.
    """

    headers = PAGE_HEADERS

    def __init__(self, site: Path, folder: AgentFolder, key: Path, port: int = 0) -> None:
        if not has_passphrase(key):
            raise ApprovalError(
                f"{key}: the page needs a key with a passphrase, so that its link alone approves "
                "nothing; make one with 'bt-mission approve --new-key' in a terminal"
            )
        self._site_file, self._folder, self._key = site, folder, key
        self._shown: dict[str, Shown] = {}
        self._wrong = 0
        decide = Route("/{name}", self._decide, methods=["POST"])
        super().__init__("", WebOptions(port=port), decide)

    @override
    async def _file(self, request: Request) -> Response:
        """Return the list of proposals, or the page of one."""
        name = request.path_params.get("name")
        try:
            return self._list() if name is None else self._show(name)
        except BtMissionError as error:
            return _page("Not shown", error.headline, status=404)

    def _list(self) -> Response:
        site = load_site(self._site_file)
        proposals = list(states(self._folder, site))
        say = "" if proposals else f"no proposals in {self._folder.root}"
        return _page(f"Proposals for site '{site.name}'", say, proposals=proposals)

    def _show(self, name: str) -> Response:
        shown = Shown.of(self._folder, load_site(self._site_file), name)
        picture = ""
        if shown.timeline is not None:
            image = path_png(shown.timeline)
            picture = f"data:image/png;base64,{base64.b64encode(image).decode()}"
        once = secrets.token_urlsafe(16)
        while len(self._shown) >= MOST_SHOWN:
            del self._shown[next(iter(self._shown))]
        self._shown[once] = shown
        return _page(name, shown=shown, once=once, picture=picture)

    async def _decide(self, request: Request) -> Response:
        """Approve what a page has shown."""
        if "origin" not in request.headers:  # the gate compares one that is there
            return _page("Not approved", "the form was not sent by a browser", status=403)
        form = await _form(request)
        shown = self._shown.pop(form.get("once", ""), None)
        name = request.path_params["name"]
        if shown is None or shown.proposal.name != name:
            say = "the form was sent before, or its page is too old: open the proposal again"
            return _page("Not approved", say, status=409)
        if form.get("name", "").strip() != name:
            return _page("Not approved", f"the name '{name}' was not typed", status=400)
        try:
            self._sign(shown, form.get("passphrase", ""))
        except BtMissionError as error:
            return _page("Not approved", error.headline, status=403)
        expires = f"{shown.site.written.expires:g}"
        return _page("Approved", f"'{name}' may drive once, within {expires} s.")

    def _sign(self, shown: Shown, passphrase: str) -> None:
        if self._wrong >= MOST_WRONG or not passphrase:
            raise ApprovalError("no passphrase, or too many wrong ones: start the page again")
        try:
            key = read_key(self._key, passphrase)
        except ApprovalError:
            self._wrong += 1
            raise
        now = load_site(self._site_file).files.digests
        if changed := differing(shown.site.files.digests, now):
            raise PermitError(f"{changed} has changed while it was shown")
        grant(self._folder, shown.site, shown.proposal, shown.evidence, key)


def _page(title: str, say: str = "", *, status: int = 200, **more: Any) -> Response:
    values = {"shown": None, "once": "", "picture": "", "proposals": (), **more}
    return HTMLResponse(
        render("commands/agents/approval.html", title=title, say=say, **values), status
    )


async def _form(request: Request) -> dict[str, str]:
    """Return the fields of a small form; empty for anything else."""
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MOST_BODY:
            return {}
    try:
        fields = parse_qs(body.decode(), max_num_fields=5, strict_parsing=True)
    except ValueError:
        return {}
    return {name: values[-1] for name, values in fields.items()}
