"""The frequency of garbage collection: rare while a command loads, never for what it loaded."""

from __future__ import annotations

import gc

WHILE_LOADING = 200_000
"""New objects before a collection, instead of Python's 700: imported modules are not garbage."""

_USUAL = gc.get_threshold()


def spare_collections() -> None:
    """Collect rarely, until :func:`settle_memory` is called. Only for processes of this package."""
    gc.set_threshold(WHILE_LOADING)


def settle_memory() -> None:
    """Exempt all present objects from collections, and collect as often as usual from now on.

    A collection of all of them takes a tenth of a second. Call it after the set-up. In a foreign
    process, where collections were not rare, it does nothing.
    """
    if gc.get_threshold()[0] == WHILE_LOADING:
        gc.freeze()
        gc.set_threshold(*_USUAL)
