import fos_imu as fos
import numpy as np
import pytest
from fos_imu.errors import NoiseError


def test_planted_white_noise_is_found():
    random = np.random.default_rng(3)
    n, rate = 120_000, 200.0
    log = fos.Recording.from_arrays({"t_s": np.arange(n) / rate, "gx_rads": random.normal(0, 1e-3, n)})
    found = fos.noise(log, axes="gx")["gx"]
    truth = 1e-3 / np.sqrt(rate)
    assert found.white.low < truth < found.white.high
    assert found.white.value == pytest.approx(truth, rel=0.05)
    assert found.walk.value is None
    assert found.walk_needs_s > 600
    at_1_s = min(found.allan, key=lambda point: abs(point.tau_s - 1))
    assert at_1_s.low < truth / np.sqrt(at_1_s.tau_s) < at_1_s.high
    assert found.white.unit == "rad/s/sqrt(Hz)"
    page = found._repr_html_()
    assert "<svg" in page
    assert "at most" in page


def test_the_program_says_the_same(short, tmp_path, program):
    short.write(tmp_path / "log.parquet")
    told = program("noise", "log.parquet", "--imu-yaml", "imu.yaml", "--json", folder=tmp_path)
    log = fos.read(tmp_path / "log.parquet")
    found = fos.noise(log)
    assert [axis["white"]["value"] for axis in told["axes"]] == [axis.white.value for axis in found]
    assert fos.noise_files(log).imu_yaml == (tmp_path / "imu.yaml").read_text()


def test_levels_are_a_table_of_pandas(short):
    pytest.importorskip("pandas")
    found = fos.noise(short, axes=["gx", "az"])
    assert list(found.to_pandas()["level"]) == ["N", "B", "K"] * 2
    assert len(found["gx"].to_pandas()) == len(found["gx"].allan)


def test_what_tells_no_noise_is_refused():
    few = {"t_s": np.arange(400) / 200, "gx_rads": np.random.default_rng(1).normal(size=400)}
    with pytest.raises(NoiseError, match=r"2\.0 s at rest in stretches .* at least 20 s") as short:
        fos.noise(fos.Recording.from_arrays(few))
    assert short.value.column == "gx_rads"
    few = {"t_s": np.arange(40_000) / 200, "gx_rads": np.random.default_rng(1).normal(size=40_000)}
    with pytest.raises(NoiseError, match="missing"):
        fos.noise_files(fos.Recording.from_arrays(few))
