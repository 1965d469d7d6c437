"""Models of the error of accelerometers and gyros, fitted from logs; missing effects identified and added; the image that
a device runs.

From a log to the missing effect, with its evidence::

    import fos_imu as fos

    reference, log = fos.read("reference.parquet"), fos.read("log.parquet")
    study = fos.fit(reference, axes="gx")
    diagnosis = study.diagnose(log)
    if diagnosis.findings:
        study.add(diagnosis.findings[0], log)
    image = study.export_image()
    corrected = fos.Predictor(image).run(log).corrected

In a notebook every result shows itself; `help()` of any name says shapes and units. All values are in SI units.
"""

from __future__ import annotations

from ._engine import __version__
from .calibration import Calibration, TurntableCalibration, calibrate, calibrate_on_turntable
from .comparison import AxisComparison, Comparison, ModelErrors, RmsInterval, UnaidedError
from .diagnosis import Diagnosis, Effect, Finding, diagnose, effects
from .errors import FosError, FosWarning
from .figure import Figure
from .fleet import Fleet, UnitRow, population, unit_row
from .noise import AxisNoise, Noise, NoiseFiles, noise, noise_files
from .page import page, write_page
from .predictor import Corrections, Predictor, Validity
from .recording import Recording, formats, read
from .regressor import FosRegressor
from .simulation import Case, Plant, simulate, simulate_case
from .study import Refinement, Study, fit

__all__ = [
    "AxisComparison",
    "AxisNoise",
    "Calibration",
    "Case",
    "Comparison",
    "Corrections",
    "Diagnosis",
    "Effect",
    "Figure",
    "Finding",
    "Fleet",
    "FosError",
    "FosRegressor",
    "FosWarning",
    "ModelErrors",
    "Noise",
    "NoiseFiles",
    "Plant",
    "Predictor",
    "Recording",
    "Refinement",
    "RmsInterval",
    "Study",
    "TurntableCalibration",
    "UnaidedError",
    "UnitRow",
    "Validity",
    "__version__",
    "calibrate",
    "calibrate_on_turntable",
    "diagnose",
    "effects",
    "fit",
    "formats",
    "noise",
    "noise_files",
    "page",
    "population",
    "read",
    "simulate",
    "simulate_case",
    "unit_row",
    "write_page",
]
