import fos_imu as fos
import numpy as np
import pytest
from fos_imu.errors import CalibrateError

G = 9.80665


def turned(orientations=14, seed=5, noise=0.01):
    """A device with a bias of 0.1 m/s² and 2 % too much sensitivity on y, that lies 3 s in each orientation; gyro 1 % off."""
    random = np.random.default_rng(seed)
    rate, still, turning = 100, 300, 100
    up = random.normal(size=(orientations, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    accelerometer, gyro = [], []
    for one, following in zip(up, [*up[1:], up[-1]], strict=True):
        axis = np.cross(one, following)
        sine = np.linalg.norm(axis)
        axis = axis / sine if sine > 0 else axis
        angle = np.arctan2(sine, one @ following)
        phase = (np.arange(turning) + 0.5) / turning
        share = (1 - np.cos(np.pi * phase)) / 2
        side = np.cross(axis, one)
        path = np.cos(angle * share)[:, None] * one + np.sin(angle * share)[:, None] * side
        accelerometer += [np.tile(one, (still, 1)), path]
        speed = angle * np.pi / 2 * np.sin(np.pi * phase) * rate / turning
        # gravity turns by +angle about the axis as seen from the device, which therefore turns the other way
        gyro += [np.zeros((still, 3)), -speed[:, None] * axis]
    true = np.concatenate(accelerometer) * G
    a = true * [1.0, 1.02, 1.0] + [0.1, 0.0, 0.0] + random.normal(0, noise, true.shape)
    w = np.concatenate(gyro) * 1.01 + [0.0, 0.01, 0.0] + random.normal(0, 1e-3, true.shape)
    columns = {"t_s": np.arange(len(a)) / rate}
    columns |= {f"a{axis}_mps2": a[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"g{axis}_rads": w[:, i] for i, axis in enumerate("xyz")}
    return fos.Recording.from_arrays(columns), true


def test_planted_calibration_is_found_and_undone():
    log, true = turned()
    found = fos.calibrate(log, accuracy_mg=5)
    for name, truth in {
        "accelerometer.bias.x": 0.1,
        "accelerometer.bias.y": 0.0,
        "accelerometer.sensitivity.y": 1.02,
        "gyro.bias.y": 0.01,
        "gyro.sensitivity.z": 1.01,
    }.items():
        one = found[name]
        # five intervals of 95 % at once: twice as wide, four standard deviations, all hold
        assert abs(one.value - truth) < 2 * one.half_width, one
    assert found.rms_mps2[0] < 0.01 < found.rms_mps2[1]
    assert found.is_accurate
    corrected = found.accelerometer(np.stack([log[f"a{axis}_mps2"] for axis in "xyz"], axis=1))
    assert np.abs(corrected.mean(axis=0) - true.mean(axis=0)).max() < 0.005
    assert "CAL_ACC0_XOFF" in found.files["px4"]
    with pytest.raises(CalibrateError, match=r"shape \(3,\)"):
        found.accelerometer(np.zeros(3))


def test_gravity_of_the_place_scales_the_sensitivity():
    log, _ = turned()
    assumed, placed = fos.calibrate(log), fos.calibrate(log, latitude_deg=0.0)
    ratio = assumed["accelerometer.sensitivity.x"].value / placed["accelerometer.sensitivity.x"].value
    assert ratio == pytest.approx(9.7803253 / G, rel=1e-5)


def test_missing_orientations_are_named():
    log, _ = turned(orientations=8)
    with pytest.raises(CalibrateError, match="no redundancy") as refused:
        fos.calibrate(log)
    assert "record" in refused.value.remedy


def test_result_shows_itself(tmp_path):
    log, _ = turned()
    found = fos.calibrate(log)
    page = found._repr_html_()
    assert "<svg" in page
    assert "accelerometer x bias" in page
    fos.write_page(tmp_path / "calibration.html", found)


def test_the_program_says_the_same(tmp_path, program):
    log, _ = turned()
    log.write(tmp_path / "log.parquet")
    told = program("calibrate-imu", "log.parquet", "--px4", "px4.params", "--json", folder=tmp_path)
    found = fos.calibrate(fos.read(tmp_path / "log.parquet"))
    theirs = told["result"]["hand"]["accelerometer"]["parameters"]
    assert [one["value"] for one in theirs] == [found[one["id"]].value for one in theirs]
    assert found.files["px4"] == (tmp_path / "px4.params").read_text()


def test_turntable():
    random = np.random.default_rng(2)
    rate, plateau, pause = 100, 600, 200
    axes = np.concatenate([np.eye(3), -np.eye(3), random.normal(size=(12, 3))])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    stated = np.deg2rad(200.0)
    rates = np.concatenate(
        [np.concatenate([np.zeros((pause, 3)), np.tile(stated * axis, (plateau, 1))]) for axis in axes]
    )
    measured = rates * [1.0136, 0.9887, 0.9988] + [0.01, 0.0, 0.0] + random.normal(0, 1e-3, rates.shape)
    columns = {"t_s": np.arange(len(measured)) / rate} | {
        f"g{axis}_rads": measured[:, i] for i, axis in enumerate("xyz")
    }
    found = fos.calibrate_on_turntable(fos.Recording.from_arrays(columns), rates_rads=[stated])
    assert found["gyro.sensitivity.x"].value == pytest.approx(1.0136, abs=1e-3)
    assert found["gyro.sensitivity.y"].value == pytest.approx(0.9887, abs=1e-3)
    assert found.rms[0] < 1e-3 < found.rms[1]
    assert "plateaus" in found._repr_html_()
