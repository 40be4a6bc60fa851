"""The ROS nodes of recordings, `replay` and `record`, and what all nodes share."""
