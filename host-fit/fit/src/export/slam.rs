//! Noise of a log for ORB-SLAM3 and for VINS-Mono and VINS-Fusion: the lines of their settings that concern it.

use super::comment::in_ascii;
use super::noise_model::{NoiseModel, yaml_line};
use super::real::real;

/// Returns lines for the settings of ORB-SLAM3, with continuous densities. It multiplies the noise by √`IMU.Frequency`
/// and divides the walk by it (src/Tracking.cc), and rejects a number without a point (src/Settings.cc, `isReal`).
pub fn orb_slam3(noise: &NoiseModel) -> String {
    let NoiseModel { log, rate_hz, accel, gyro, .. } = noise;
    let levels = [
        ("IMU.NoiseGyro", &gyro.white),
        ("IMU.NoiseAcc", &accel.white),
        ("IMU.GyroWalk", &gyro.walk),
        ("IMU.AccWalk", &accel.walk),
    ];
    let lines = levels.map(|(key, level)| level.line(key)).concat();
    format!(
        "%YAML:1.0\n\n# Noise of {}, by fos: of three axes the one that has the most.\n\
         # Put these lines in the place of those of the same names in the settings. They are continuous densities:\n\
         # ORB-SLAM3 makes of them what it needs per sample, with IMU.Frequency. Versions before 1.0 want a whole\n\
         # number there.\n\
         {lines}{}",
        in_ascii(log),
        yaml_line("IMU.Frequency", *rate_hz, "Hz, as measured")
    )
}

/// Returns lines for the configuration of VINS. The unit of its levels is disputed; its code multiplies them by the
/// time step when it accumulates them (factor/integration_base.h, `V·noise·Vᵀ`, V ∝ dt), which is right for standard
/// deviations per sample, N·√rate and K·√rate. These are active; the densities are given in comments.
pub fn vins(noise: &NoiseModel) -> String {
    let NoiseModel { log, rate_hz, accel, gyro, .. } = noise;
    let levels =
        [("acc_n", &accel.white), ("gyr_n", &gyro.white), ("acc_w", &accel.walk), ("gyr_w", &gyro.walk)];
    let discrete = levels.map(|(key, level)| {
        let about = format!("{} times sqrt(rate)", real(level.value));
        yaml_line(key, level.value * rate_hz.sqrt(), &about)
    });
    let discrete = discrete.concat();
    let continuous = levels.map(|(key, level)| format!("# {}", level.line(key))).concat();
    format!(
        "%YAML:1.0\n\n# Noise of {}, by fos: of three axes the one that has the most.\n\
         # Put these lines in the place of those of the same names in the configuration.\n\
         # Active: standard deviations per sample at {} Hz (discrete), as the integration of VINS uses them: it\n\
         # multiplies them by the time step.\n{discrete}\
         # Not active: continuous densities, as Kalibr and others want them.\n{continuous}",
        in_ascii(log),
        real(*rate_hz)
    )
}
