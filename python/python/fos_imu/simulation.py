"""Logs with known truth; every number from a seed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

from . import _engine
from .recording import Recording


def simulate(
    *,
    minutes: float = 20.0,
    rate_hz: float = 200.0,
    seed: int = 1,
    temperature: float = 1.0,
    motion: bool = True,
    truth: bool = False,
) -> Recording:
    """A log of a six-axis unit with a thermometer. The same arguments give the same log, here and in the program.

    Args:
        minutes: Duration, min.
        rate_hz: Nominal sample rate, Hz; the true one is off by up to 1 %.
        seed: Of every random number.
        temperature: Sensitivity to temperature, as a multiple of the unit's; 0 for none.
        motion: Move the unit for 30 s out of every 90 s in the last third.
        truth: Add the true values as `ref_ax_mps2` … `ref_gz_rads`.
    """
    return Recording(_engine.simulate(minutes, rate_hz, seed, temperature, motion, truth))


@dataclass(frozen=True)
class Plant:
    """An effect to be planted.

    Attributes:
        effect: Its identifier.
        size: In the noise of the log to explain, standard errors.
        parameter: In its own unit; drawn if None.
    """

    effect: str
    size: float = 30.0
    parameter: float | None = None


@dataclass(frozen=True)
class Case:
    """Three logs of one device, and the truth.

    Attributes:
        reference: Steady conditions; no effect is missing.
        log: The log to explain, with the planted effects.
        evaluation: A later log with the same effects.
        truth: What was planted, the noise, the true rate.
    """

    reference: Recording
    log: Recording
    evaluation: Recording
    truth: Mapping[str, Any]


def simulate_case(
    planted: Sequence[str | Plant] = (),
    *,
    setup: Literal["bench", "desk", "pose_rig", "shaker", "rate_table"] = "bench",
    part: str = "bmi270",
    axis: str = "gx",
    seed: int = 1,
    world: str = "clean",
    reference_s: float = 600.0,
    log_s: float = 1500.0,
    evaluation_s: float = 900.0,
) -> Case:
    """A case: a reference log, a log with planted effects, and a later evaluation log, of one device.

    Args:
        planted: Effects by identifier, with size and parameter as `Plant`; none: nothing is missing.
        setup: How the device is used.
        part: `bmi160`, `bmi270`, `lsm6dso`, `icm42688`, `mpu6050`.
        axis: The axis with the planted effects.
        seed: Of every random number.
        world: Disturbance of the log to explain and the evaluation log; `clean`: none.
        reference_s: Duration of the reference log, s.
        log_s: Duration of the log to explain, s.
        evaluation_s: Duration of the evaluation log, s.

    Raises:
        SimulationError: A plan that cannot be carried out.
    """
    plants = [one if isinstance(one, Plant) else Plant(one) for one in planted]
    rows = [(one.effect, float(one.size), one.parameter) for one in plants]
    durations = (reference_s, log_s, evaluation_s)
    reference, log, evaluation, truth = _engine.simulate_case(rows, setup, part, axis, seed, world, durations)
    return Case(Recording(reference), Recording(log), Recording(evaluation), MappingProxyType(json.loads(truth)))
