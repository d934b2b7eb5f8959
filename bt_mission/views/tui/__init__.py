"""The full-screen view of a mission, with Textual."""
