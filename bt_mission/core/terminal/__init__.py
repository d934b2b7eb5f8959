"""Borders of a terminal: all text that goes to one is escaped on its way."""
