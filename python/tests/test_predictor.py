import fos_imu as fos
import numpy as np
import pytest
from fos_imu import _engine
from fos_imu.errors import ImageError, PredictorError


@pytest.fixture(scope="module")
def unit(short):
    study = fos.fit(short, physical=["temp_c"], max_lag=4)
    return study.export_image("unit 1")


def crc_64(data: bytes) -> int:
    """CRC-64/XZ, as the firmware of the tests sends it."""
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0xC96C5795D7870F42 if byte & 1 else 0)
        table.append(byte)
    crc = 0xFFFFFFFFFFFFFFFF
    for byte in data:
        crc = table[(crc ^ byte) & 0xFF] ^ crc >> 8
    return crc ^ 0xFFFFFFFFFFFFFFFF


def test_a_log_runs_to_the_bits_of_the_device(short, unit, tmp_path, program):
    """The digests of `replay` are over the bits of fos-core, which are the same on a device."""
    short.write(tmp_path / "log.parquet")
    (tmp_path / "unit.fosm").write_bytes(unit)
    told = program("replay", "unit.fosm", "log.parquet", "-o", "corrected.parquet", "--json", folder=tmp_path)
    found = fos.Predictor(unit).run(short)
    corrected = fos.read(tmp_path / "corrected.parquet")
    for index, axis in enumerate(found.axes):
        assert np.array_equal(found.corrected[:, index].astype(np.float64), corrected[axis]), axis
    assert told["tracked"] == int(found.still.sum())
    n_innovations = [axis["innovations"] for axis in told["axes"]]
    assert n_innovations == np.isfinite(found.innovation).sum(axis=0).tolist()
    innovation = np.where(np.isnan(found.innovation), np.uint32(0x7FC00000).view(np.float32), found.innovation)
    rows = np.empty(found.corrected.shape, dtype=[("innovation", "<f4"), ("corrected", "<f4"), ("validity", "<u2")])
    rows["innovation"], rows["corrected"], rows["validity"] = innovation, found.corrected, found.validity
    assert f"{crc_64(rows.tobytes()):016x}" == told["corrections_digest"]
    assert f"{crc_64(rows['innovation'].tobytes()):016x}" == told["innovations_digest"]


def test_in_pieces_it_comes_to_the_same_bits(short, unit):
    predictor = fos.Predictor(unit)
    measured = np.column_stack([short[axis] for axis in predictor.axes])
    quantities = np.column_stack([short[name] for name in predictor.quantities])
    still = short.at_rest()
    whole = predictor.step(measured, quantities, still=still)
    predictor.reset()
    pieces = [
        predictor.step(measured[rows], quantities[rows], still=still[rows])
        for rows in (slice(0, 1), slice(1, 777), slice(777, None))
    ]
    for name in ("predicted", "innovation", "corrected", "validity"):
        assert np.concatenate([getattr(piece, name) for piece in pieces]).tobytes() == getattr(whole, name).tobytes()
    assert whole.predicted.dtype == whole.corrected.dtype == np.float32
    np.testing.assert_array_equal(whole.corrected, measured.astype(np.float32) - whole.predicted)


def test_it_goes_on_by_itself_and_over_gaps(short, unit):
    predictor = fos.Predictor(unit)
    n_axes, n_quantities = len(predictor.axes), len(predictor.quantities)
    measured = np.column_stack([short[axis][:500] for axis in predictor.axes])
    predictor.step(measured, np.full((500, n_quantities), 25.0))
    ahead = predictor.forecast(40, np.full((40, n_quantities), 25.0))
    assert ahead.predicted.shape == (40, n_axes)
    assert np.isnan(ahead.innovation).all()
    assert (ahead.validity & fos.Validity.OWN_HISTORY).all()
    predictor.skip(10_000)
    after = predictor.step(measured[:1], np.full((1, n_quantities), 25.0))
    assert (after.validity & fos.Validity.WARMING_UP).all()


def test_the_bits_of_validity_are_named_as_in_the_engine():
    said = [one.name.lower().replace("_", " ") for one in fos.Validity]
    assert said == _engine.validity_names()


def test_an_image_says_what_it_is(unit):
    predictor = fos.Predictor(unit)
    assert predictor.sensor == "unit 1"
    assert set(predictor.axes) == {"ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"}
    assert predictor.quantities == ("temp_c",)
    assert predictor.effects == ("temp_linear",)
    assert "temp_linear" in predictor.description
    assert "sha256" in "".join(predictor.provenance)
    assert "unit 1" in predictor._repr_html_()
    assert predictor.period_s == pytest.approx(1 / 200, rel=0.02)


def test_what_is_no_image_is_refused(unit):
    damaged = bytearray(unit)
    damaged[100] ^= 1
    for image, says in ((b"", "truncated"), (b"x" * 100, "not a model image"), (bytes(damaged), "damaged")):
        with pytest.raises(ImageError, match=says):
            fos.Predictor(image)
    predictor = fos.Predictor(unit)
    with pytest.raises(PredictorError, match="measured has 5 columns where the model has 6"):
        predictor.step(np.zeros((3, 5)), np.zeros((3, 1)))
    with pytest.raises(PredictorError, match="differ in their rows"):
        predictor.step(np.zeros((3, 6)), np.zeros((2, 1)))


@pytest.mark.parametrize("steps", [-1, 10_000_001, 10**12, 10**30])
def test_a_forecast_has_a_bounded_number_of_steps(unit, steps):
    with pytest.raises(PredictorError, match="steps: a forecast has"):
        fos.Predictor(unit).forecast(steps)
    with pytest.raises(PredictorError, match="cannot be skipped"):
        fos.Predictor(unit).skip(steps if steps < 0 else 1 << 32)


def test_masked_samples_are_samples_without_a_value(unit):
    predictor = fos.Predictor(unit)
    measured = np.zeros((50, len(predictor.axes)))
    quantities = np.full((50, len(predictor.quantities)), 25.0)
    mask = np.zeros(measured.shape, bool)
    mask[20:30] = True
    with_nan = predictor.step(np.where(mask, np.nan, measured), quantities)
    predictor.reset()
    masked = predictor.step(np.ma.masked_array(np.where(mask, 99.0, measured), mask), quantities)
    assert masked.predicted.tobytes() == with_nan.predicted.tobytes()
    assert np.array_equal(masked.validity, with_nan.validity)
