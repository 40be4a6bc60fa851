"""Follow a bench sample by sample, and judge how well: pairing, pace, trend, verdict. No ROS."""
