import fos_imu as fos
import numpy as np
import pytest
from fos_imu.errors import FileError, RecordingError

N = 400
TIME = np.arange(N) / 200.0
RATE = 0.01 + 1e-4 * np.sin(np.arange(N))


def test_arrays_become_channels_with_units():
    log = fos.Recording.from_arrays({"t_s": TIME, "gx_rads": RATE, "temp_c": np.full(N, 25.0)})
    assert (log.n_rows, round(log.rate_hz), log.axes) == (N, 200, ("gx_rads",))
    assert [(one.name, one.unit) for one in log.channels] == [("gx_rads", "rad/s"), ("temp_c", "°C")]
    assert np.array_equal(log["gx_rads"], RATE)
    assert np.array_equal(log.time_s, TIME)
    assert log["gx_rads"] is log["gx_rads"]
    with pytest.raises(ValueError, match="read-only"):
        log["gx_rads"][0] = 1.0
    with pytest.raises(KeyError):
        log["gy_rads"]


def test_units_and_maps_convert():
    degrees = np.degrees(RATE)
    by_units = fos.Recording.from_arrays({"t_s": TIME * 1e3, "gx_rads": degrees}, units={"t_s": "ms", "gx_rads": "dps"})
    by_map = fos.Recording.from_arrays(
        {"time": TIME * 1e3, "gyro:x": degrees}, map=["t_s=time:ms", 'gx_rads="gyro:x":dps']
    )
    for log in (by_units, by_map):
        np.testing.assert_allclose(log["gx_rads"], RATE, rtol=1e-15)
        np.testing.assert_allclose(log.time_s, TIME, rtol=1e-15)


@pytest.mark.parametrize("kind", ["f8", "f4", "i8", "i4", "i2", "u8", "u4", "u2", "u1", "f2", "i1", ">f8"])
def test_every_type_is_the_same_numbers(kind):
    counts = np.arange(N) % 100
    log = fos.Recording.from_arrays({"t_s": TIME, "gx_rads": counts.astype(kind)})
    assert np.array_equal(log["gx_rads"], counts)


def test_strides_and_orders_are_the_same_numbers():
    both = np.stack([TIME, RATE], axis=1)
    log = fos.Recording.from_arrays({"t_s": both[:, 0], "gx_rads": np.asfortranarray(both)[:, 1]})
    assert np.array_equal(log["gx_rads"], RATE)
    backwards = fos.Recording.from_arrays({"t_s": TIME, "gx_rads": RATE[::-1]})
    assert np.array_equal(backwards["gx_rads"], RATE[::-1])
    still = fos.Recording.from_arrays({"t_s": TIME, "gx_rads": RATE, "still": TIME > 1})
    assert still.still is not None
    assert np.array_equal(still.still, TIME > 1)


def test_tables_of_others_are_taken_as_they_are():
    columns = {"t_s": TIME, "gx_rads": RATE, "temp_c": np.where(TIME > 1, 25.0, np.nan)}
    expected = fos.Recording.from_arrays(columns)
    pandas, polars, pyarrow = (pytest.importorskip(name) for name in ("pandas", "polars", "pyarrow"))

    class Stream:
        def __init__(self, table):
            self.table = table

        def __arrow_c_stream__(self, requested_schema=None):
            return self.table.__arrow_c_stream__(requested_schema)

    structured = np.rec.fromarrays(list(columns.values()), names=list(columns))
    nullable = pandas.DataFrame(columns).astype({"temp_c": "Float64"})
    for table in (
        pandas.DataFrame(columns),
        nullable,
        polars.DataFrame(columns),
        pyarrow.table(columns),
        Stream(pyarrow.table(columns)),
        structured,
    ):
        log = fos.Recording.from_arrays(table)
        assert log == expected, type(table)
        np.testing.assert_array_equal(log["temp_c"], expected["temp_c"])


def test_stamps_of_a_calendar_are_seconds():
    pandas = pytest.importorskip("pandas")
    stamps = pandas.date_range("2026-03-01", periods=N, freq="5ms")
    log = fos.Recording.from_arrays(pandas.DataFrame({"t_s": stamps, "gx_rads": RATE}))
    assert log.rate_hz == pytest.approx(200, rel=1e-9)
    np.testing.assert_allclose(log.time_s - log.time_s[0], TIME, atol=3e-7)


