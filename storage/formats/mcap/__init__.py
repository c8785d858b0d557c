"""Raw recordings: ROS 2 bags in MCAP, written once, read whole chunks at a time."""
