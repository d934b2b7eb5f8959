"""Traces of runs that are over: read, told in words, compared. Their format: docs/reference/trace.md."""
