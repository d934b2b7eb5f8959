"""``python -m bt_mission`` is ``bt-mission``."""

import sys

from bt_mission.cli import main

sys.exit(main())
