//! A calibration as other programs read it. Each applies its own formula; a test of each file applies that formula and compares
//! the result with [`TriadModel::corrected`](crate::TriadModel::corrected).
//!
//! | module | file | formula of its reader |
//! |---|---|---|
//! | `px4` | parameters `CAL_ACCn_*`, `CAL_GYROn_*` | (raw − offset) ∘ scale; gyro: raw − offset |
//! | `ardupilot` | parameters `INS_ACC*`, `INS_GYR*` | the same |
//! | `kalibr` | intrinsics of an IMU, YAML | raw = M·a + b; raw = M·C·ω + A·C·a + b |
//! | `imu_tk` | misalignment, scale, bias | T·K·(raw − b) |

mod ardupilot;
mod autopilot;
mod imu_tk;
mod kalibr;
mod px4;

pub use ardupilot::ArduPilot;
pub use autopilot::{Autopilot, NotForAutopilot};
pub use imu_tk::{ImuTk, ImuTkTriad};
pub use kalibr::{Kalibr, KalibrGyro};
pub use px4::Px4;

/// The name of a log inside a comment: printable ASCII on one line.
fn in_comment(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
