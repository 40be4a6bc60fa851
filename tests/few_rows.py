"""Observations of a few rows that tests make by hand: nothing is recorded, and nothing simulated."""

import numpy as np

from ema_twin_sim.measured.observation import Observation

RATIO = 26.0  # about the stock machine's: the encoders' difference is told beside it


def few_rows(torque, noise=0.01, encoder=(), name="by_hand", kernel=(1.0,)):
    """Rows of ``torque`` (m,) [N m], at speeds that go from fast backward to fast forward, and of the encoders'
    difference [rad] at the first of them. With a ``kernel`` of one value they are operating points.
    """
    count, seen, margin = len(torque), len(encoder), len(kernel) // 2
    samples = count + 2 * margin
    speed = np.linspace(-5.0, 5.0, samples)
    time = 0.01 * np.arange(samples)
    angle = np.cumsum(speed) * 0.01
    motion = np.stack([time, angle, speed, np.zeros(samples), np.zeros(samples), angle / RATIO, np.zeros(samples)], 1)
    every = margin + np.arange(count)
    return Observation(
        name=name,
        period=0.01,
        geared=True,
        motion=motion,
        motor_origin=0.0,
        output_origin=0.0,
        kernel=np.array(kernel),
        rows=every,
        torque=np.asarray(torque, float),
        torque_rate=np.zeros(count),
        acceleration=np.zeros(count),
        acceleration_rest=np.zeros(count),
        acceleration_noise=0.0,
        inertia=0.0,
        torque_noise=np.full(count, noise),
        torque_reading=noise,
        torque_step=0.0,
        coarse=False,
        hit=np.zeros(samples),
        after_impact=np.zeros(samples, bool),
        encoder_rows=every[:seen],
        encoder=np.asarray(encoder, float),
        encoder_noise=np.full(seen, 1e-5),
        encoder_piece=np.zeros(seen, int),
    )
