from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from action_servers.core.maneuver import Grid
from action_servers.mapping.node import MapFileError, save
from bt_mission.base.yaml.document import read

GRID = Grid(0.05, -1.5, 2.25, np.array([[0, 100, -1], [0, 0, -1]], dtype=np.int8))


def served(picture: Path, about: dict[str, Any]) -> np.ndarray:
    """The cells that Nav2's map server makes of a picture in mode trinary, lowest y first."""
    with Image.open(picture) as image:
        grey = np.asarray(image, dtype=float)
    occupancy = (255.0 - grey) / 255.0
    cells = np.full(grey.shape, -1)
    cells[occupancy < about["free_thresh"]] = 0
    cells[occupancy > about["occupied_thresh"]] = 100
    return cells[::-1]


def test_the_map_server_gets_back_the_map_that_was_saved(tmp_path):
    """Every cell, the resolution and the corner."""
    picture, about_file = save(GRID, tmp_path / "arena")
    about = read(about_file).data
    assert np.array_equal(served(picture, about), GRID.cells)
    assert about == {
        "image": "arena.pgm",
        "mode": "trinary",
        "resolution": 0.05,
        "origin": [-1.5, 2.25, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }


def test_the_picture_is_a_pgm_with_the_largest_y_on_top(tmp_path):
    """Binary, 8 bits; 254 free, 205 unknown, 0 occupied."""
    picture, _ = save(GRID, tmp_path / "map")
    assert picture.read_bytes() == b"P5\n3 2\n255\n" + bytes([254, 254, 205, 254, 0, 205])


def test_dots_and_blanks_in_the_name_stay(tmp_path):
    """The ending is added, not put in the place of what looks like one; folders are made."""
    picture, about = save(GRID, tmp_path / "maps" / "run 1.5")
    assert (picture.name, about.name) == ("run 1.5.pgm", "run 1.5.yaml")
    assert read(about).data["image"] == "run 1.5.pgm"


def test_a_map_without_cells_is_not_saved(tmp_path):
    """There is nothing to write yet, and the reason says so."""
    empty = Grid(0.05, 0.0, 0.0, np.zeros((0, 0), dtype=np.int8))
    with pytest.raises(MapFileError, match="no map yet"):
        save(empty, tmp_path / "map")
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_to_is_named(tmp_path):
    """A file stands where the folder should be."""
    (tmp_path / "taken").write_text("")
    with pytest.raises(MapFileError, match="taken"):
        save(GRID, tmp_path / "taken" / "map")
