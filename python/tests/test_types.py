"""How the package looks to a type checker: `pyright` reads this file in its strict mode."""

from collections.abc import Mapping

import fos_imu as fos
import numpy as np
import numpy.typing as npt


def test_what_is_handed_over_has_the_types_that_are_said() -> None:
    log: fos.Recording = fos.simulate(minutes=1.0, seed=4)
    columns: Mapping[str, npt.NDArray[np.float64]] = log
    rate: float = log.rate_hz
    study: fos.Study = fos.fit(log, axes=["gx"], max_lag=3)
    comparison: fos.Comparison = study.compare()
    errors: fos.ModelErrors = comparison["gx"].model
    slow: float | None = errors.slow_error_coast
    image: bytes = study.export_image()
    corrections: fos.Corrections = fos.Predictor(image).run(log)
    corrected: npt.NDArray[np.float32] = corrections.corrected
    assert (type(rate), type(image), corrected.dtype) == (float, bytes, np.float32)
    assert slow is None or slow > 0
    assert columns["gx_rads"].dtype == np.float64


def test_rows_of_units_have_the_types_that_are_said() -> None:
    row: fos.UnitRow = fos.unit_row(fos.simulate(minutes=3.0, seed=4, motion=False), unit="u4")
    text: str = row.to_json()
    fleet: fos.Fleet = fos.population([text])
    units: int = fleet.units
    assert (units, row.unit) == (1, "u4")
