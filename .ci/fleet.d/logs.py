"""A folder of simulated units with its units.csv: each a part of its own, with bias, slopes and noise of its own seed."""

import multiprocessing
import os
from pathlib import Path

import fos_imu as fos


def _write(job):
    path, minutes, seed = job
    fos.simulate(minutes=minutes, seed=seed, motion=False).write(path)


def write(folder: Path, units: int, minutes: float) -> list[tuple[str, str, str, str]]:
    """The lines of units.csv: unit, part, lot, log."""
    lines = [(f"u{seed:04}", "bmi270", f"lot{seed % 4}", f"u{seed:04}.parquet") for seed in range(units)]
    folder.mkdir(parents=True)
    jobs = [(folder / log, minutes, seed) for seed, (*_, log) in enumerate(lines, 1)]
    with multiprocessing.get_context("spawn").Pool(os.cpu_count()) as pool:
        pool.map(_write, jobs, chunksize=4)
    table(folder, lines)
    return lines


def table(folder: Path, lines) -> None:
    (folder / "units.csv").write_text(
        "\n".join(",".join(line) for line in [("unit", "part", "lot", "log"), *lines]) + "\n"
    )
