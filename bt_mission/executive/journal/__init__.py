"""A mission's journal on disk, and how a mission goes on from it after its process has died."""
