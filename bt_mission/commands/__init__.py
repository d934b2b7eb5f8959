"""The commands of the command line: each has its folder or file.

The row of each, which registers it, is in :mod:`bt_mission.base.commands`.
"""
