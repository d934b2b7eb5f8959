"""Facts about stamps as numbers."""

from types import SimpleNamespace

from bt_mission.base.stamps import set_ns, to_ns


def test_time_is_split_into_seconds_and_nanoseconds():
    """As in builtin_interfaces/Time; and put together again."""
    stamp = SimpleNamespace(sec=0, nanosec=0)
    set_ns(stamp, 12_345_678_901)
    assert (stamp.sec, stamp.nanosec) == (12, 345_678_901)
    assert to_ns(stamp) == 12_345_678_901


def test_a_negative_duration_has_nanoseconds_on_top():
    """As ROS has it: seconds are rounded down."""
    stamp = SimpleNamespace(sec=0, nanosec=0)
    set_ns(stamp, -250_000_000)
    assert (stamp.sec, stamp.nanosec) == (-1, 750_000_000)
    assert to_ns(stamp) == -250_000_000
