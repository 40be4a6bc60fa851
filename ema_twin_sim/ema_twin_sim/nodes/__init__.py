"""The ROS nodes `twin` and `monitor`, and `live`, which runs them beside a replay in one process."""
