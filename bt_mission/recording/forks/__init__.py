"""Recorded runs that are run again: as they were up to an instant, then with a change."""
