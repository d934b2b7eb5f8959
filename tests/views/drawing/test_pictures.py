"""Trees as SVG, PNG and DOT."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pydot
import pytest
from PIL import Image

from bt_mission.base.errors import BtMissionError
from bt_mission.cli import main
from bt_mission.sessions.load import load
from bt_mission.views.drawing.dot import dot
from bt_mission.views.drawing.letters import width_px, wrapped
from bt_mission.views.drawing.nodes import drawn, heading
from bt_mission.views.drawing.png import png
from bt_mission.views.drawing.scene import Rectangle, Scene, Words, scene
from bt_mission.views.drawing.svg import svg
from tests.support.processes import PATIENCE_S
from tests.views.drawing.test_nodes import MISSIONS

NASTY = "mission: 'a<b>&\"c'\ntree:\n  sequence:\n    - log: \"<x> & 'y' \\\\ \\e[31m\"\n"


def made(text: str) -> Scene:
    """The scene of a mission in a text."""
    mission = load(text)
    return scene(drawn(mission), heading(mission))


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.stem)
def test_every_shipped_mission_makes_a_sound_svg(path: Path) -> None:
    """Well-formed, and no text leaves the page or its box."""
    mission = load(path)
    picture = scene(drawn(mission), heading(mission))
    root = ET.fromstring(svg(picture))  # noqa: S314 - our own
    assert root.get("width") == f"{picture.width:.1f}".removesuffix(".0")
    boxes = [shape for shape in picture.shapes if isinstance(shape, Rectangle)]
    for words in picture.shapes:
        if isinstance(words, Words) and not words.centred:
            right = words.x + width_px(words.text, words.size, bold=words.bold)
            assert right <= picture.width
            inside = any(
                box.x <= words.x
                and right <= box.x + box.width
                and box.y < words.y < box.y + box.height
                for box in boxes
            )
            assert inside or words.y < boxes[0].y, words


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # pydot's own
def test_texts_are_escaped() -> None:
    """Markup, quotes and control characters in names and texts."""
    mission = load(NASTY)
    picture = made(NASTY)
    text = svg(picture)
    elements = ET.fromstring(text).iter()  # noqa: S314 - our own
    assert [element.text for element in elements if element.text and "<x>" in element.text]
    assert "\x1b" not in text
    graphs = pydot.graph_from_dot_data(dot(drawn(mission), heading(mission)))
    assert graphs is not None
    (graph,) = graphs
    assert len(graph.get_edges()) == 1


def test_a_png_is_twice_as_large_as_the_scene() -> None:
    """And not empty."""
    picture = made("mission: m\ntree: {sequence: [{wait: 1}, {log: hello}]}\n")
    image = Image.open(io.BytesIO(png(picture)))
    assert abs(image.size[0] - picture.width * 2) <= 1
    assert abs(image.size[1] - picture.height * 2) <= 1
    colours = image.convert("RGB").getcolors(100_000)
    assert colours is not None
    assert len(colours) > 10


def test_a_png_that_would_be_too_large_is_refused() -> None:
    """With what to do instead."""
    with pytest.raises(BtMissionError, match=r"too large for a PNG .* draw it as SVG"):
        png(Scene("t", 100_000, 10_000, ()))


def test_words_are_wrapped_and_long_ones_cut() -> None:
    """So that every line has room."""
    lines = list(wrapped("some words and " + "x" * 100, 10, 100))
    assert "".join(lines).replace(" ", "") == "somewordsand" + "x" * 100
    assert all(width_px(line, 10) <= 100 for line in lines)
    assert list(wrapped("", 10, 100)) == []
    assert width_px("漢", 10) == 10.0


def test_a_very_long_goal_is_cut_in_pictures() -> None:
    """The text has it whole."""
    poses = ", ".join("[1, 2, 3]" for _ in range(200))
    mission = f"mission: m\ntree:\n  follow_waypoints: {{poses: [{poses}]}}\n  timeout: 9\n"
    texts = [shape.text for shape in made(mission).shapes if isinstance(shape, Words)]
    assert any(text.startswith("... ") and text.endswith(" more lines") for text in texts)


def test_the_command_writes_every_format(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The suffix says which, or --format; without either it is text."""
    assert main(["tree", "square"]) == 0
    out = capsys.readouterr().out
    assert "square" in out.splitlines()[1]
    for suffix in ("txt", "dot", "svg", "png"):
        path = tmp_path / f"tree.{suffix}"
        assert main(["tree", "square", "-o", str(path)]) == 0
        assert path.stat().st_size > 100
    assert (tmp_path / "tree.txt").read_text() == out
    assert main(["tree", "square", "--format", "svg", "-o", str(tmp_path / "tree.xyz")]) == 0
    assert (tmp_path / "tree.xyz").read_text().startswith("<svg ")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["square", "-o", "tree.xyz"], "tree.xyz: unknown suffix"),
        (
            ["square", "-o", "/no/folder/x.svg"],
            "/no/folder/x.svg: the folder /no/folder does not exist",
        ),
        (["sqare"], "did you mean 'square'?"),
        (["square", "--set", "nothing=1"], "nothing"),
    ],
)
def test_bad_input_exits_with_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """And says why."""
    assert main(["tree", *arguments]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.thorough
def test_no_ros_is_loaded(tmp_path: Path) -> None:
    """Nor MuJoCo; in a process of its own, since here they are loaded already."""
    script = (
        "import sys; from bt_mission.cli import main; "
        f"code = main(['tree', 'patrol', '-o', {str(tmp_path / 'x.png')!r}]); "
        "names = {name.partition('.')[0] for name in sys.modules}; "
        "bad = [n for n in names if n in ('rclpy', 'mujoco') or n.startswith('rosidl') "
        "or n.endswith(('_msgs', '_interfaces'))]; "
        "sys.exit(f'{code} {bad}' if code or bad else 0)"
    )
    done: Any = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
