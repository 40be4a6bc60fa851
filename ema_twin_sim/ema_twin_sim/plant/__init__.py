"""The compiled plant: drive, transmission, friction and sensors, advanced step by step, without ROS or files."""

from .machine_code import keep_by_content, load_without_compiler

keep_by_content()
load_without_compiler()
