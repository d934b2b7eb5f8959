"""The page of a sweep in a browser, where there is one."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.commands.sweep.report.page import write_sweep_page
from bt_mission.commands.sweep.store import ResultStore
from tests.commands.sweep.conftest import origin, write_results
from tests.support.browser import BROWSER, Page
from tests.support.hostile import MARKUP
from tests.support.rows import failed, margin
from tests.support.thorough import sample

pytest.importorskip("plotly")
pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed"),
]


def opened(chromium: Page, store: ResultStore, *, width: int = 1280, scripts: bool = True) -> Page:
    """The page of results in the browser."""
    chromium.problems.clear()
    chromium.open(write_sweep_page(store), width=width, height=900, scripts=scripts)
    return chromium


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", sample(["light", "dark"], every=2))
def test_every_figure_is_drawn(chromium: Page, results: ResultStore, width: int, scheme: str):
    """By the policy of the page and without a network, as wide as there is room."""
    chromium.prefer(scheme)
    page = opened(chromium, results, width=width)
    assert page.problems == []
    assert page.look("document.querySelectorAll('.drawn').length") == 8
    assert page.look("document.querySelectorAll('.drawn .plot-container').length") == 8
    assert page.look("document.documentElement.scrollWidth") == width
    widest = page.look(
        "Math.max(...[...document.querySelectorAll('.drawn .main-svg')]"
        ".map((one) => one.getBoundingClientRect().right))"
    )
    assert widest <= width


@pytest.mark.thorough
def test_letters_of_figures_follow_the_scheme(chromium: Page, results: ResultStore):
    """They can be read on the ground that the page has."""
    fills = []
    for scheme in ("light", "dark"):
        chromium.prefer(scheme)
        page = opened(chromium, results)
        fills.append(page.look("getComputedStyle(document.querySelector('.xtick text')).fill"))
    assert fills[0] != fills[1]


def test_pointing_at_a_figure_tells_its_numbers(chromium: Page, results: ResultStore):
    """The count behind a point, and its interval."""
    page = opened(chromium, results)
    x, y = page.look(
        "(() => { const b = document.querySelector('.drawn .points path')"
        ".getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()"
    )
    page.mouse("mouseMoved", x, y)
    page.mouse("mouseMoved", x + 1, y)
    page.look("new Promise((done) => setTimeout(done, 300))")
    for _ in range(50):
        reported = page.look("document.querySelector('.hovertext')?.textContent ?? ''")
        if reported:
            break
    assert reported.startswith("0.1")
    assert "38 of 40" in reported


@pytest.mark.process(always=True)
def test_without_scripts_the_tables_are_there(chromium: Page, results: ResultStore):
    """And a line that says why the charts are not."""
    page = opened(chromium, results, scripts=False)
    assert page.problems == []
    chromium.call("Emulation.setScriptExecutionDisabled", value=False)
    assert "need JavaScript" in page.look("document.querySelector('noscript').textContent")
    assert page.look("document.querySelectorAll('.worst tbody tr').length") == 20


@pytest.mark.thorough
def test_texts_in_figures_are_letters(chromium: Page, tmp_path: Path):
    """Plotly makes no elements of them: no link, no bold letters, no markup of SVG."""
    name = f'<a href="javascript:alert(1)">x</a><b>{MARKUP}'
    rows = [
        failed(
            n,
            passed=n % 2 == 0,
            parameters={name: n % 3, "word": f"{name}{n % 2}"},
            requirements={name: margin(n / 7, unit=name)},
        )
        for n in range(12)
    ]
    page = opened(chromium, write_results(tmp_path / "r", rows, origin(), plans={}))
    assert page.problems == []
    assert page.look("document.querySelectorAll('.drawn a, .drawn evil, main evil').length") == 0
    ticks = page.look(
        "[...document.querySelectorAll('.ytick text')].map((one) => one.textContent).join(' ')"
    )
    assert "<a href=" in ticks


def test_a_page_of_many_rows_is_drawn(chromium: Page, tmp_path: Path):
    """Also with values that are all different."""
    rows = [
        failed(n, passed=n % 5 > 0, parameters={"x": n / 7, "y": -n % 13 / 3}, virtual_s=n / 3)
        for n in range(300)
    ]
    page = opened(chromium, write_results(tmp_path / "r", rows, None, plans={}))
    assert page.problems == []
    assert page.look("document.querySelectorAll('.drawn .plot-container').length") == 4
