"""Worlds: their files, shapes and moving obstacles."""
