"""A diagnosis beside a running bench: the job, the process that judges it, and what to set on the twin. No ROS."""
