"""Evidence as a bag: the residuals of each step of a discovery, sample by sample, for rerun, Foxglove and PlotJuggler.

Every topic is a ``sensor_msgs/JointState``, which all of them plot by the names in it: torques [N m, motor shaft] in
``effort``, encoder differences [rad, slow shaft] in ``position``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_bench_replay.bags.bag_metadata import JOINTS_QOS, Topic
from ema_bench_replay.bags.bag_writer import JOINTS_TYPE, Encoder, chunks, encoder_of
from ema_bench_replay.bags.mcap_file import McapFile
from ema_bench_replay.outputs import new_file
from ema_bench_replay.recording import Recording

from ..discovery.discover import Discovery
from ..discovery.evidence import Compared, compared_fits
from ..measured.folds import HALF_OF
from ..model.own_units import shown
from ..plant.motion import MOTOR_ANGLE, SPEED


@dataclass(frozen=True, eq=False)
class _Topic:
    """Series (n,) of one topic, under their names."""

    name: str
    field: str  # effort or position
    stamps: np.ndarray  # int64 (n,), ns since the epoch
    series: Mapping[str, np.ndarray]


def write_evidence(found: Discovery, recordings: Sequence[Recording], path: Path, *, force: bool = False) -> list[str]:
    """Write the evidence as one MCAP file; return its topics.

    ``/evidence/STEP/RECORDING/torque`` holds the measured motor torque, and the torque that the model before and after
    the step needs for the measured motion. ``…/left_over`` holds measured minus model (before, after, and with the
    runner-up instead), ``…/encoder_difference`` the output encoder minus the motor's over the ratio. Operating points
    have no meaningful time: their topics are ``…/over_position/forward/torque`` and so on (backward; over_speed if the
    position does not vary), with one second for each radian of the motor, or rad/s, counted from the smallest value.
    Raises InputError if the file exists (without ``force``) or cannot be written.
    """
    topics = [
        topic
        for number, compared in enumerate(compared_fits(found), 1)
        for topic in _topics(found, recordings, compared, f"/evidence/step_{number}_{_name(compared.title)}")
    ]
    with new_file(path, force=force) as stream:
        file = McapFile(stream)
        file.add_metadata("ema_twin_evidence", {"verdict": found.verdict, "added": " ".join(found.added)})
        for chunk in chunks([_records(file, topic) for topic in topics]):
            file.add_chunk(chunk)
        file.finish()
    return [topic.name for topic in topics]


def _topics(found: Discovery, recordings: Sequence[Recording], compared: Compared, at: str) -> Iterator[_Topic]:
    if recordings[0].of_points:
        yield from _topics_of_points(found, recordings, compared, at)
        return
    problem = found.equation
    residuals = {name: f.problem.left_over(f.predicted) for name, f in compared.fits.items()}
    base = compared.fits["after"].hypothesis.base
    second, size, way = (shown(base, 1.0, unit)[0] for unit in ("s", "N m", "rad"))
    parts = zip(recordings, problem.observations, problem.torque_parts, problem.encoder_parts, strict=True)
    for recording, o, torque, encoder in parts:
        here = f"{at}/{_name(recording.name)}"
        left = {name: size * r[torque] * o.torque_noise for name, r in residuals.items()}
        stamps = _stamps(recording, second * o.motion[o.rows, 0])
        drive = size * o.torque
        models = {f"model {name}": drive - left[name] for name in ("before", "after")}
        yield _Topic(f"{here}/torque", "effort", stamps, {"measured": drive, **models})
        yield _Topic(f"{here}/left_over", "effort", stamps, _titled(left, compared))
        if len(o.encoder_rows):
            apart = {name: way * r[encoder] * o.encoder_noise for name, r in residuals.items()}
            stamps = _stamps(recording, second * o.motion[o.encoder_rows, 0])
            series = {"measured": way * (o.encoder - np.median(o.encoder)), **_titled(apart, compared)}
            yield _Topic(f"{here}/encoder_difference", "position", stamps, series)


def _topics_of_points(
    found: Discovery, recordings: Sequence[Recording], compared: Compared, at: str
) -> Iterator[_Topic]:
    """Torques of operating points in the order of their positions, separately for each direction of motion.

    The halves of a single table that the search had split are put together again.
    """
    problem = found.equation
    residuals = {name: f.problem.left_over(f.predicted) for name, f in compared.fits.items()}
    base = compared.fits["after"].hypothesis.base
    size = shown(base, 1.0, "N m")[0]
    wholes: dict[str, list[int]] = {}
    for k, recording in enumerate(recordings):
        wholes.setdefault(recording.metadata.get(HALF_OF, recording.name), []).append(k)
    for whole, halves in wholes.items():
        parts = [(problem.observations[k], problem.torque_parts[k]) for k in halves]
        motion = np.concatenate([o.motion[o.rows] for o, _ in parts])
        measured = size * np.concatenate([o.torque for o, _ in parts])
        torques = {name: [r[part] * o.torque_noise for o, part in parts] for name, r in residuals.items()}
        left = {name: size * np.concatenate(each) for name, each in torques.items()}
        by, column = ("position", MOTOR_ANGLE) if np.ptp(motion[:, MOTOR_ANGLE]) > 0.0 else ("speed", SPEED)
        native = shown(base, 1.0, "rad" if column == MOTOR_ANGLE else "rad/s")[0]
        over = native * (motion[:, column] - motion[:, column].min())
        for way, sense in (("forward", 1.0), ("backward", -1.0)):
            chosen = np.flatnonzero(np.sign(motion[:, SPEED]) == sense)
            chosen = chosen[np.argsort(over[chosen], kind="stable")]
            if not len(chosen):
                continue
            here = f"{at}/{_name(whole)}/over_{by}/{way}"
            stamps = _stamps(recordings[halves[0]], over[chosen])
            series = {name: values[chosen] for name, values in left.items()}
            models = {f"model {name}": measured[chosen] - series[name] for name in ("before", "after")}
            yield _Topic(f"{here}/torque", "effort", stamps, {"measured": measured[chosen], **models})
            yield _Topic(f"{here}/left_over", "effort", stamps, _titled(series, compared))


def _titled(series: Mapping[str, np.ndarray], compared: Compared) -> dict[str, np.ndarray]:
    """The residuals of each model, under a descriptive name."""
    titles = {
        "before": "left over before",
        "after": f"left over with {compared.title}",
        "runner_up": f"left over with {compared.runner_up}",
    }
    return {titles[name]: values for name, values in series.items()}


def _stamps(recording: Recording, time: np.ndarray) -> np.ndarray:
    return recording.start + np.round(time * 1e9).astype(np.int64)


def _name(text: str) -> str:
    """The text as one word of a topic's name."""
    return re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")


def _records(file: McapFile, topic: _Topic) -> tuple[Encoder, np.ndarray]:
    """The message records (n,) of a topic, which is added to the file."""
    example = {"name": list(topic.series), topic.field: [0.0] * len(topic.series)}
    encoder = encoder_of(file, Topic(topic.name, JOINTS_TYPE, JOINTS_QOS), example)
    columns = {topic.field: np.column_stack(list(topic.series.values()))}
    return encoder, encoder.encode(topic.stamps, np.arange(len(topic.stamps)), columns)
