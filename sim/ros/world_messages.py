"""A world in messages: its map, and its zones as markers for RViz and Foxglove."""

from __future__ import annotations

import array
from collections.abc import Mapping
from typing import Any

from nav_msgs.msg import OccupancyGrid
from visualization_msgs.msg import Marker, MarkerArray

from sim import frames
from sim.ros import message_fields
from sim.world.colours import rgba
from sim.world.occupancy import OccupancyMap
from sim.world.world import World, Zone

_PLACE = 0.1
"""m: the radius of the disc of a place."""

_TEXT = 0.15
"""m: how high a zone's name is written."""


def occupancy_grid(drawn: OccupancyMap, stamp: Any) -> OccupancyGrid:
    """Return the map of a world."""
    grid = message_fields.header(OccupancyGrid(), stamp, frames.MAP)
    grid.info.map_load_time = stamp
    grid.info.resolution = drawn.resolution
    grid.info.height, grid.info.width = drawn.cells.shape
    grid.info.origin.position.x, grid.info.origin.position.y = drawn.origin
    grid.data = array.array("b", drawn.cells.tobytes())
    return grid


def zone_markers(
    world: World, stamp: Any, places: Mapping[str, tuple[float, float]] | None = None
) -> MarkerArray:
    """Return a disc and a name for each zone and place, which stay until they are replaced.

    Places are not part of a world: the camera does not see them.
    """
    named = (places or {}).items()
    marks = [
        Zone.model_construct(name=name, x=x, y=y, radius=_PLACE, colour="white")
        for name, (x, y) in named
    ]
    markers = []
    for index, zone in enumerate((*world.zones, *marks)):
        disc = _marker(zone, stamp, "zones", index, Marker.CYLINDER)
        disc.scale.x = disc.scale.y = 2 * zone.radius
        disc.scale.z = 0.002
        disc.color.r, disc.color.g, disc.color.b, _ = rgba(zone.colour)
        disc.color.a = 0.6
        name = _marker(zone, stamp, "zone names", index, Marker.TEXT_VIEW_FACING)
        name.text = zone.name
        name.pose.position.z = _TEXT
        name.scale.z = _TEXT
        name.color.r = name.color.g = name.color.b = name.color.a = 1.0
        markers += [disc, name]
    return MarkerArray(markers=markers)


def _marker(zone: Zone, stamp: Any, namespace: str, index: int, kind: int) -> Marker:
    marker = message_fields.header(Marker(ns=namespace, id=index, type=kind), stamp, frames.MAP)
    marker.pose.position.x, marker.pose.position.y = zone.x, zone.y
    return marker
