"""Memory of a process that shows pictures."""

from __future__ import annotations

import gc


def settle_memory() -> None:
    """Take what is imported by now for permanent: call it once, before a view is shown.

    To look through all of it for garbage would stop the picture for a tenth of a second each time.
    """
    gc.collect()
    gc.freeze()
