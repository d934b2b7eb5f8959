"""Outputs to a terminal: all text is escaped."""
