"""Sessions of pytest within this one (pytester) forget the modules that they were first to import.

NumPy refuses to be imported again, so it has to be there before them.
"""

import bt_mission.testing.stages  # noqa: F401
