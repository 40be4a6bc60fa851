"""Diagnosis during a live run: the job, the process that judges it, and what to set on the twin. No ROS."""
