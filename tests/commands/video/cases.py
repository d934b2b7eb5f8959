"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

WRITERS = {
    "bt_mission/commands/video/mp4.py": "the encoder's own open, on a stream of the one place",
}
