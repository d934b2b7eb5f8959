"""Requirements in the full-screen view, however many there are and however small it is."""

from __future__ import annotations

import pytest

from tests.support.screens import Screen, on_screen


@pytest.mark.parametrize("count", [1, 20])
def test_requirements_have_a_panel(count: int):
    """Where there is room, at once; else it is the next one. Enlarged, twenty stand there."""

    async def narrow(screen: Screen) -> None:
        names = [f"number_{number}" for number in range(count)]
        verdicts = dict.fromkeys(names, "open 0.2") | {names[-1]: "violated -0.1"}
        screen.executive.judge(**verdicts)
        await screen.look()
        assert f"✗ 1 of {count} violated" in screen.rows[0]
        assert "Tab requirements" in screen.rows[-1]
        await screen.press("tab")
        await screen.press("z")
        assert screen.rows[3].startswith(f"✗ violated number {count - 1}")
        assert screen.text.count("▶ open ") == count - 1
        await screen.press("z")
        await screen.press("tab")
        assert "─ goals" in screen.text

    on_screen(narrow)

    async def wide(screen: Screen) -> None:
        screen.executive.judge(**{f"number_{number}": "open 0.2" for number in range(count)})
        await screen.look()
        await screen.look()
        assert f"─ requirements: {count} open ─" in screen.text

    on_screen(wide, size=(120, 40))
