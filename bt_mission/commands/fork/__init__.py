"""Recorded runs that run again: unchanged up to an instant, then with a change."""
