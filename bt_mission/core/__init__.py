"""What everyone may import: errors, located YAML, data folders, the robot model. Pure."""
