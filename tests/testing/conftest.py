"""Sessions of pytest within this one (pytester) forget the modules that they were first to import.

NumPy refuses to be imported again, so all of it has to be there before them.
"""

import action_servers.navigation.planner  # noqa: F401 - parts of NumPy that SciPy alone imports
import bt_mission.testing.stages  # noqa: F401
