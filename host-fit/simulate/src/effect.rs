//! Effects that can be planted: those of the library, and some outside it.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::setup::Setup;

/// An effect, by its identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
#[expect(missing_docs, reason = "each says what it is in `name`; regressors.rs has its formula")]
pub enum Effect {
    TempLinear,
    TempPoly,
    ThermalLag,
    TempRate,
    ThermalHysteresis,
    WarmupExp,
    BiasRamp,
    BiasStep,
    SupplySensitivity,
    LoadHeating,
    MagSensitivity,
    GSensitivity,
    VibrationRectification,
    SfError,
    SfNonlinearity,
    SfAsymmetry,
    SfTemp,
    CrossAxis,
    LeverArm,
    SpectralLine,
    DriftingLine,
    Saturation,
    DroppedSamples,
    Quantisation,
    GaussMarkov,
    RateRandomWalk,
    LogCreep,
    RandomTelegraph,
    NoiseTemperature,
    DeadZone,
    Outside(Outside),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outside {
    /// Product of temperature and supply, both about their means.
    TempTimesSupply,
    /// A sine of the temperature with a period of 3 to 6 K.
    TempWiggle,
    /// A dip near one temperature.
    TempDip,
    /// White noise whose level follows supply or load.
    NoiseLevel,
    /// An oscillation of 60 to 200 s, unrelated to any logged channel.
    Oscillation,
    /// A jump when supply or temperature crosses a level.
    Threshold,
    /// Exponential recoveries after events that no logged channel shows.
    Recoveries,
    /// A line that is on for 5 to 20 s at random.
    Bursts,
    /// Product of supply and load, both about their means.
    SupplyTimesLoad,
}

/// Kind of data in which an error shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Band {
    /// Means of a second or longer.
    Slow,
    /// Single samples.
    Wide,
    /// Faults of the data rather than the sensor.
    Data,
    Stochastic,
}

/// Properties of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description {
    /// Identifier, such as `thermal_lag`.
    pub name: &'static str,
    /// Kind of data in which it shows.
    pub band: Band,
    /// Name of its parameter, and the range from which it is drawn logarithmically.
    pub parameter: Option<(&'static str, [f64; 2])>,
    /// Optional columns of the log that show it.
    pub needs: &'static [&'static str],
}

const MAG: &[&str] = &["mag_x_ut", "mag_y_ut", "mag_z_ut"];
const TEMP: &[&str] = &["temp_c"];
const SUPPLY: &[&str] = &["supply_v"];

impl Effect {
    /// Effects of the library.
    pub const LIBRARY: [Self; 30] = [
        Self::TempLinear,
        Self::TempPoly,
        Self::ThermalLag,
        Self::TempRate,
        Self::ThermalHysteresis,
        Self::WarmupExp,
        Self::BiasRamp,
        Self::BiasStep,
        Self::SupplySensitivity,
        Self::LoadHeating,
        Self::MagSensitivity,
        Self::GSensitivity,
        Self::VibrationRectification,
        Self::SfError,
        Self::SfNonlinearity,
        Self::SfAsymmetry,
        Self::SfTemp,
        Self::CrossAxis,
        Self::LeverArm,
        Self::SpectralLine,
        Self::DriftingLine,
        Self::Saturation,
        Self::DroppedSamples,
        Self::Quantisation,
        Self::GaussMarkov,
        Self::RateRandomWalk,
        Self::LogCreep,
        Self::RandomTelegraph,
        Self::NoiseTemperature,
        Self::DeadZone,
    ];

