"""The electrical side of the switching drive: resolver, current references, inverter, winding and acquisition.

``step.switching_step`` computes all of it for one step of about 1 us, with the constants that ``step_constants``
derives from a winding's record (``layout.WINDING``). The speed controller before it is the averaged drive's.
"""
