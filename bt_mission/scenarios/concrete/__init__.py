"""Concrete scenarios: values are drawn, each is run by a worker, and gives a row."""
