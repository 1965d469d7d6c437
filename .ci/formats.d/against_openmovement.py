"""What fos reads of a log of Axivity is what openmovement, of the maker, reads of it.

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
# it interpolates the temperature between blocks, which is held here: a step of the thermometer apart
STEP_K = 75 / 256


def ours(log):
    """Columns of a log as fos reads it."""
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
    # it fills up the last block
    assert 0 <= len(values) - len(found["t_s"]) < 120, f"{log}: {len(found['t_s'])} rows, not {len(values)}"
    values = values[: len(found["t_s"])]
    names = ["ax_mps2", "ay_mps2", "az_mps2"] + ["gx_rads", "gy_rads", "gz_rads"] * has_gyro + ["temp_c"]
    scales = [G] * 3 + [DEGREE] * 3 * has_gyro + [1.0]
    for column, (name, scale) in enumerate(zip(names, scales), start=1):
        expected, got = values[:, column] * scale, found[name]
        allowed = STEP_K if name == "temp_c" else 1e-5 * np.abs(expected).max()
        is_known = ~np.isnan(got)
        far = np.abs(expected - got)[is_known].max()
        assert is_known.mean() > 0.9 and far <= allowed, f"{log}: {name} is off by {far}"
    print(f"{Path(log).name}: {len(values)} rows, {', '.join(names)}: the same")