def test_the_same_values_are_the_same_source_and_others_are_not():
    def source(shift):
        return fos.Recording.from_arrays({"t_s": TIME, "gx_rads": RATE + shift}).sources[0]

    assert source(0) == source(0)
    assert source(0) != source(1e-9)


def test_what_is_written_reads_back(tmp_path, short):
    for ending in ("parquet", "csv", "csv.gz"):
        path = tmp_path / f"log.{ending}"
        short.write(path)
        again = fos.read(path)
        assert (again.n_rows, again.segments) == (short.n_rows, short.segments)
        assert np.array_equal(again["gx_rads"], short["gx_rads"])
        assert np.array_equal(again.still, short.still)


def test_gaps_are_segments():
    time = np.delete(TIME, slice(100, 110))
    log = fos.Recording.from_arrays({"t_s": time, "gx_rads": np.delete(RATE, slice(100, 110))})
    assert log.segments == (slice(0, 100), slice(100, 390))
    assert log.samples_missing == 10


def test_errors_say_where_and_what_to_do(tmp_path):
    with pytest.raises(FileError) as missing:
        fos.read(tmp_path / "no.csv")
    assert isinstance(missing.value, OSError)
    assert missing.value.file == str(tmp_path / "no.csv")
    assert missing.value.remedy == "is the path right?"
    path = tmp_path / "bad.csv"
    path.write_text("t_s,gx_rads\n" + "".join(f"{n * 0.005},{'x' if n == 7 else 0.1}\n" for n in range(100)))
    with pytest.raises(RecordingError) as bad:
        fos.read(path, strict=True)
    assert (bad.value.file, bad.value.line, bad.value.column) == (str(path), 9, "gx_rads")
    assert "correct or remove that row" in bad.value.remedy
    assert "help: " in str(bad.value)
    with pytest.raises(RecordingError, match="did you mean"):
        fos.fit(fos.Recording.from_arrays({"t_s": TIME, "gx_rads": RATE}), axes="gx_rds")
    for arrays, says in (
        ({"gx_rads": RATE}, "no column t_s"),
        ({"t_s": TIME, "gx_rads": RATE[:-1]}, "has 399 values"),
        ({"t_s": TIME, "gx_rads": np.zeros((N, 2))}, "2 dimensions"),
        ({"t_s": TIME, "gx_rads": np.array(["a"] * N)}, "no column of numbers"),
        (7, "no table"),
    ):
        with pytest.raises(RecordingError, match=says):
            fos.Recording.from_arrays(arrays)


def test_a_simulated_log_is_the_same_in_the_program(tmp_path, program, short):
    program("simulate", "log.parquet", "--minutes", "1.5", "--seed", "5", folder=tmp_path)
    log = fos.read(tmp_path / "log.parquet")
    for name in short:
        assert np.array_equal(log[name], short[name]), name


def test_it_shows_itself(short):
    page = short._repr_html_()
    assert "gx_rads" in page
    assert page.count("<svg") == len(short)
    assert "rows" in repr(short)
    assert len(fos.formats()) > 10


def test_it_is_a_table_of_pandas(short):
    pytest.importorskip("pandas")
    frame = short.to_pandas()
    assert list(frame.columns) == list(short)
    assert np.array_equal(frame.index, short.time_s)


@pytest.mark.parametrize("kind", ["numpy", "pandas", "polars", "pyarrow"])
@pytest.mark.parametrize("values", [[1.5, 99.0, 2.5, 3.0], [1, 99, 2, 3], [True, True, False, True]])
def test_cells_without_a_value_are_empty_in_every_table(kind, values):
    """Masked cells of 99 were taken for measured ones."""
    missing = [False, True, False, False]
    if kind == "numpy":
        column = np.ma.masked_array(values, missing)
    else:
        package = pytest.importorskip(kind)
        with_none = [None if gone else value for value, gone in zip(values, missing, strict=True)]
        names = {float: "Float64", int: "Int64", bool: "boolean"}
        column = {
            "pandas": lambda: package.array(with_none, names[type(values[0])]),
            "polars": lambda: package.Series(with_none),
            "pyarrow": lambda: package.array(with_none),
        }[kind]()
    log = fos.Recording.from_arrays({"t_s": [0.0, 0.01, 0.02, 0.03], "temp_c": column})
    expected = np.where(missing, np.nan, np.array(values, float))
    np.testing.assert_array_equal(log["temp_c"], expected)
    assert not np.array_equal(np.array(values, float), expected, equal_nan=True), "without the mask it is noticed"
