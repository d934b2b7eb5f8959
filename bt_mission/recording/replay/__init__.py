"""A recorded run as it was at any instant, forwards and backwards. Pure: no ROS, no terminal."""
