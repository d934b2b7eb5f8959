"""A map in characters."""

from __future__ import annotations

import pytest

from bt_mission.executive.events.messages import (
    FrameTransform,
    Map,
    Robot,
    ScanPoints,
    ZoneDisc,
    Zones,
)
from bt_mission.executive.events.robot_state import RobotState
from bt_mission.views.terminal.map_chart import MapChart
from bt_mission.views.terminal.marks import ASCII_SIGNS, SIGNS, Marks, text_of

QUARTER = 1.5707963267948966


def room(width: int = 40, resolution: float = 0.1, yaw: float = 0.0) -> Map:
    """A square room with its corner at the origin, and walls of two cells."""
    cells = bytearray(width * width)
    for row in range(width):
        for column in range(width):
            if not (2 <= row < width - 2 and 2 <= column < width - 2):
                cells[row * width + column] = 100
    return Map(resolution, width, width, 0.0, 0.0, yaw, bytes(cells))


def drawn(
    robot: RobotState,
    targets: tuple[tuple[float, float], ...] = (),
    columns: int = 24,
    rows: int = 12,
    marks: Marks = SIGNS,
) -> list[str]:
    """The rows of a chart as text."""
    return [text_of(row) for row in MapChart(marks).draw(robot, targets, columns, rows)]


def robot_of(*messages: Robot) -> RobotState:
    """A robot that has sent these messages."""
    robot = RobotState()
    for message in messages:
        robot.take(message)
    return robot


def placed(x: float, y: float, yaw: float, *messages: Robot) -> RobotState:
    """A robot in the room that has sent these messages, too."""
    return robot_of(room(), (FrameTransform("map", "base_link", x, y, yaw),), *messages)


def test_walls_robot_and_waypoints():
    """Two square pixels in each cell; the robot points where it looks, north is up."""
    assert drawn(placed(1.0, 2.0, QUARTER), ((3.0, 1.0), (3.0, 3.0))) == [
        "                        ",
        "   █▀▀▀▀▀▀▀▀▀▀▀▀▀▀▀▀▀▀█ ",
        "   █                  █ ",
        "   █              2   █ ",
        "   █                  █ ",
        "   █                  █ ",
        "   █    ↑             █ ",
        "   █                  █ ",
        "   █              1   █ ",
        "   █                  █ ",
        "   █▄▄▄▄▄▄▄▄▄▄▄▄▄▄▄▄▄▄█ ",
        "                        ",
    ]


@pytest.mark.parametrize(
    ("yaw", "arrow"), [(0.0, "→"), (0.8, "↗"), (QUARTER, "↑"), (3.1, "←"), (-3.1, "←"), (-0.8, "↘")]
)
def test_the_arrow_points_where_the_robot_looks(yaw: float, arrow: str):
    """In eight directions."""
    assert any(arrow in row for row in drawn(placed(2.0, 2.0, yaw)))


def test_the_trail_is_dotted():
    """Under the robot and the waypoints."""
    robot = placed(0.5, 2.0, 0.0)
    for step in range(1, 20):
        robot.take((FrameTransform("map", "base_link", 0.5 + 0.1 * step, 2.0, 0.0),))
    (row,) = (row for row in drawn(robot) if "→" in row)
    assert row.count("·") >= 8


def test_a_scan_shows_what_the_map_does_not_know():
    """A hit on a wall, or a pixel beside it, colours the wall; another has a sign of its own."""
    lidar = (FrameTransform("base_link", "base_scan", 0.0, 0.0, 0.0),)
    scan = ScanPoints("base_scan", 0.0, QUARTER, 0.1, 3.5, (1.0, 1.75))
    robot = placed(2.0, 2.0, 0.0, lidar, scan)
    rows = MapChart(SIGNS).draw(robot, (), 24, 12)
    hits = [text for row in rows for text, style in row if style == "scan"]
    assert len(hits) == 2
    assert SIGNS.scan in hits
    assert any(text in SIGNS.wall for text in hits)


def test_without_utf_8_it_is_drawn_in_ascii():
    """The same facts with other signs."""
    rows = drawn(placed(1.0, 2.0, QUARTER), ((3.0, 1.0),), marks=ASCII_SIGNS)
    assert all(row.isascii() for row in rows)
    assert any("^" in row for row in rows)
    assert any("#" in row for row in rows)


def test_what_is_not_known_is_shaded_within_what_is():
    """Around it nothing is drawn."""
    cells = bytearray([255]) * 1600
    for row in range(5, 35):
        for column in (5, 34) if 12 < row < 28 else range(5, 35):
            cells[row * 40 + column] = 0
    rows = drawn(robot_of(Map(0.1, 40, 40, 0.0, 0.0, 0.0, bytes(cells))))
    assert any("░░░" in row for row in rows)
    assert all(row.strip("░ ") == "" for row in rows)
    assert not rows[0].strip()


def test_a_map_that_is_turned_is_drawn_where_it_lies():
    """A quarter turn about its origin puts the room to the left of it."""
    robot = robot_of(room(yaw=QUARTER), (FrameTransform("map", "base_link", -2.0, 2.0, 0.0),))
    (row,) = (row for row in drawn(robot) if "→" in row)
    assert row.index("█") < row.index("→") < row.rindex("█")


def test_without_a_map_what_is_seen_is_drawn():
    """The scan, the trail and the robot."""
    robot = robot_of((FrameTransform("odom", "base_link", 0.0, 0.0, 0.0),))
    assert any("→" in row for row in drawn(robot))


def test_of_a_robot_of_which_nothing_is_known_nothing_is_drawn():
    """Nor on a terminal without room; a broken map is none."""
    assert drawn(RobotState()) == []
    assert drawn(placed(1.0, 1.0, 0.0), columns=0) == []
    assert drawn(robot_of(Map(0.1, 40, 40, 0.0, 0.0, 0.0, b"\0"))) == []


def test_a_large_terminal_has_no_holes_in_its_walls():
    """No pixel is smaller than a cell of the map."""
    rows = drawn(placed(2.0, 2.0, 0.0), columns=300, rows=100)
    walls = [row.strip() for row in rows if "█" in row]
    assert walls[0] == "█" * len(walls[0])


def test_zones_and_places_have_their_names_on_the_map():
    """Below the robot and its waypoints."""
    robot = placed(1.0, 2.0, QUARTER, Zones((ZoneDisc("dock", 2.0, 2.0, 0.1, "#ffffff"),)))
    rows = drawn(robot, ((2.0, 1.0),))
    assert any("dock" in row for row in rows)
    assert "do1" in "".join(drawn(robot, ((2.4, 2.0),)))
