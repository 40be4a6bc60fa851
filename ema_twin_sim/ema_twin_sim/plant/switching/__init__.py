"""The electrical side of the switching drive: resolver, current references, inverter, winding and acquisition.

``step.switching_step`` is the whole of it for one step of about 1 us, on the constants that ``step_constants`` works
out of a winding's record (``layout.WINDING``). The speed controller in front of it is the averaged drive's.
"""
