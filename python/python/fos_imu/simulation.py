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
    """Three logs of one unit, and the truth.

    Attributes:
        quiet: Nothing is missing in it.
        field: With the planted effects: to be explained.
        later: With the same: to be corrected.
        truth: What was planted, the noise, the true rate.
    """

    quiet: Recording
    field: Recording
    later: Recording
    truth: Mapping[str, Any]


def simulate_case(
    planted: Sequence[str | Plant] = (),
    *,
    setup: Literal["bench", "desk", "pose_rig", "shaker", "rate_table"] = "bench",
    part: str = "bmi270",
    axis: str = "gx",
    seed: int = 1,
    world: str = "clean",
    quiet_s: float = 600.0,
    field_s: float = 1500.0,
    later_s: float = 900.0,
) -> Case:
    """A case: a reference log, a log with planted effects, and a later evaluation log, of one device.

    Args:
        planted: Effects by identifier, with size and parameter as `Plant`; none: nothing is missing.
        setup: How the unit is used.
        part: `bmi160`, `bmi270`, `lsm6dso`, `icm42688`, `mpu6050`.
        axis: The one that is to be explained.
        seed: Of every random number.
        world: What disturbs field and later; `clean`: nothing.
        quiet_s: Duration of the reference log, s.
        field_s: Duration of the log to explain, s.
        later_s: Duration of the later log, s.

    Raises:
        SimulationError: A plan that cannot be carried out.
    """
    plants = [one if isinstance(one, Plant) else Plant(one) for one in planted]
    rows = [(one.effect, float(one.size), one.parameter) for one in plants]
    durations = (quiet_s, field_s, later_s)
    quiet, field, later, truth = _engine.simulate_case(rows, setup, part, axis, seed, world, durations)
    return Case(Recording(quiet), Recording(field), Recording(later), MappingProxyType(json.loads(truth)))
