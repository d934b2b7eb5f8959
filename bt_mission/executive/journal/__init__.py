"""A mission's journal on disk, and how a mission resumes after the death of its process."""
