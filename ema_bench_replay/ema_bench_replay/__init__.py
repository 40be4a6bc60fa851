"""Recordings of an actuator bench: Siemens traces and MCAP read into immutable objects, and the ROS nodes for both."""
