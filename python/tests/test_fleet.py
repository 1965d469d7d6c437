"""Rows of units and their population: those of the program, in whatever order they come."""

import json

import fos_imu as fos
import numpy as np
import pytest
from fos_imu.errors import FleetError

UNITS = 6


@pytest.fixture(scope="module")
def line(tmp_path_factory):
    """A folder of units, one of which is damaged."""
    folder = tmp_path_factory.mktemp("line3")
    lines = ["unit,part,lot,log"]
    for seed in range(1, UNITS + 1):
        fos.simulate(minutes=3, seed=seed, motion=False).write(folder / f"u{seed}.parquet")
        lines.append(f"u{seed},bmi270,lot{seed % 2},u{seed}.parquet")
    whole = (folder / "u1.parquet").read_bytes()
    (folder / "cut.parquet").write_bytes(whole[: len(whole) // 2])
    (folder / "units.csv").write_text("\n".join([*lines, "cut,bmi270,,cut.parquet"]) + "\n")
    return folder


@pytest.fixture(scope="module")
def rows(line):
    units = [fos.unit_row(line / f"u{n}.parquet", part="bmi270", lot=f"lot{n % 2}") for n in range(1, UNITS + 1)]
    return [*units, fos.unit_row(line / "cut.parquet", part="bmi270")]


def test_a_population_is_the_bytes_of_the_program_in_any_order(line, rows, program, tmp_path):
    program("fleet", line, "-o", "population.json", folder=tmp_path)
    expected = (tmp_path / "population.json").read_bytes()
    texts = [row.to_json() for row in rows]
    for some in (rows, rows[::-1], texts, [fos.UnitRow.from_json(text) for text in texts[2:] + texts[:2]]):
        fos.population(some).save(tmp_path / "mine.json")
        assert (tmp_path / "mine.json").read_bytes() == expected
    fos.population(rows[1:]).save(tmp_path / "mine.json")
    assert (tmp_path / "mine.json").read_bytes() != expected


def test_a_row_has_bias_and_slope_of_every_axis(line, rows):
    row = rows[0]
    assert (row.unit, row.part, row.lot, row.failed) == ("u1", "bmi270", "lot1", ())
    gx = next(axis for axis in row.axes if axis.column == "gx_rads")
    assert gx.coefficients.names == ("bias", "temp_c")
    assert np.shape(gx.coefficients.covariance) == (2, 2)
    assert row.log is not None
    assert row.log.seconds == pytest.approx(180, rel=0.02)
    # a recording is taken as it was read
    assert fos.unit_row(fos.read(line / "u1.parquet"), part="bmi270", lot="lot1") == row
    assert fos.UnitRow.from_json(row.to_json()) == row
    assert json.loads(row.to_json())["unit"] == "u1"


def test_what_cannot_be_read_is_a_row_that_says_so(line, rows):
    assert rows[-1].axes == ()
    assert "cut.parquet" in rows[-1].failed[0]
    assert "no.csv" in fos.unit_row(line / "no.csv").failed[0]
    assert "largest_bytes" in fos.unit_row(line / "u1.parquet", largest_bytes=10).failed[0]
    named = fos.unit_row(line / "cut.parquet", shown_as=["lake/7.parquet"]).failed[0]
    assert "lake/7.parquet" in named
    assert str(line) not in named
    fleet = fos.population(rows)
    assert fleet.units == UNITS + 1
    assert [one.unit for one in fleet.failed] == ["cut"]


def test_several_logs_of_a_unit_are_one_row(line, rows, program, tmp_path):
    # the file of another unit stands for a later log of u1
    pair = [line / "u1.parquet", line / "u2.parquet"]
    both = fos.unit_row(pair, part="bmi270", lot="lot1")
    assert both.unit == "u1"
    assert both.log.rows == rows[0].log.rows + rows[1].log.rows
    assert both.sha256 not in (rows[0].sha256, rows[1].sha256)
    recordings = [fos.read(path) for path in pair]
    assert fos.unit_row(recordings, part="bmi270", lot="lot1") == both
    # what cannot be read is left out, and said
    some = fos.unit_row([line / "u1.parquet", line / "cut.parquet"], part="bmi270", lot="lot1")
    assert some.axes == rows[0].axes
    assert "cut.parquet" in some.failed[0]
    for wrong in ([], [pair[0], recordings[1]]):
        with pytest.raises(FleetError):
            fos.unit_row(wrong)
    # as the program has it from a table with a line for each log
    logs = tmp_path / "line"
    logs.mkdir()
    for n in range(1, UNITS + 1):
        (logs / f"u{n}.parquet").symlink_to(line / f"u{n}.parquet")
    lines = [f"u{n},bmi270,lot{n % 2},u{n}.parquet" for n in range(1, UNITS + 1)]
    (logs / "units.csv").write_text("\n".join(["unit,part,lot,log", *lines, "u1,bmi270,lot1,u2.parquet"]) + "\n")
    program("fleet", logs, "-o", "population.json", folder=tmp_path)
    fos.population([both, *rows[1:-1]]).save(tmp_path / "mine.json")
    assert (tmp_path / "mine.json").read_bytes() == (tmp_path / "population.json").read_bytes()


def test_rows_beside_a_population_are_what_the_program_reports_from(rows, program, tmp_path):
    fleet = fos.population(rows)
    fleet.save(tmp_path / "mine.json", rows=rows[::-1])
    program("fleet", "report", "mine.json", "-o", "fleet.html", folder=tmp_path)
    assert "cut.parquet" in (tmp_path / "fleet.html").read_text()
    before = (tmp_path / "mine.json").read_bytes()
    with pytest.raises(FleetError, match="rows of 7 devices"):
        fos.population(rows).save(tmp_path / "mine.json", rows=rows[1:])
    assert (tmp_path / "mine.json").read_bytes() == before


def test_rows_that_are_no_fleet_are_refused(line, rows):
    other = fos.unit_row(line / "u2.parquet", unit="other", part="bmi270", regressors=["temp_c * temp_c"])
    for some, says in (
        ([], "the fleet is empty"),
        ([*rows, rows[0]], '"u1" of "bmi270" is there twice'),
        ([*rows, other], r'asked different things: regressors \["temp_c"\] and'),
        (["{}"], "is not the row of a device"),
    ):
        with pytest.raises(FleetError, match=says) as error:
            fos.population(some)
        assert error.value.remedy
    with pytest.raises(FleetError, match="is not the row of a device"):
        fos.UnitRow.from_json("[]")
    with pytest.raises(FleetError, match="is no regressor"):
        fos.unit_row(line / "u1.parquet", regressors=["temp_c:lowpas(1)"])
    with pytest.raises(FleetError, match='"temp_c" is given twice'):
        fos.unit_row(line / "u1.parquet", regressors=["temp_c", "temp_c"])


def test_they_show_themselves_and_are_tables(rows):
    fleet = fos.population(rows)
    for result in (fleet, rows[0], rows[-1]):
        page = result._repr_html_()
        assert page.count("<div") == page.count("</div>")
    pandas = pytest.importorskip("pandas")
    assert set(fleet.to_pandas()["coefficient"]) == {"bias", "temp_c"}
    assert len(rows[0].to_pandas()) == sum(len(axis.coefficients.names) for axis in rows[0].axes)
    frame = pandas.DataFrame({"row": [row.to_json() for row in rows]})
    assert fos.population(frame) == fleet
