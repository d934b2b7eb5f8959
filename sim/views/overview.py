"""The world from above, as a map: what stands still is drawn once, what moves in patches.

A whole picture with smooth edges and shadows takes a CPU 70 ms, a patch around the robot 2 ms.
A patch is drawn without shadows, which would take another 6 ms: its own shadow is made from its
outline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from sim.physics.names import (
    BASE,
    LOOKS,
    LOOSE_PREFIX,
    MOVER_PREFIX,
    NOWHERE,
    PROP_PREFIX,
    SOLID,
)
from sim.sensors.canvas import Canvas, Image
from sim.world.world import World

_MARGIN = 0.1
"""m around the world."""

_SHADOW = (0.3, 0.45)
"""m to the right and up where the shadow of what is a metre high ends (`sim.physics.scenery`)."""

_DIMMED = 0.63
"""The remaining brightness of a floor in the shadow."""

_SMOOTH, _SHADOW_MAP = 4, 4096
"""Samples a pixel; texels of the shadows each way."""

_ALIKE = 10
"""Pixels that differ by less show the same."""

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class OverviewPatch:
    """Something that moves, with what is around it: its place in the picture, and its pixels.

    Args:
        left: And `top`: pixels from the picture's edges.
        thing: Where in the patch it is.
        shade: Where its shadow falls.
    """

    left: int
    top: int
    picture: Image
    thing: Mask
    shade: Mask

    def paint(self, onto: Image) -> None:
        """Put it, with its shadow, into a whole picture."""
        height, width, _ = self.picture.shape
        part = onto[self.top : self.top + height, self.left : self.left + width]
        part[self.shade] = part[self.shade] * _DIMMED
        part[self.thing] = self.picture[self.thing]


class Overview:
    """Draws a world from straight above, y up, as large as fits into `width` x `height` pixels.

    `model` and `data` must not be shared: parts of them are changed. Raises NoCameraError.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, world: World, width: int, height: int
    ) -> None:
        self._model, self._data = model, data
        left, low, right, high = _bounds(world)
        self.scale = min(width / (right - left), height / (high - low))
        """Pixels per metre."""
        self._size = (width, height)
        self._centre = ((left + right) / 2, (low + high) / 2)
        self._things = [
            (body, _geoms_below(model, body))
            for body in range(model.nbody)
            if model.body(body).name.endswith(BASE)
            or model.body(body).name.startswith((MOVER_PREFIX, PROP_PREFIX, LOOSE_PREFIX))
        ]
        _shade_tops(model)
        model.vis.quality.offsamples = _SMOOTH
        self.still = self._draw_still(shadows=True)
        """The whole picture without anything that can move."""
        lit = self._draw_still(shadows=False)
        self._lit = lit.astype(np.int16)
        self._shaded = _differ(self.still, self._lit)
        self._canvas = self._small_canvas()

    def pixel(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Return the pixels of points of the map, from left and top of the image.

        Coordinates are numbers, or arrays of them.
        """
        width, height = self._size
        u = width / 2 + (x - self._centre[0]) * self.scale
        return u, height / 2 - (y - self._centre[1]) * self.scale

    def moving(self) -> list[OverviewPatch]:
        """Return what can move, where it is now."""
        patches = []
        for body, geoms in self._things:
            shown = geoms[np.isin(self._model.geom_group[geoms], (SOLID, LOOKS))]
            patch = self._around(body, shown) if len(shown) else None
            if patch is not None:
                patches.append(patch)
        return patches

    def close(self) -> None:
        """Give the renderer back."""
        self._canvas.close()

    def _draw_still(self, *, shadows: bool) -> Image:
        model, (width, height) = self._model, self._size
        groups = model.geom_group.copy()
        model.geom_group[np.concatenate([geoms for _, geoms in self._things])] = NOWHERE
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        model.vis.quality.shadowsize = _SHADOW_MAP
        canvas = Canvas(model, shadows=shadows)
        picture = self._draw(canvas, 0, 0, width, height)
        canvas.close()
        model.geom_group[:] = groups
        return picture

    def _small_canvas(self) -> Canvas:
        """Return a canvas no larger than the patches need: all of it is cleared for each."""
        width, height = self._size
        sizes = [self._half(body, geoms) for body, geoms in self._things]
        names = (self._model.body(body).name for body, _ in self._things)
        if not any(name.startswith(PROP_PREFIX) for name in names):  # their size is not known yet
            width, height = min(width, 2 * max(sizes) + 8), min(height, 2 * max(sizes) + 8)
        self._most = (width, height)
        size = self._model.vis.global_
        self._model.vis.quality.shadowsize = 0
        size.offwidth, size.offheight = width, height
        return Canvas(self._model)

    def _half(self, body: int, geoms: npt.NDArray[np.intp]) -> int:
        """Return how far from its middle something may reach with its shadow, in pixels."""
        x, y = self._data.xpos[body, :2].tolist()
        places, sizes = self._data.geom_xpos[geoms], self._model.geom_rbound[geoms]
        reach = np.hypot(places[:, 0] - x, places[:, 1] - y) + sizes
        shadow = math.hypot(*_SHADOW) * self._height(geoms)
        return math.ceil((float(reach.max()) + shadow) * self.scale)

    def _height(self, geoms: npt.NDArray[np.intp]) -> float:
        """Return how high it is, m."""
        model, data = self._model, self._data
        half = np.abs(data.geom_xmat[geoms].reshape(-1, 3, 3)[:, 2]) * model.geom_aabb[geoms, 3:]
        return float((data.geom_xpos[geoms, 2] + half.sum(axis=1)).max())

    def _around(self, body: int, geoms: npt.NDArray[np.intp]) -> OverviewPatch | None:
        u, v = (round(part) for part in self.pixel(*self._data.xpos[body, :2].tolist()))
        (width, height), half = self._size, self._half(body, geoms)
        across, down = (min(half, most // 2) for most in self._most)
        left, top = max(u - across, 0), max(v - down, 0)
        right, bottom = min(u + across, width), min(v + down, height)
        if left >= right or top >= bottom:
            return None
        picture = self._draw(self._canvas, left, top, right - left, bottom - top)
        thing = _differ(picture, self._lit[top:bottom, left:right])
        to_right, up = (part * self._height(geoms) * self.scale for part in _SHADOW)
        shade = _swept(thing, to_right, up) & ~self._shaded[top:bottom, left:right] & ~thing
        return OverviewPatch(left, top, picture, thing, shade)

    def _draw(self, canvas: Canvas, left: int, top: int, width: int, height: int) -> Image:
        """Draw a part of the picture; on whole pixels, so that all parts are alike."""
        whole_width, whole_height = self._size
        view = canvas.view
        view.type = mujoco.mjtCamera.mjCAMERA_FREE
        view.orthographic = 1
        view.azimuth, view.elevation, view.distance = 90.0, -90.0, 10.0
        view.lookat[0] = self._centre[0] + (left + (width - whole_width) / 2) / self.scale
        view.lookat[1] = self._centre[1] - (top + (height - whole_height) / 2) / self.scale
        view.lookat[2] = 0.0
        self._model.vis.global_.fovy = height / self.scale  # of such a view: its height in m
        picture = np.empty((height, width, 3), dtype=np.uint8)
        canvas.draw(self._data, picture)
        return picture


def _shade_tops(model: mujoco.MjModel) -> None:
    """Make boxes a little lower, each by another bit: where tops coincide, light adds up."""
    boxes = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_BOX.value)
    model.geom_size[boxes, 2] *= 1 - 0.0002 * (np.arange(len(boxes)) % 8)


def _geoms_below(model: mujoco.MjModel, body: int) -> npt.NDArray[np.intp]:
    """Return the geoms of a body and of those that hang on it (wheels, arms)."""
    bodies = model.geom_bodyid
    of_ours = (bodies == body) | (model.body_parentid[bodies] == body)
    return np.flatnonzero(of_ours | (model.body_rootid[bodies] == body))


def _differ(picture: Image, other: npt.NDArray[np.int16]) -> Mask:
    differs: Mask = np.abs(picture - other).max(axis=2) > _ALIKE
    return differs


def _swept(thing: Mask, to_right: float, up: float) -> Mask:
    """Return all places of an outline that is moved by some pixels."""
    height, width = thing.shape
    swept = thing.copy()
    steps = math.ceil(max(to_right, up) / 2)
    for step in range(1, steps + 1):
        right, high = round(to_right * step / steps), round(up * step / steps)
        if right < width and high < height:
            swept[: height - high, right:] |= thing[high:, : width - right]
    return swept


def _bounds(world: World) -> tuple[float, float, float, float]:
    """Return the left, low, right and high end of the visible part, m."""
    length, width = world.size
    xs, ys = [-length / 2, length / 2], [-width / 2, width / 2]
    for thing in world.obstacles:
        cos, sin = abs(math.cos(thing.yaw)), abs(math.sin(thing.yaw))
        long, wide = thing.size[0] / 2, thing.size[1] / 2
        xs += [thing.x + side * (cos * long + sin * wide) for side in (-1, 1)]
        ys += [thing.y + side * (sin * long + cos * wide) for side in (-1, 1)]
    return min(xs) - _MARGIN, min(ys) - _MARGIN, max(xs) + _MARGIN, max(ys) + _MARGIN
