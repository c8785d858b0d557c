"""Raw recordings: ROS 2 bags in MCAP, written once and read in whole chunks."""
