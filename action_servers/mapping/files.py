"""A map as Nav2's map server reads it: a picture, and what its pixels mean."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt

from action_servers.core.grid import OCCUPIED_FROM
from action_servers.core.maneuver import Grid
from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import write_file

FREE_PIXEL, UNKNOWN_PIXEL, OCCUPIED_PIXEL = 254, 205, 0
"""Grey values of mode trinary, those of Nav2's map saver."""

OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
"""Darkness, 0 to 1, from which a pixel is read as occupied, and below which as free.

Nav2's map saver writes 0.25 for the second; its map server then takes the grey of unknown cells, 1
- 205 / 255 = 0.19608, for free ones. 0.196 keeps them unknown.
"""


class MapFileError(BtMissionError):
    """A map cannot be written."""

    code = "BT-1103"


def save(grid: Grid, prefix: Path) -> tuple[Path, Path]:
    """Write `prefix`.pgm and `prefix`.yaml. Return both paths.

    Raises MapFileError for a map without cells, and if the files cannot be written.
    """
    if not grid.cells.size:
        raise MapFileError("there is no map yet: no scan has been placed on it")
    prefix = prefix.expanduser().absolute()
    picture, about = (prefix.with_name(f"{prefix.name}.{end}") for end in ("pgm", "yaml"))
    rows, columns = grid.cells.shape
    header = f"P5\n{columns} {rows}\n255\n".encode("ascii")
    try:
        prefix.parent.mkdir(parents=True, exist_ok=True)
        write_file(picture, header + pixels(grid).tobytes())
        write_file(about, _about(grid, picture.name))
    except (OSError, BtMissionError) as error:
        raise MapFileError(f"the map cannot be written to {prefix}: {error}") from error
    return picture, about


def pixels(grid: Grid) -> npt.NDArray[np.uint8]:
    """Return a map as grey values, `rows x columns`; the first row is that of the largest y."""
    grey = np.full(grid.cells.shape, UNKNOWN_PIXEL, dtype=np.uint8)
    grey[(grid.cells >= 0) & (grid.cells < OCCUPIED_FROM)] = FREE_PIXEL
    grey[grid.cells >= OCCUPIED_FROM] = OCCUPIED_PIXEL
    return grey[::-1]


def _about(grid: Grid, image: str) -> str:
    # A text in JSON is also one in YAML, whatever the file's name contains.
    return (
        f"image: {json.dumps(image)}\n"
        "mode: trinary\n"
        f"resolution: {grid.resolution:g}\n"
        f"origin: [{grid.origin_x:.6g}, {grid.origin_y:.6g}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESH}\n"
        f"free_thresh: {FREE_THRESH}\n"
    )
