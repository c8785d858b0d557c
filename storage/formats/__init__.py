"""Recordings as files: the exchange folder, columns in Parquet, and ROS 2 bags in MCAP."""
