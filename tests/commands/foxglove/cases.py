"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

NOT_RUN_ON_PAGES = {"needs the viewer of Rerun": (r"rerun ",)}
