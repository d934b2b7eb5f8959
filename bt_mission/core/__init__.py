"""Modules that all packages may import: errors, located YAML, data folders, the robot model.

Pure.
"""
