"""Zones as markers."""

from builtin_interfaces.msg import Time
from visualization_msgs.msg import Marker

from sim.ros.world_messages import zone_markers
from sim.world.loader import load_world
from sim.world.world import World


def test_a_zone_is_a_disc_with_a_name() -> None:
    """On the map, of its size."""
    zone = {"name": "A", "x": 1.0, "y": 2.0, "radius": 0.3, "colour": "green"}
    world = World.model_validate({"name": "test", "size": [8, 8], "zones": [zone]})
    disc, name = zone_markers(world, Time(sec=1)).markers
    assert (disc.type, disc.header.frame_id, disc.scale.x) == (Marker.CYLINDER, "map", 0.6)
    assert (disc.pose.position.x, disc.pose.position.y) == (1.0, 2.0)
    assert disc.color.g > disc.color.r
    assert (name.type, name.text) == (Marker.TEXT_VIEW_FACING, "A")


def test_markers_are_told_apart() -> None:
    """By namespace and number."""
    every = zone_markers(load_world("nav_arena"), Time()).markers
    assert len({(marker.ns, marker.id) for marker in every}) == len(every) == 8


def test_places_are_marked_beside_zones():
    """With a small disc of their own number."""
    every = zone_markers(load_world("nav_arena"), Time(), {"dock": (0.5, 1.0)}).markers
    disc, name = every[-2:]
    assert (name.text, disc.pose.position.x, disc.pose.position.y) == ("dock", 0.5, 1.0)
    assert disc.id == name.id == 4
    assert disc.scale.x < every[0].scale.x
