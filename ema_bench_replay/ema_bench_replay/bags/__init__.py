"""Bags: MCAP files that ROS 2 tools open as they are, written and read in bulk."""
