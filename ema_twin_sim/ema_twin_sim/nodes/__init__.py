"""The ROS nodes `twin` and `monitor`, and `live`, which runs them together with a replay in one process."""
