"""The arbiter between several sources of velocity commands and the base."""
