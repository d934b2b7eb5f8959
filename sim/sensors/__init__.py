"""Simulated sensors: lidar, IMU, encoders, camera, battery."""
