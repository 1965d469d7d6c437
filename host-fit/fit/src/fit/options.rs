//! Options of a fit, with their defaults.

use std::fmt;
use std::str::FromStr;

use fos_core::{FittedOn, Transform};
use serde::{Deserialize, Serialize};

use super::stop::Stop;
use super::{Search, autoregression};
use crate::signal::wavelet::Denoising;
use fos_data::stored_as_text;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitOptions {
    /// Method for the stochastic part. Default: Fast Orthogonal Search.
    pub method: FitMethod,
    /// Pre-processing of the training data before an autoregression is estimated, as in the paper; FOS needs none.
    pub denoising: Option<Denoising>,
    /// Search strategy of FOS. Default: with exchanges.
    pub search: Search,
    /// L: output lags 1 … L are candidates; for an autoregression, its order. Default 10, as in the paper.
    pub max_lag: u16,
    /// Cross-product degree (CP), 1 … 3. Default 2.
    pub degree: usize,
    /// Time constants of low-passes of the remainder that are candidates in addition to its lags, s. Those longer than
    /// a fifth of the training data are excluded, and those shorter than two samples, which repeat the lags. Default 0.1, 1, 10, 100: ten lags are 50 ms at 200 Hz, and only the
    /// long memory carries a bias through a motion.
    pub memory_s: Vec<f64>,
    /// Inputs of the stochastic part, alone and in products with the output.
    pub inputs: Vec<InputSpec>,
    /// K: lags 0 … K of these inputs are candidates. Default 0.
    pub input_lags: u16,
    /// Inputs of the physical part: always in the model, estimated first, with coloured errors.
    pub physical: Vec<InputSpec>,
    /// Largest number of terms of the search. Default 20.
    pub max_terms: usize,
    /// Stop rule of the search.
    pub stop: Stop,
    /// Training part, from the start of the log. Default: half of it.
    pub train: Train,
    /// Offset subtracted from the measured error before scaling, in the axis' unit; by default its mean.
    pub offset: Option<f64>,
    /// Scale: the axis' unit per scaled unit; by default the standard deviation of the measured error.
    pub scale: Option<f64>,
    /// Full scale of the sensor, in the axis' unit; 0 if unknown.
    pub full_scale: f64,
    /// Kind of the measured values: raw or corrected.
    pub fitted_on: FittedOn,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            method: FitMethod::Fos,
            denoising: None,
            search: Search::Exchange,
            max_lag: 10,
            degree: 2,
            memory_s: vec![0.1, 1.0, 10.0, 100.0],
            inputs: Vec::new(),
            input_lags: 0,
            physical: Vec::new(),
            max_terms: 20,
            stop: Stop::Multiplicity,
            train: Train::Share(0.5),
            offset: None,
            scale: None,
            full_scale: 0.0,
            fitted_on: FittedOn::Raw,
        }
    }
}

/// Method for the stochastic part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitMethod {
    /// Fast Orthogonal Search among lags, their products, inputs and low-passes.
    Fos,
    /// All lags up to an order, by a classical method.
    Linear(autoregression::Method),
}

impl FitMethod {
    /// All methods: the four autoregressions, then FOS.
    pub const ALL: [Self; 5] = [
        Self::Linear(autoregression::Method::YuleWalker),
        Self::Linear(autoregression::Method::Covariance),
        Self::Linear(autoregression::Method::ModifiedCovariance),
        Self::Linear(autoregression::Method::Burg),
        Self::Fos,
    ];
}

impl fmt::Display for FitMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fos => f.write_str("fos"),
            Self::Linear(method) => method.fmt(f),
        }
    }
}

impl FromStr for FitMethod {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|method| method.to_string() == text);
        found.ok_or_else(|| {
            format!("{text:?} is not one of {}", Self::ALL.map(|method| method.to_string()).join(", "))
        })
    }
}

stored_as_text!(FitMethod);

/// Training part of a log, from its start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Train {
    /// Share of the rows.
    Share(f64),
    /// Time, at rest or not, s.
    Seconds(f64),
}

impl FromStr for Train {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (number, seconds) = match text.strip_suffix('s') {
            Some(number) => (number, true),
            None => (text.strip_suffix('%').unwrap_or(text), false),
        };
        let value: f64 =
            number.trim().parse().map_err(|_| format!("{text:?} is neither like 50% nor like 180s"))?;
        let share = if text.ends_with('%') { value / 100.0 } else { value };
        if !seconds && !text.ends_with('%') && value > 1.0 {
            return Err(format!("{text} is neither a share nor a time: write {text}% or {text}s"));
        }
        match seconds {
            true if value > 0.0 => Ok(Self::Seconds(value)),
            false if share > 0.0 && share <= 1.0 => Ok(Self::Share(share)),
            _ => Err(format!("{text:?}: a share lies between 0% and 100%, a time is positive")),
        }
    }
}

