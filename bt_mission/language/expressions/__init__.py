"""Expressions of the mission language: parsed once, evaluated safely, no ``eval``."""
