"""The page of a sweep."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.sweep.report import page as page_module
from bt_mission.commands.sweep.report.page import INSTALL, write_sweep_page
from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.views.html.pages import POLICY
from tests.commands.sweep.conftest import BUNDLE, origin, some_rows, write_results
from tests.support.hostile import HOSTILE, markup_leaks
from tests.support.rows import failed, margin, row


@pytest.fixture(autouse=True)
def short_script(monkeypatch):
    """Plotly's five megabytes are not read again for each test."""
    monkeypatch.setattr(page_module, "plotly_script", lambda: "var Plotly;")


def text_of(store, **options):
    """The page of results."""
    return write_sweep_page(store, **options).read_text(encoding="utf-8")


def figures(text):
    """The figures that the script is told."""
    (matches,) = re.findall(r'id="figures">(.*?)</script>', text, re.DOTALL)
    return json.loads(matches)


def test_the_page_is_whole(results):
    """With its headline, a section for each question, and nothing that is fetched."""
    text = text_of(results)
    assert "<h1>go: 58 of 80 succeeded</h1>" in text
    assert "Success rate <b>72.5 %</b>" in text
    titles = re.findall("<h2>(.*?)</h2>", text)
    assert titles == [
        *("What was varied", "Success", "Failures", "The worst", "Requirements", "Duration"),
        *("Coverage of the tree", "Made with"),
    ]
    assert POLICY in text.replace("&#x27;", "'")
    assert not re.search(r'(src|href)="(?!#)', text)
    # Three parameters, three pairs of them, a requirement and the duration.
    places = re.findall(r'data-figure="(\d+)"', text)
    assert [int(place) for place in places] == list(range(len(figures(text)))) == list(range(8))


def test_commands_are_on_the_page(results):
    """That of the first failure of each kind, and the one that continues the sweep."""
    text = text_of(results)
    assert "<b>22</b>" in text
    words = re.sub("<.*?>", "", text).replace("&#x27;", "'")
    assert "bt-mission run mine/go.yaml --seed 0 --set speed=0.2 --world hall" in words
    assert "'at 2.0: drop scan lasting 2'" in words
    assert "bt-mission sweep mine/go.yaml --seeds 10 --vary speed=0.1,0.2 --resume" in words
    assert "bt-mission 1.2.3, mujoco 4.0" in words


def test_a_sweep_that_goes_on_says_so(tmp_path):
    """What is there so far is told."""
    store = write_results(tmp_path / "r", some_rows(), None, scenarios=1000)
    assert "80 of 1,000 scenarios have been carried out so far" in text_of(store)


@pytest.mark.parametrize("place", ["results", "elsewhere"])
def test_recordings_are_linked_where_they_are(tmp_path, place):
    """From wherever the page is."""
    store = write_results(tmp_path / "results", [failed(1), failed(2)], None)
    recordings = tmp_path / "results" / "recordings"
    recordings.mkdir()
    for suffix in (".html", ".mcap"):
        (recordings / f"{1:016x}{suffix}").touch()
    (tmp_path / place).mkdir(exist_ok=True)
    output = tmp_path / place / "page.html"
    links = re.findall('href="(.*?)"', text_of(store, output=output))
    assert [(output.parent / link).resolve() for link in links] == [
        recordings / f"{1:016x}.html",
        recordings / f"{1:016x}.mcap",
    ]


def test_coverage_tells_what_was_never_reached(tmp_path):
    """Of the tree, and of a node's outcomes."""
    store = write_results(tmp_path / "r", [row(n, coverage="3") for n in range(4)], origin())
    words = re.sub("<.*?>", " ", text_of(store))
    assert "1 of 2 nodes were reached, and 1 of 2 outcomes and branches" in words
    assert "log (0.0)" in words
    assert "go (0): failure" in words


@pytest.mark.parametrize(
    "rows",
    [
        [],
        [row(0)],
        [row(0, outcome="error", passed=False, reason="no world")],
        [row(n, parameters={"x": n / 100}) for n in range(100)],
        [row(n, requirements={"a": margin(None, "open"), "b": margin(1.0)}) for n in range(3)],
    ],
    ids=["nothing", "one", "an error", "all passed", "no margins"],
)
def test_a_page_of_little(tmp_path, rows):
    """There is a page of any results, also of those that have just begun."""
    text = text_of(write_results(tmp_path / "r", rows, origin(), plans={}, vary=[]))
    json.dumps(figures(text), allow_nan=False)
    assert "NaN" not in re.sub("<script.*?</script>", "", text, flags=re.DOTALL)


def hostile_results(folder):
    """Results in which every text attacks."""
    bundle = replace(BUNDLE, files={**BUNDLE.files, "missions/go.yaml": HOSTILE})
    rows = [
        failed(
            n,
            passed=n % 2 == 0,
            reason=HOSTILE,
            failed_node=HOSTILE,
            failed_path=HOSTILE,
            parameters={HOSTILE: n % 3, "name": f"{HOSTILE}{n % 2}"},
            plan=HOSTILE,
            requirements={HOSTILE: margin(n / 10, unit=HOSTILE), "m": margin(n / 7, unit=HOSTILE)},
            coverage="3",
            versions=HOSTILE,
        )
        for n in range(12)
    ]
    marks = {"reached": 0, f"outcome {HOSTILE}": 0}
    made_from = origin(
        path=HOSTILE,
        command="bt-mission sweep x",
        bundle=bundle,
        places=(CoveragePlace("", "0", HOSTILE, "log", 1, 1, marks),),
    )
    about = {"mission": HOSTILE, "vary": [HOSTILE], "plans": {HOSTILE: [HOSTILE]}}
    return write_results(folder, rows, made_from, **about)


def test_no_text_of_others_is_markup(tmp_path):
    """Whatever stands in a mission, a message or a name; nor does it end the script's data."""
    text = text_of(hostile_results(tmp_path / "r"))
    assert markup_leaks(text) == []
    result = json.dumps(figures(text))
    assert "<evil" not in result
    assert "\\u001b" not in result


def test_the_markup_is_balanced(results):
    """Every element that begins ends."""

    class Balance(HTMLParser):
        open: list[str] = []  # noqa: RUF012 - one page only
        void = ("meta", "link", "br")

        def handle_starttag(self, tag, attrs):
            if tag not in self.void:
                self.open.append(tag)

        def handle_endtag(self, tag):
            assert self.open.pop() == tag

    parser = Balance()
    parser.feed(text_of(results))
    assert parser.open == []


def test_without_plotly_it_is_said_what_to_install(results, monkeypatch):
    """Instead of a page without charts."""
    monkeypatch.undo()
    monkeypatch.setitem(__import__("sys").modules, "plotly", None)
    with pytest.raises(BtMissionError, match=re.escape(INSTALL)):
        write_sweep_page(results)


def test_a_page_that_cannot_be_written(results, tmp_path):
    """Is told with its place."""
    with pytest.raises(BtMissionError, match=r"cannot write .*: Is a directory"):
        write_sweep_page(results, tmp_path)
