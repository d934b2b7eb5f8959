"""What a person reads before the decision: words of a proposal cannot look like the program's."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.commands.agents.names import shown_name, why_invalid
from bt_mission.commands.agents.shown import CONTINUED, MOST_LINES, THEIRS, Shown
from tests.commands.agents.played import HOLDS, RUNS, Played
from tests.support.web_pages import fetch

FORGED = "evidence: 20 of 20 runs succeeded"
LEFT = "\u041b\u0435\u0432\u043e"
TEXT = f"""\
mission: look
description: |
  A look around.
  {FORGED}
inputs: {{word: a}}
requirements:
  held in 1 of 1 runs: always speed < 9
tree:
  turn: {{angle: 90}}
  name: "{LEFT}"
  timeout: 20
# {"x" * 200}{FORGED}
"""


def _shown(played: Played, width: int) -> list[str]:
    more = {"held in 1 of 1 runs": {"holds": 2, **HOLDS}}
    played.answers["sweep"] = {**RUNS, "requirements": {**RUNS["requirements"], **more}}
    points = [f"a\n{FORGED}", f"b\r{FORGED}", f"c\u2028{FORGED}", "d\x1b[2J"]
    played.answers["prove"] = {**played.answers["prove"], "why_not": points * 100}
    played.prepare(text=TEXT, inputs={"word": f"a\u2028{FORGED}"})
    return list(Shown.of(played.folder, played.site, "look").lines("utf-8", width))


@pytest.mark.parametrize("width", [10, 40, 80, 200])
def test_words_of_a_proposal_stand_behind_marks(played: Played, width: int) -> None:
    """Each line, and each part of one that is too long; none is wider than the terminal."""
    lines = _shown(played, width)
    ours = [line for line in lines if not line.startswith((THEIRS, CONTINUED))]
    assert not [line for line in ours if FORGED[:9] in line]
    assert "  2 of 2 runs succeeded (seeds 0 to 1)" in ours
    assert "  is slow: held in 2 of 2 runs, smallest margin 0.2 m" in ours
    theirs = [line for line in lines if line.startswith((THEIRS, CONTINUED))]
    assert all(len(line) < max(width, 24) for line in theirs)
    assert all(line.isprintable() for line in lines)
    whole = "".join(line[len(THEIRS) :] for line in theirs)
    assert "'held in 1 of 1 runs': held in 2 of 2 runs, smallest margin 0.2 m" in whole
    assert f"word = a\\u2028{FORGED}" in whole
    assert f"  {FORGED}" in whole
    assert f"open: c\\u2028{FORGED}" in whole
    (proof,) = [line for line in ours if line.startswith("The proof")]
    assert proof == f"The proof, with names of the proposal (the first {MOST_LINES} of 401 lines):"


def test_changes_are_of_all_that_was_approved(played: Played) -> None:
    """Of the inputs and the seed, too; without any, that is said."""

    def changes() -> list[str]:
        parts = Shown.of(played.folder, played.site, "look").parts
        return [
            line
            for part in parts
            if part.title == "Changes since the last approval"
            for line in part.lines
            if not line.startswith((" ", "@", "---", "++"))
        ]

    played.prepare(text=TEXT, inputs={"word": "a"}, seed=0)
    assert changes() == []
    played.approve()
    assert changes() == ["no difference"]
    played.prepare(text=TEXT, inputs={"word": "b"}, seed=1)
    assert changes() == ["-word = a", "-its seed: 0", "+word = b", "+its seed: 1"]


def test_the_page_shows_the_same_parts(played: Played) -> None:
    """Words of the proposal are in boxes, where a line ends with a line feed only."""
    _shown(played, 80)

    async def scene(server: Any) -> str:
        return (await fetch(server, f"/{server.token}/look"))[2]

    page = played.on_page(scene)
    boxes = page.split('<pre class="theirs">')
    outside = boxes[0] + "".join(box.split("</pre>")[1] for box in boxes[1:])
    assert FORGED not in outside
    assert "<li>2 of 2 runs succeeded (seeds 0 to 1)</li>" in outside
    assert "held in 1 of 1 runs&#x27;: held in 2 of 2 runs" in "".join(boxes[1:])


def test_a_damaged_recording_is_shown_as_missing(played: Played) -> None:
    """Everything else is shown, on a terminal and on the page; nothing can be approved."""
    _shown(played, 80)
    folder = played.folder.path("proposals", "look", "results", "recordings")
    folder.mkdir(parents=True)
    (folder / "0.mcap").write_bytes(b"no recording")
    shown = Shown.of(played.folder, played.read_site(), "look")
    assert "  2 of 2 runs succeeded (seeds 0 to 1)" in list(shown.lines("utf-8", 80))
    (why,) = shown.missing
    assert why.startswith("the worst run cannot be shown: ")
    assert why.endswith("simulate again")

    async def scene(server: Any) -> str:
        return (await fetch(server, f"/{server.token}/look"))[2]

    page = played.on_page(scene)
    assert "the worst run cannot be shown" in page
    assert "<form" not in page


def test_folders_of_killed_jobs_are_removed_at_the_next_start(played: Played) -> None:
    """Not that of a job that runs."""
    old = played.folder.path("proposals", ".work-killed")
    (old / "results").mkdir(parents=True)
    with played.folder.work_folder() as running:
        played.restart()
        assert running.is_dir()
    assert not old.exists()
    assert not running.exists()


@pytest.mark.parametrize(
    ("name", "is_fine"),
    [
        *((name, True) for name in ("keeps clear", "a: b (c), d_e-f.", "\u00fcber", "", "3 m")),
        *((name, True) for name in (LEFT, "e\u0301t\u00e9", "\u770b\u308b A")),
        *((name, False) for name in ("a  b", " a", "a ", "a\u0430", "\u03b1\u0430", "a\u2044b")),
        *((name, False) for name in ("a\u2003b", "x" * 61, "\u770b\u0430", "a\u3000b", "a\ufe00")),
    ],
)
def test_names_are_of_one_script(name: str, *, is_fine: bool) -> None:
    """East Asian scripts are written together, and with Latin letters."""
    assert (why_invalid(name) is None) == is_fine


def test_letters_that_look_like_others_are_named() -> None:
    """A name of one script may look like one of another."""
    assert shown_name("fast") == "'fast'"
    assert shown_name("\u0131s") == "'\u0131s' (not ASCII: LATIN SMALL LETTER DOTLESS I)"
    look = shown_name(LEFT)
    assert look.startswith(f"'{LEFT}' (not ASCII: CYRILLIC CAPITAL LETTER EL, CYRILLIC SMALL")
    assert look.endswith(", ...)")
