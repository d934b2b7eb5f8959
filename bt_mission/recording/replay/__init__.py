"""A recorded run at any instant, forwards and backwards. Pure: no ROS, no terminal."""