    /// Every effect, those outside the library last.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::LIBRARY.into_iter().chain(Outside::ALL.into_iter().map(Self::Outside))
    }

    /// Effect with this identifier.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|effect| effect.description().name == name)
    }

    pub fn is_outside(self) -> bool {
        matches!(self, Self::Outside(_))
    }

    pub fn description(self) -> Description {
        use Band::{Data, Slow, Stochastic, Wide};
        let tau = |low, high| Some(("tau_s", [low, high]));
        let (name, band, parameter, needs) = match self {
            Self::TempLinear => ("temp_linear", Slow, None, TEMP),
            Self::TempPoly => ("temp_poly", Slow, None, TEMP),
            Self::ThermalLag => ("thermal_lag", Slow, tau(15.0, 200.0), TEMP),
            Self::TempRate => ("temp_rate", Slow, None, TEMP),
            Self::ThermalHysteresis => ("thermal_hysteresis", Slow, Some(("half_width_k", [0.5, 4.0])), TEMP),
            Self::WarmupExp => ("warmup_exp", Slow, tau(15.0, 300.0), &[][..]),
            Self::BiasRamp => ("bias_ramp", Slow, None, &[][..]),
            Self::BiasStep => ("bias_step", Slow, Some(("t0_s", [200.0, 700.0])), &[][..]),
            Self::SupplySensitivity => ("supply_sensitivity", Slow, None, SUPPLY),
            Self::LoadHeating => ("load_heating", Slow, tau(15.0, 200.0), &["load_pct"][..]),
            Self::MagSensitivity => ("mag_sensitivity", Slow, None, MAG),
            Self::GSensitivity => ("g_sensitivity", Slow, None, &[][..]),
            Self::VibrationRectification => ("vibration_rectification", Slow, None, &[][..]),
            Self::SfError => ("sf_error", Slow, None, &[][..]),
            Self::SfNonlinearity => ("sf_nonlinearity", Slow, None, &[][..]),
            Self::SfAsymmetry => ("sf_asymmetry", Slow, None, &[][..]),
            Self::SfTemp => ("sf_temp", Slow, None, TEMP),
            Self::CrossAxis => ("cross_axis", Slow, None, &[][..]),
            Self::LeverArm => ("lever_arm", Slow, None, &[][..]),
            Self::SpectralLine => ("spectral_line", Wide, Some(("freq_hz", [0.5, 95.0])), &[][..]),
            Self::DriftingLine => ("drifting_line", Wide, Some(("freq_hz", [2.0, 90.0])), &[][..]),
            Self::Saturation => ("saturation", Data, Some(("frac", [0.001, 0.03])), &[][..]),
            Self::DroppedSamples => ("dropped_samples", Data, Some(("frac", [0.001, 0.03])), &[][..]),
            Self::Quantisation => ("quantisation", Data, Some(("mult", [4.0, 32.0])), &[][..]),
            Self::GaussMarkov => ("gauss_markov", Stochastic, tau(5.0, 200.0), &[][..]),
            Self::RateRandomWalk => ("rate_random_walk", Stochastic, None, &[][..]),
            Self::LogCreep => ("log_creep", Slow, Some(("onset_s", [2.0, 200.0])), &[][..]),
            Self::RandomTelegraph => {
                ("random_telegraph", Stochastic, Some(("dwell_s", [20.0, 100.0])), &[][..])
            }
            Self::NoiseTemperature => ("noise_temperature", Wide, None, TEMP),
            Self::DeadZone => ("dead_zone", Data, Some(("half_width_dps", [0.2, 2.0])), &[][..]),
            Self::Outside(outside) => return outside.description(),
        };
        Description { name, band, parameter, needs }
    }

    /// Returns true if this set-up can show it on this axis.
    pub fn suits(self, setup: Setup, target: Axis) -> bool {
        match self {
            Self::LoadHeating | Self::Outside(Outside::SupplyTimesLoad) => setup == Setup::Desk,
            Self::MagSensitivity | Self::GSensitivity => setup == Setup::PoseRig && target.is_gyro(),
            Self::VibrationRectification => setup == Setup::Shaker,
            Self::SfError | Self::SfNonlinearity | Self::SfAsymmetry | Self::SfTemp | Self::CrossAxis => {
                setup == if target.is_gyro() { Setup::RateTable } else { Setup::PoseRig }
            }
            Self::LeverArm => setup == Setup::RateTable && !target.is_gyro(),
            Self::DeadZone => setup == Setup::RateTable && target.is_gyro(),
            // in the presence of vibration their sizes would be wrong
            Self::SpectralLine
            | Self::DriftingLine
            | Self::Quantisation
            | Self::NoiseTemperature
            | Self::RandomTelegraph
            | Self::Outside(Outside::Bursts | Outside::NoiseLevel) => {
                setup != Setup::Shaker || target.is_gyro()
            }
            _ => true,
        }
    }

    /// Returns true if the temperature must change for it to show.
    pub(super) fn moves_with_temperature(self) -> bool {
        self.description().needs.contains(&"temp_c")
    }

    /// Returns true if the supply must change for it to show.
    pub(super) fn moves_with_supply(self) -> bool {
        self.description().needs.contains(&"supply_v")
    }
}

impl Outside {
    /// Nine effects outside the library.
    pub const ALL: [Self; 9] = [
        Self::TempTimesSupply,
        Self::TempWiggle,
        Self::TempDip,
        Self::NoiseLevel,
        Self::Oscillation,
        Self::Threshold,
        Self::Recoveries,
        Self::Bursts,
        Self::SupplyTimesLoad,
    ];

    fn description(self) -> Description {
        use Band::{Slow, Wide};
        let (name, band, parameter, needs) = match self {
            Self::TempTimesSupply => ("outside:temp_times_supply", Slow, None, &["temp_c", "supply_v"][..]),
            Self::TempWiggle => ("outside:temp_wiggle", Slow, Some(("period_k", [3.0, 6.0])), TEMP),
            Self::TempDip => ("outside:temp_dip", Slow, Some(("width_k", [0.6, 1.5])), TEMP),
            Self::NoiseLevel => ("outside:noise_level", Wide, None, SUPPLY),
            Self::Oscillation => ("outside:oscillation", Slow, Some(("period_s", [60.0, 200.0])), &[][..]),
            Self::Threshold => ("outside:threshold", Slow, None, &["temp_c", "supply_v"][..]),
            Self::Recoveries => ("outside:recoveries", Slow, Some(("tau_s", [10.0, 60.0])), &[][..]),
            Self::Bursts => ("outside:bursts", Wide, Some(("freq_hz", [2.0, 90.0])), &[][..]),
            Self::SupplyTimesLoad => ("outside:supply_times_load", Slow, None, &["supply_v", "load_pct"][..]),
        };
        Description { name, band, parameter, needs }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.description().name)
    }
}

impl From<Effect> for String {
    fn from(effect: Effect) -> Self {
        effect.to_string()
    }
}

impl TryFrom<String> for Effect {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        Self::named(&name).ok_or_else(|| {
            let names: Vec<&str> = Self::all().map(|effect| effect.description().name).collect();
            format!("there is no effect {name:?}; choose from {}", names.join(", "))
        })
    }
}
