"""The DDS middleware: which one, its discovery, and its liveliness."""
