@pytest.mark.parametrize(
    "x", [0.0, -0.0, 0.1, 1e-300, 1e22, -12345.678901234567, math.inf, math.nan]
)
def test_the_pose_is_written_as_any_other_event(x: float) -> None:
    """Byte for byte, whatever the numbers."""
    by_hand, by_fields = Trace(), Trace()
    by_hand.record_pose(S, (x, 2.5, -x), 3)
    by_fields.record(S, "pose", x=x, y=2.5, yaw=-x, collisions=3)
    assert list(by_hand.newest) == list(by_fields.newest)
