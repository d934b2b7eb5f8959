"""YAML read with the place of every value, and checked against models."""
