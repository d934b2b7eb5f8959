"""The root of every error this package raises on purpose."""


class BtMissionError(Exception):
    """Something the user, the robot or the machine did, told in words they can act on."""