/// An input as on the command line: `temp_c`, `temp_c:lowpass(60)`, `clock:decay(200)`.
#[derive(Debug, Clone, PartialEq)]
pub struct InputSpec {
    /// Column, or `None` for the clock.
    pub column: Option<String>,
    pub transform: Transform<f64>,
}

impl FromStr for InputSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (column, transform) = text.split_once(':').unwrap_or((text, "identity"));
        let (name, parameter) = match transform.strip_suffix(')').and_then(|inner| inner.split_once('(')) {
            Some((name, number)) => {
                let number: f64 =
                    number.parse().map_err(|_| format!("{text:?}: {number:?} is not a number"))?;
                (name, Some(number))
            }
            None => (transform, None),
        };
        let transform = match (name, parameter) {
            ("identity", None) => Transform::Identity,
            ("lowpass", Some(tau_s)) => Transform::LowPass { tau_s },
            ("rate", Some(tau_s)) => Transform::Rate { tau_s },
            ("variance", Some(tau_s)) => Transform::Variance { tau_s },
            ("backlash", Some(half_width)) => Transform::Backlash { half_width },
            ("abs", None) => Transform::Absolute,
            ("decay", Some(tau_s)) => Transform::Decay { tau_s },
            ("time", None) => Transform::Time,
            ("sine", Some(frequency_hz)) => Transform::Sine { frequency_hz },
            ("cosine", Some(frequency_hz)) => Transform::Cosine { frequency_hz },
            _ => {
                return Err(format!(
                    "{text:?}: {transform:?} is not one of identity, lowpass(SECONDS), rate(SECONDS), \
                     variance(SECONDS), backlash(HALF_WIDTH), abs; for clock: decay(SECONDS), time, sine(HZ), cosine(HZ)"
                ));
            }
        };
        if !transform.convert::<f32>().is_valid() {
            return Err(format!("{text:?}: the parameter must be positive"));
        }
        let is_clock = column == "clock";
        if is_clock != transform.is_clock() {
            return Err(format!(
                "{text:?}: decay, time, sine and cosine go with clock, the others with a column"
            ));
        }
        Ok(Self { column: (!is_clock).then(|| column.to_owned()), transform })
    }
}

impl fmt::Display for InputSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&input_text(self.column.as_deref().unwrap_or("clock"), self.transform))
    }
}

/// Formats an input: `temp_c:lowpass(60)`.
pub(crate) fn input_text<R: fmt::Display>(column: &str, transform: Transform<R>) -> String {
    match transform {
        Transform::Identity => column.to_owned(),
        Transform::LowPass { tau_s } => format!("{column}:lowpass({tau_s})"),
        Transform::Rate { tau_s } => format!("{column}:rate({tau_s})"),
        Transform::Variance { tau_s } => format!("{column}:variance({tau_s})"),
        Transform::Backlash { half_width } => format!("{column}:backlash({half_width})"),
        Transform::Absolute => format!("{column}:abs"),
        Transform::Decay { tau_s } => format!("{column}:decay({tau_s})"),
        Transform::Time => format!("{column}:time"),
        Transform::Sine { frequency_hz } => format!("{column}:sine({frequency_hz})"),
        Transform::Cosine { frequency_hz } => format!("{column}:cosine({frequency_hz})"),
    }
}

stored_as_text!(InputSpec);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn input_text_round_trips() {
        for text in
            ["temp_c", "temp_c:lowpass(61.5)", "ax_mps2:variance(2)", "clock:time", "clock:sine(16.37)"]
        {
            assert_eq!(text.parse::<InputSpec>().unwrap().to_string(), text);
        }
        for text in
            ["temp_c:decay(3)", "clock:lowpass(3)", "temp_c:lowpass(-1)", "temp_c:lowpas(1)", "temp_c:abs(1)"]
        {
            assert!(text.parse::<InputSpec>().is_err(), "{text}");
        }
    }

    #[test]
    fn parses_training_part_as_share_or_time() {
        assert_eq!("50%".parse(), Ok(Train::Share(0.5)));
        assert_eq!("0.25".parse(), Ok(Train::Share(0.25)));
        assert_eq!("180s".parse(), Ok(Train::Seconds(180.0)));
        for text in ["0%", "120%", "-3s", "soon"] {
            assert!(text.parse::<Train>().is_err(), "{text}");
        }
    }
}
