"""The ROS nodes `replay` and `record`, and code shared by all nodes."""
