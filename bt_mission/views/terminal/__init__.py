"""What people see of a run: a live tree, plain lines, and the summary at the end."""
