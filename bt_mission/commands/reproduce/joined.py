"""One recording from several files, with the names of topics that the readers know."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from operator import itemgetter
from pathlib import Path

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import counted
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordedFile, RecordingError
from bt_mission.recording.recorded_messages import EXECUTIVE

ROLES: Mapping[str, tuple[str, ...]] = {
    "scan": ("sensor_msgs/msg/LaserScan",),
    "odom": ("nav_msgs/msg/Odometry",),
    "tf": ("tf2_msgs/msg/TFMessage",),
    "tf_static": ("tf2_msgs/msg/TFMessage",),
    "map": ("nav_msgs/msg/OccupancyGrid",),
    "zones": ("visualization_msgs/msg/MarkerArray",),
    "cmd_vel": ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist"),
    "battery_state": ("sensor_msgs/msg/BatteryState",),
    "joint_states": ("sensor_msgs/msg/JointState",),
    "imu": ("sensor_msgs/msg/Imu",),
    "plan": ("nav_msgs/msg/Path",),
    "rosout": ("rcl_interfaces/msg/Log",),
}
"""The topics of a robot, and the types that each may have."""

SUFFIXES = (".mcap", ".mcap.gz", ".mcap.zst", ".mcap.zstd")
PERIOD_NS = 1_000_000_000
MOST_BACK_NS = 60 * PERIOD_NS
"""A recording whose times go back by more has two clocks."""
LONGEST_NS = 24 * 3600 * PERIOD_NS
CLOCKS = "were its parts recorded by different clocks?"


class ReproduceError(BtMissionError):
    """A recording from which no run can be reproduced."""

    code = "BT-1005"


def files_in(paths: Sequence[Path]) -> list[Path]:
    """Return the MCAP files of files and folders; a folder is one of rosbag2.

    Raises:
        ReproduceError: A folder has none.
    """
    files: list[Path] = []
    for path in paths:
        if not path.is_dir():
            files.append(path)
            continue
        inside = sorted(file for file in path.iterdir() if file.name.endswith(SUFFIXES))
        if not inside:
            raise ReproduceError(
                f"{path}: the folder has no MCAP file; recordings in another storage format are "
                "converted by `ros2 bag convert`"
            )
        files += inside
    return files


def renamed(written: Sequence[str]) -> dict[str, str]:
    """Return the roles of recorded topics, from texts such as ``scan:=/front/scan``.

    Raises:
        ReproduceError: For another text, or an unknown role.
    """
    roles: dict[str, str] = {}
    for text in written:
        role, is_given, topic = text.partition(":=")
        if not is_given or role.strip("/") not in ROLES or not topic:
            raise ReproduceError(
                f"--topic {text}: expected NAME:=TOPIC, with one of the names {', '.join(ROLES)}"
            )
        roles["/" + topic.strip("/")] = role.strip("/")
    return roles


def is_whole(paths: Sequence[Path], roles: Mapping[str, str]) -> bool:
    """Return whether the readers can read a recording as it is."""
    return len(paths) == 1 and not roles


def join(paths: Sequence[Path], roles: Mapping[str, str], target: Path) -> None:
    """Write the topics of one robot, in the order of time, with the names that readers know.

    Everything passes through in a stream, so the memory does not grow with the files.

    Raises:
        RecordingError: A file is not a recording.
        ReproduceError: A topic of ``--topic`` is not there, or times differ by more than a day.
    """
    files = [RecordedFile(path) for path in paths]
    file = McapFile(target, "bt-mission reproduce")
    channels: dict[str, int] = {}
    first = last = 0
    for time_ns, _, channel, data in heapq.merge(*map(_stream, files), key=itemgetter(0)):
        name = _name(channel, roles)
        if name is None:
            continue
        first = first or time_ns
        if time_ns - first > LONGEST_NS:
            file.abandon(CLOCKS)
            raise ReproduceError(f"{paths[0]}: its times span more than a day; {CLOCKS}")
        last = max(last, time_ns)
        if name not in channels:
            channels[name] = file.channel(name, channel.type_name, channel.definition, {})
        file.write(time_ns, [(channels[name], data)])
    for recorded in files:
        for note, facts in recorded.notes.items():
            file.note(note, facts)
        for attached in recorded.attached:
            file.attach(attached.name, attached.media_type, attached.data, attached.time_ns)
    file.close()
    missing = sorted(topic for topic, role in roles.items() if f"/{role}" not in channels)
    if missing:
        raise ReproduceError(
            f"{', '.join(map(str, paths))}: has no topic {missing[0]} (topics: "
            f"{'; '.join(filter(None, (recorded.topics for recorded in files)))})"
        )


def _stream(file: RecordedFile) -> Iterator[tuple[int, int, Channel, bytes]]:
    for number, (time_ns, channel, data) in enumerate(file.timed_messages()):
        yield time_ns, number, channel, data


def _name(channel: Channel, roles: Mapping[str, str]) -> str | None:
    """Return the name of a topic in the joined file; None to leave it out."""
    topic, kind = channel.topic, channel.type_name
    if topic in roles:
        return f"/{roles[topic]}"
    if "/_action/" in topic or kind in EXECUTIVE:
        return topic
    name = topic.rpartition("/")[2]
    if name in roles.values():
        return None  # another topic has this role
    if name in ROLES:
        return topic if kind in ROLES[name] else None
    return topic if name in ("trace", "signals", "collisions") or "ground_truth" in topic else None


def required(path: Path, topics: Mapping[str, int], *, tracks: int) -> None:
    """Raise ReproduceError where a recording lacks what a run is reproduced from."""
    here = ", ".join(sorted(topics)[:8]) or "none"
    if not tracks:
        raise ReproduceError(
            f"{path}: no pose of the robot is known: it needs nav_msgs/msg/Odometry on /odom, or "
            f"transforms of its base on /tf; name others with --topic odom:=/TOPIC (topics: {here})"
        )
    if not topics.get("scan") and not topics.get("map"):
        raise ReproduceError(
            f"{path}: has neither scans nor a map, so the world is unknown: it needs "
            "sensor_msgs/msg/LaserScan on /scan or nav_msgs/msg/OccupancyGrid on /map; name others "
            f"with --topic scan:=/TOPIC (topics: {here})"
        )


def refuse_jumps(path: Path, largest_back_ns: int, span_ns: int) -> None:
    """Refuse a recording whose clock was set, because its times have no order."""
    if largest_back_ns > MOST_BACK_NS:
        back = largest_back_ns / PERIOD_NS
        raise RecordingError(f"{path}: its times go back by {back:,.0f} s; {CLOCKS}")
    if span_ns > LONGEST_NS:
        days = counted(span_ns // LONGEST_NS, "day")
        raise RecordingError(f"{path}: its times span more than {days}; {CLOCKS}")
