"""The command line, ``bt-mission``. One module a command; heavy imports happen inside them."""

from bt_mission.cli.main import main

__all__ = ["main"]
