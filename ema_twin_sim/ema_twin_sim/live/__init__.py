"""What follows a bench sample by sample, and judges it meanwhile: pairs, pace, trend, verdict. No ROS."""
