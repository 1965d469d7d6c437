"""What host-fit reads of a log of Axivity is what openmovement, of the maker, reads of it.

Usage: against_openmovement.py HOST_FIT CWA...
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from openmovement.load import CwaData

G, DEGREE = 9.80665, np.pi / 180
# full blocks follow each other by their own duration: stamps of both are those of the blocks, spread evenly
STAMP_S = 0.01


def ours(log):
    """Columns of a log as host-fit reads it."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "ours.csv"
        subprocess.run([sys.argv[1], "convert", str(log), "-o", str(out)], check=True, stdout=subprocess.DEVNULL)
        with open(out, newline="") as file:
            rows = csv.reader(file)
            names = next(rows)
            return dict(zip(names, np.array([[float(cell) if cell else np.nan for cell in row] for row in rows]).T))


for log in sys.argv[2:]:
    found = ours(log)
    has_gyro = "gx_rads" in found
    with CwaData(log, include_gyro=has_gyro, include_temperature=True) as theirs:
        values = theirs.get_sample_values().astype(float)
    names = ["ax_mps2", "ay_mps2", "az_mps2"] + ["gx_rads", "gy_rads", "gz_rads"] * has_gyro + ["temp_c"]
    scales = [G] * 3 + [DEGREE] * 3 * has_gyro + [1.0]
    for column, (name, scale) in enumerate(zip(names, scales), start=1):
        expected, got = values[:, column] * scale, found[name]
        assert len(expected) == len(got), f"{log}: {len(got)} rows, not {len(expected)}"
        is_known = ~np.isnan(got)
        far = np.abs(expected - got)[is_known].max()
        assert is_known.mean() > 0.9 and far <= 1e-5 * np.abs(expected).max(), f"{log}: {name} is off by {far}"
    apart = (found["t_s"] - found["t_s"][-1]) - (values[:, 0] - values[-1, 0])
    inner = slice(200, -200)
    assert np.abs(apart[inner] - np.median(apart[inner])).max() < STAMP_S, f"{log}: stamps differ by {apart}"
    print(f"{Path(log).name}: {len(values)} rows, {', '.join(names)}: the same")
