"""A site of agents for each test."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_mission.base import files
from bt_mission.base.wall_clock import unix_s
from bt_mission.commands.agents.permits import new_key, read_key
from tests.commands.agents.played import PASSPHRASE, SITE, Played


@pytest.fixture
def played(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Played]:
    """A site with an approver, whose commands answer at once."""
    key = tmp_path / "person" / "key.pem"
    page_key = tmp_path / "person" / "page.pem"
    approvers = f'"{new_key(key, "")}", "{new_key(page_key, PASSPHRASE)}"'
    (tmp_path / "site.yaml").write_text(f"{SITE}approvers: [{approvers}]\n")
    (tmp_path / "arena.yaml").write_bytes(files.find("worlds", "empty_arena").read_bytes())
    played = Played(tmp_path, read_key(key, ""), page_key)
    monkeypatch.setattr(
        "bt_mission.commands.agents.permits.unix_s", lambda: unix_s() + played.clock_s
    )
    yield played
    asyncio.run(played.gateway.close())
