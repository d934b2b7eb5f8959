"""The commands of the command line: each has its folder or file."""
