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
    unaided: tuple[fos.UnaidedError, ...] = errors.unaided
    heading: fos.RmsInterval | None = unaided[0].heading_rad
    image: bytes = study.export_image()
    corrections: fos.Corrections = fos.Predictor(image).run(log)
    corrected: npt.NDArray[np.float32] = corrections.corrected
    assert (type(rate), type(image), corrected.dtype) == (float, bytes, np.float32)
    assert slow is None or slow > 0
    assert [one.window_s for one in unaided] == [1, 10, 60, 600]
    assert heading is not None
    assert 0 < heading.low < heading.rms < heading.high
    assert (unaided[3].windows, unaided[3].heading_rad) == (0, None)
    assert columns["gx_rads"].dtype == np.float64


def test_rows_of_units_have_the_types_that_are_said() -> None:
    row: fos.UnitRow = fos.unit_row(fos.simulate(minutes=3.0, seed=4, motion=False), unit="u4")
    text: str = row.to_json()
    fleet: fos.Fleet = fos.population([text])
    units: int = fleet.units
    assert (units, row.unit) == (1, "u4")
