"""Recordings of an actuator bench: Siemens traces and MCAP in, frozen recordings out, and the nodes for both."""
