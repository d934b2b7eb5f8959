"""The DDS middleware: which one, who hears whom, and who is alive."""
