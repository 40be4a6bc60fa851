"""Bags: MCAP files that ROS 2 tools open directly, written and read in bulk."""
