"""The page of approvals: what it shows, and what its form refuses."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable
from typing import Any
from urllib.parse import urlencode, urlsplit

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.agents.approval_page import MOST_WRONG, ApprovalServer
from bt_mission.commands.agents.permits import new_key
from tests.commands.agents.played import PASSPHRASE, TURN, Attack, Played
from tests.support.thorough import sample
from tests.support.web_pages import fetch


def _origin(server: ApprovalServer) -> str:
    return f"http://{urlsplit(server.link).netloc}"


async def _once(server: ApprovalServer, name: str = "look") -> str:
    """Open the page of a proposal; return the secret of its form."""
    _, _, page = await fetch(server, f"/{server.token}/{name}")
    (once,) = re.findall(r'name="once" value="([^"]+)"', page)
    return str(once)


async def _send(
    server: ApprovalServer, once: str, *, path: str = "look", token: str = "", **headers: str
) -> str:
    """Send a form that is right but for what is given."""
    form = urlencode({"once": once, "name": "look", "passphrase": PASSPHRASE})
    headers = {"Origin": _origin(server)} | headers
    _, _, answer = await fetch(server, f"/{token or server.token}/{path}", form=form, **headers)
    return answer


def test_a_person_reads_everything_and_approves_on_the_page(played: Played) -> None:
    """The mission is escaped, there are no scripts, and the permit serves for one drive."""
    played.prepare(text=f"{TURN}# <script>alert(1)</script>\n")

    async def scene(server: ApprovalServer) -> None:
        _, _, proposals = await fetch(server, f"/{server.token}/")
        assert "can be approved" in proposals
        status, headers, page = await fetch(server, f"/{server.token}/look")
        assert status == 200
        assert "&lt;script&gt;alert(1)" in page
        assert "<script" not in page
        assert "keeps clear: held in 2 of 2 runs, smallest margin 0.2 m" in page
        assert "log of calls: 3 calls<" in page
        assert headers["x-frame-options"] == "DENY"
        policy = headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; style-src 'unsafe-inline'; img-src data:;")
        answer = await _send(server, await _once(server))
        assert "may drive once, within 600 s." in answer

    played.on_page(scene)
    assert played.call("drive", name="look") == {"is_driving": True, "why": ""}
    assert "was used" in played.call("drive", name="look")


def test_without_all_evidence_there_is_no_form(played: Played) -> None:
    """The page says what is missing."""
    played.call("propose", name="look", text=TURN)

    async def scene(server: ApprovalServer) -> str:
        return (await fetch(server, f"/{server.token}/look"))[2]

    page = played.on_page(scene)
    assert "no proof of this version" in page
    assert "<form" not in page


def _on_page(act: Callable[[Played, ApprovalServer], Awaitable[str]]) -> Callable[[Played], Any]:
    """Attack the page of a proposal that could be approved."""

    def attack(played: Played) -> Any:
        played.prepare()
        answer = played.on_page(lambda server: act(played, server))
        played.call("drive", name="look")
        return answer

    return attack


def _with(**wrong: Any) -> Callable[[Played], Any]:
    """Send the form of an open page, with something wrong."""

    async def act(_played: Played, server: ApprovalServer) -> str:
        return await _send(server, await _once(server), **wrong)

    return _on_page(act)


async def _guessed(_played: Played, server: ApprovalServer) -> str:
    await _once(server)
    return await _send(server, "a" * 22)


async def _sent_again(played: Played, server: ApprovalServer) -> str:
    once = await _once(server)
    assert "may drive once" in await _send(server, once)
    assert await played.ask("drive", name="look") == {"is_driving": True, "why": ""}
    return await _send(server, once)


async def _of_another(played: Played, server: ApprovalServer) -> str:
    await played.collect("good")
    return await _send(server, await _once(server, "good"))


async def _without_origin(_played: Played, server: ApprovalServer) -> str:
    form = urlencode({"once": await _once(server), "name": "look", "passphrase": PASSPHRASE})
    return (await fetch(server, f"/{server.token}/look", form=form))[2]


def _form(**fields: str) -> Callable[[Played], Any]:
    async def act(_played: Played, server: ApprovalServer) -> str:
        given = {"once": await _once(server), "name": "look", "passphrase": PASSPHRASE, **fields}
        path = f"/{server.token}/look"
        return (await fetch(server, path, form=urlencode(given), Origin=_origin(server)))[2]

    return _on_page(act)


async def _guesses_passphrases(_played: Played, server: ApprovalServer) -> str:
    path, origin = f"/{server.token}/look", _origin(server)
    for number in range(MOST_WRONG):
        form = {"once": await _once(server), "name": "look", "passphrase": f"guess {number}"}
        answer = (await fetch(server, path, form=urlencode(form), Origin=origin))[2]
        assert "[BT-1406]" in answer
    return await _send(server, await _once(server))


async def _changes_the_proposal(played: Played, server: ApprovalServer) -> str:
    once = await _once(server)
    await played.collect("look", text=TURN.replace("90", "180"))
    return await _send(server, once)


async def _changes_the_site(played: Played, server: ApprovalServer) -> str:
    once = await _once(server)
    path = played.root / "site.yaml"
    path.write_text(path.read_text().replace("< 0.3", "< 9.9"))
    return await _send(server, once)


async def _reads_a_path(_played: Played, server: ApprovalServer) -> str:
    return (await fetch(server, f"/{server.token}/..%2fpermits"))[2]


def _bare_key(played: Played) -> str:
    """With a key that needs no passphrase, everyone with the link could approve."""
    path = played.root / "person" / "bare.pem"
    new_key(path, "")
    try:
        ApprovalServer(played.root / "site.yaml", played.folder, path)
    except BtMissionError as error:
        return error.headline
    return "served"


ATTACKS = (
    Attack("the token of the server of agents", "invalid or expired", _with(token="x" * 22)),
    Attack("a form of another page in the browser", "pages of other servers",
           _with(Origin="http://evil.example")),
    Attack("a form of a sandboxed frame", "pages of other servers", _with(Origin="null")),
    Attack("a form of another port", "pages of other servers", _with(Origin="http://127.0.0.1:1")),
    Attack("a form of no browser", "not sent by a browser", _on_page(_without_origin)),
    Attack("a name that points to this machine", "only its address",
           _with(Host="evil.example", Origin="http://evil.example")),
    Attack("a form that is sent again", "sent before", _on_page(_sent_again), drives=1),
    Attack("a guessed secret of a form", "sent before", _on_page(_guessed)),
    Attack("the form of another proposal", "sent before", _on_page(_of_another)),
    Attack("a form without the name", "was not typed", _form(name="")),
    Attack("another name", "was not typed", _form(name="good")),
    Attack("no passphrase", "no passphrase", _form(passphrase="")),
    Attack("a wrong passphrase", "BT-1406", _form(passphrase="guess")),  # noqa: S106
    Attack("many passphrases, the last one right", "too many wrong",
           _on_page(_guesses_passphrases)),
    Attack("a huge form", "sent before", _form(more="x" * 5_000)),
    Attack("many fields", "sent before", _form(**{f"f{number}": "x" for number in range(9)})),
    Attack("another version while it is shown", "BT-1404", _on_page(_changes_the_proposal)),
    Attack("a weaker site while it is shown", "BT-1404", _on_page(_changes_the_site)),
    Attack("a path as proposal", "Not Found", _on_page(_reads_a_path)),
    Attack("a key without a passphrase", "BT-1406", _bare_key),
)  # fmt: skip


@pytest.mark.parametrize("attack", sample(ATTACKS, 6), ids=lambda attack: attack.name)
def test_no_attack_on_the_page_approves(played: Played, attack: Attack) -> None:
    """The answer names what stops it, and nothing drives that no person has permitted."""
    answer = attack.act(played)
    assert attack.stopped_by in answer
    assert len(played.driven) == attack.drives
    assert played.call("stop") == {"is_stopped": True, "why": ""}
