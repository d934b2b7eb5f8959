"""Modules that all packages may import: errors, YAML with places, data files, robot models, DDS."""
