//! The noise of a log for Kalibr (`imu.yaml`) and OpenVINS (`kalibr_imu_chain.yaml`), in one file that both read.
//!
//! Kalibr reads the keys at the top (kalibr_common/ConfigReader.py, `ImuParameters`), OpenVINS those in the block
//! `imu0` (ov_msckf/core/VioManagerOptions.h, through `cv::FileStorage`). Both read the continuous densities N and K
//! and convert them to values per sample with `update_rate`. PyYAML and OpenCV both accept the first line.

use super::comment::in_ascii;
use super::noise_model::{NoiseModel, yaml_line};

/// Returns the file, in ASCII.
pub fn imu_yaml(noise: &NoiseModel, rostopic: &str) -> String {
    let NoiseModel { log, rate_hz, accel, gyro, filter } = noise;
    let topic = quoted(rostopic);
    let keys = |indent: &str| {
        let levels = [
            ("accelerometer_noise_density", &accel.white),
            ("accelerometer_random_walk", &accel.walk),
            ("gyroscope_noise_density", &gyro.white),
            ("gyroscope_random_walk", &gyro.walk),
        ];
        let levels = levels.map(|(key, level)| indent.to_owned() + &level.line(key));
        let rate = yaml_line("update_rate", *rate_hz, "Hz, as measured");
        format!("{}{indent}rostopic: {topic}\n{indent}{rate}", levels.concat())
    };
    let identity = |size: usize| -> String {
        let row = |at: usize| {
            let cells: Vec<&str> = (0..size).map(|column| if column == at { "1.0" } else { "0.0" }).collect();
            format!("    - [ {} ]\n", cells.join(", "))
        };
        (0..size).map(row).collect()
    };
    let zero = "    - [ 0.0, 0.0, 0.0 ]\n".repeat(3);
    format!(
        "%YAML 1.0\n---\n\
         # Noise of {}, by fos: of three axes the one that has the most.\n\
         # Continuous densities, not to be multiplied by the root of the rate: N is the Allan deviation at 1 s of the\n\
         # white noise, K the random walk of the bias. A data sheet's one-sided density is sqrt(2) times N.\n\
         {filter}\n# Kalibr reads these\n{}\
         \n# OpenVINS reads this block; Kalibr estimates the extrinsic transformation and the scale factors\n\
         imu0:\n  T_i_b:\n{}{}  time_offset: 0.0\n  model: \"kalibr\"\n\
         \x20 Tw:\n{}  R_IMUtoGYRO:\n{}  Ta:\n{}  R_IMUtoACC:\n{}  Tg:\n{zero}",
        in_ascii(log),
        keys(""),
        identity(4),
        keys("  "),
        identity(3),
        identity(3),
        identity(3),
        identity(3),
    )
}

/// Formats a double-quoted YAML string, which is also valid JSON.
fn quoted(text: &str) -> String {
    let escaped: String = text.chars().flat_map(char::escape_default).collect();
    format!("\"{}\"", escaped.replace("\\'", "'"))
}
