//! Library of physical effects. An effect is data, a TOML file: the built-in ones and those of a user alike.

mod inputs;
mod own;
mod place;
#[cfg(test)]
mod reference_tests;
mod size;
mod terms;

use fos_data::column::{Column, Triad};

use serde::Deserialize;

pub use inputs::Inputs;
pub use size::SizeUnit;
pub use terms::{Product, Regressor};

use fos_data::file::FileError;

/// Template for a user's own effect, with every key explained.
pub const EXAMPLE: &str = include_str!("example.toml");

/// The built-in effects, in the order of docs and lists.
const BUILT_IN: [(&str, &str); 30] = {
    macro_rules! library {
        ($($id:literal)*) => { [$(($id, include_str!(concat!("library/", $id, ".toml")))),*] };
    }
    library!(
        "temp_linear" "temp_poly" "thermal_lag" "temp_rate" "thermal_hysteresis" "warmup_exp" "log_creep" "bias_ramp"
        "bias_step" "supply_sensitivity" "load_heating" "mag_sensitivity" "g_sensitivity" "vibration_rectification" "sf_error"
        "sf_nonlinearity" "sf_asymmetry" "sf_temp" "cross_axis" "lever_arm" "spectral_line" "drifting_line" "saturation"
        "dropped_samples" "quantisation" "gauss_markov" "rate_random_walk" "random_telegraph" "noise_temperature"
        "dead_zone"
    )
};

/// A physical effect: its cause, its equation and how to search for it.
#[derive(Debug, Clone, PartialEq, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Effect {
    /// Unique identifier, stable across releases: `thermal_lag`.
    pub id: String,
    /// Name as it stands in a sentence.
    pub name: String,
    /// Band of the error: block means, single samples, the data themselves, or noise.
    pub band: Band,
    /// Axes that the effect can act on.
    #[serde(default)]
    pub targets: Targets,
    /// Search method.
    #[serde(default)]
    pub search: Detector,
    /// True if any subset of the terms is the effect too: terms that explain nothing are excluded.
    #[serde(default)]
    pub any_terms: bool,
    /// Physical mechanism in the sensor.
    pub mechanism: String,
    pub equation: String,
    /// Typical size on phone-class parts.
    #[serde(default)]
    pub typical_size: String,
    /// Reference for the typical size.
    #[serde(default)]
    pub source: String,
    /// Experiment that shows the effect.
    pub experiment: String,
    /// Signature in a plot.
    #[serde(default)]
    pub gives_away: String,
    /// Cost of the correction on the device.
    #[serde(default)]
    pub device: String,
    /// Terms whose coefficients are fitted; empty if the effect is not searched for by regression.
    #[serde(default)]
    pub terms: Vec<EffectTerm>,
    /// Parameter that is searched for.
    pub parameter: Option<Parameter>,
    /// Effects that it is confused with, the most similar first.
    #[serde(default)]
    pub confused_with: Vec<ConfusedWith>,
}

/// Band in which an effect shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Band {
    Slow,
    /// In the samples.
    Wide,
    /// In the data before any physics.
    Data,
    Stochastic,
}

/// Axes that an effect can act on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Targets {
    #[default]
    Any,
    Gyro,
    Accelerometer,
}

impl Targets {
    /// Returns true if the axis of this column is among them.
    fn contain(self, column: &str) -> bool {
        let triad = Column::named(column).place().map(|(triad, _)| triad);
        match self {
            Targets::Any => true,
            Targets::Gyro => triad == Some(Triad::Gyros),
            Targets::Accelerometer => triad == Some(Triad::Accelerometers),
        }
    }
}

/// Search method of an effect: `search` in its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Detector {
    /// Regression on its terms, in block means.
    #[default]
    Terms,
    /// Step of the bias, in block means.
    Step,
    /// Spectral line with a constant phase.
    Line,
    /// Spectral line whose phase or frequency wanders.
    WanderingLine,
    /// Values that stop at a limit.
    Saturation,
    /// Missing samples.
    DroppedSamples,
    /// Quantisation steps that are coarse compared with the noise.
    CoarseSteps,
    /// Gauss-Markov process above the noise of the reference log, in block means.
    GaussMarkov,
    /// Random walk above the noise of the reference log, in block means.
    RandomWalk,
    /// Jumps to and fro between two levels, in block means.
    Telegraph,
    /// Noise level of the samples that follows the temperature.
    NoiseLevel,
    /// Gap in the histogram on both sides of the most frequent value.
    DeadZone,
}

impl Detector {
    /// Returns true if one log may show several effects of this kind, each with its own parameter.
    pub fn is_repeatable(self) -> bool {
        matches!(self, Self::Line | Self::Step)
    }
}

/// One regressor of an effect.
#[derive(Debug, Clone, PartialEq, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct EffectTerm {
    /// Products of inputs, or a sum of products: `ref_{target} * temp_c:lowpass({tau_s})`.
    pub regressor: String,
    /// Axes that the term can act on, among those of the effect.
    #[serde(default)]
    pub targets: Targets,
    /// Unit of the coefficient for a gyro.
    #[serde(default)]
    pub gyro: Option<String>,
    /// Unit of the coefficient for an accelerometer.
    #[serde(default)]
    pub accelerometer: Option<String>,
    /// Largest typical coefficient of a gyro, in its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro_typical: Option<f64>,
    /// Largest typical coefficient of an accelerometer, in its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accelerometer_typical: Option<f64>,
}

/// Parameter of an effect, searched for on a logarithmic grid and then refined.
#[derive(Debug, Clone, PartialEq, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Name, with the unit as its last part: `tau_s`.
    pub name: String,
    /// Unit of `low` and `high`; empty for a plain number.
    #[serde(default)]
    pub unit: String,
    /// Lower end of the search range.
    pub low: f64,
    /// Upper end of the search range.
    pub high: f64,
    /// True if values below `low` give the same error, so that an estimate at `low` is only an upper bound.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub open_below: bool,
}

/// Another effect that an effect is confused with.
#[derive(Debug, Clone, PartialEq, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct ConfusedWith {
    /// Identifier of the other effect, as `thermal_lag`.
    pub effect: String,
    /// Experiment that separates the two.
    pub separate: String,
}

/// Error in the file of an effect, or in a request to the library.
#[derive(Debug, thiserror::Error)]
pub enum EffectError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(
        "{place}: not an effect: {reason}\nhelp: the example of the library is a complete file to start from"
    )]
    NotAnEffect {
        /// File as given, with line and column if the parser reports them.
        place: String,
        reason: String,
    },
    #[error(
        "{place}: the id {id:?} is taken: {other} has an effect of it\nhelp: give this one another id, as \"my_{id}\""
    )]
    Taken {
        /// File, line and column.
        place: String,
        id: String,
        other: String,
    },
    #[error("{place}: confused_with names {id:?}, which is no effect{}\nhelp: write one of {}, or leave the entry out", did_you_mean(.closest.as_deref()), .known.join(", "))]
    NoRival {
        /// File, line and column.
        place: String,
        id: String,
        closest: Option<String>,
        known: Vec<String>,
    },
    #[error("there is no effect {id:?}{}\nhelp: the library has {}", did_you_mean(.closest.as_deref()), .known.join(", "))]
    Unknown { id: String, closest: Option<String>, known: Vec<String> },
    #[error(
        "nothing in the library is found as {search:?} on {column}\nhelp: undo the step whose effect has taken the place of the built-in one, and add it under another identifier"
    )]
    NoneFoundAs { search: Detector, column: String },
}

fn did_you_mean(closest: Option<&str>) -> String {
    closest.map(|closest| format!("; did you mean {closest:?}?")).unwrap_or_default()
}

impl EffectError {
    fn toml(path: &str, text: &str, error: &toml::de::Error) -> Self {
        Self::NotAnEffect {
            place: place::place(path, text, error.span()),
            reason: error.message().to_owned(),
        }
    }
}

/// The built-in effects and those that were added.
#[derive(Debug, Clone, PartialEq)]
pub struct Library {
    effects: Vec<Effect>,
}

impl Library {
    /// Returns the library of the built-in effects.
    pub fn built_in() -> Self {
        let read = |(id, text): &(&str, &str)| {
            Effect::parse(&format!("{id}.toml"), text).expect("a test reads every built-in effect")
        };
        Self { effects: BUILT_IN.iter().map(read).collect() }
    }

    /// Adds an effect, or replaces the one with the same identifier.
    pub fn add(&mut self, effect: Effect) {
        match self.effects.iter_mut().find(|known| known.id == effect.id) {
            Some(known) => *known = effect,
            None => self.effects.push(effect),
        }
    }

    /// Returns all effects, in order.
    pub fn effects(&self) -> &[Effect] {
        &self.effects
    }

    /// Returns the effect of this identifier.
    pub fn get(&self, id: &str) -> Result<&Effect, EffectError> {
        self.effects.iter().find(|effect| effect.id == id).ok_or_else(|| EffectError::Unknown {
            id: id.to_owned(),
            closest: fos_data::closest::closest(id, self.effects.iter().map(|effect| effect.id.as_str()))
                .map(str::to_owned),
            known: self.effects.iter().map(|effect| effect.id.clone()).collect(),
        })
    }

    /// Returns the effect with this search method that acts on the axis of `column`. If there are several, it is the
    /// last whose range contains the parameter `value` (a user's own is later than the built-in one), else the first.
    pub fn found_as(&self, search: Detector, column: &str, value: f64) -> Result<&Effect, EffectError> {
        let found_so =
            || self.effects.iter().filter(|effect| effect.search == search && effect.strikes(column));
        let holds = |effect: &&Effect| {
            effect
                .parameter
                .as_ref()
                .is_none_or(|parameter| (parameter.low..=parameter.high).contains(&value))
        };
        let found = found_so().rfind(holds).or_else(|| found_so().next());
        found.ok_or_else(|| EffectError::NoneFoundAs { search, column: column.to_owned() })
    }

    /// Returns the experiment that separates two effects, if the file of either states one.
    pub fn separation(&self, one: &str, other: &str) -> Option<&str> {
        let stated = |one: &str, other: &str| {
            let effect = self.effects.iter().find(|effect| effect.id == one)?;
            effect
                .confused_with
                .iter()
                .find(|rival| rival.effect == other)
                .map(|rival| rival.separate.as_str())
        };
        stated(one, other).or_else(|| stated(other, one))
    }
}

impl Effect {
    /// Reads an effect; `path` is used in the error.
    pub fn parse(path: &str, text: &str) -> Result<Self, EffectError> {
        let wrong = |reason: String| EffectError::NotAnEffect { place: path.to_owned(), reason };
        let effect: Self = toml::from_str(text).map_err(|error| EffectError::toml(path, text, &error))?;
        effect.check().map_err(wrong)?;
        Ok(effect)
    }

    /// Checks what the types of the fields do not; the error is the reason.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.id.is_empty()
            || !self.id.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        {
            return Err(format!("id {:?}: small letters, digits and _ only", self.id));
        }
        if let Some(parameter) = &self.parameter
            && self.search == Detector::Terms
            && !(parameter.low > 0.0 && parameter.low < parameter.high)
        {
            return Err(format!("parameter {:?}: 0 < low < high does not hold", parameter.name));
        }
        if self.search == Detector::Terms && self.terms.is_empty() {
            return Err("there is no [[terms]]: an effect that is searched by its terms needs one".to_owned());
        }
        for term in &self.terms {
            for unit in [&term.gyro, &term.accelerometer].into_iter().flatten() {
                unit.parse::<SizeUnit>()?;
            }
        }
        if self.search == Detector::Terms {
            // each term can act on one of the two
            for target in ["gx_rads", "ax_mps2"] {
                self.regressors(target, self.parameter.as_ref().map(|parameter| parameter.low))?;
            }
        }
        Ok(())
    }

    /// Returns true if the effect can act on the axis of this column.
    pub fn strikes(&self, column: &str) -> bool {
        self.targets.contain(column)
    }

    /// Returns true if no term needs a logged quantity.
    pub fn follows_clock_alone(&self) -> bool {
        self.needs_only("clock")
    }

    /// Returns true if there are terms and every one is a function of this column alone.
    pub(crate) fn follows_alone(&self, column: &str) -> bool {
        !self.terms.is_empty() && self.needs_only(column)
    }

    fn needs_only(&self, column: &str) -> bool {
        let is_input = |input: &str| input.trim().split(':').next() == Some(column);
        self.terms.iter().all(|term| term.regressor.split(['*', '+']).all(is_input))
    }

    /// Returns the regressors for a target column and a value of the parameter, each with the index of its term. Fails
    /// if a term cannot be read or refers to an axis that the target does not have.
    pub fn regressors(&self, target: &str, value: Option<f64>) -> Result<Vec<(usize, Regressor)>, String> {
        let name = self.parameter.as_ref().map(|parameter| parameter.name.as_str());
        let striking = self.terms.iter().enumerate().filter(|(_, term)| term.targets.contain(target));
        striking
            .map(|(number, term)| {
                Ok((number, Regressor::parse(&terms::filled(&term.regressor, target, name.zip(value))?)?))
            })
            .collect()
    }

    /// Returns the data-sheet unit of the coefficient of a term for a target column; `None` if the effect states none.
    pub fn unit(&self, term: usize, target: &str) -> Option<SizeUnit> {
        let term = self.terms.get(term)?;
        let unit = match Column::named(target).is_angular_rate() {
            true => term.gyro.as_ref(),
            false if Column::named(target).is_specific_force() => term.accelerometer.as_ref(),
            false => None,
        };
        unit.and_then(|unit| unit.parse().ok())
    }

    /// Returns the largest typical coefficient of a term for a target column, in its data-sheet unit.
    pub fn typical(&self, term: usize, target: &str) -> Option<f64> {
        let term = self.terms.get(term)?;
        match Column::named(target).is_angular_rate() {
            true => term.gyro_typical,
            false => term.accelerometer_typical.filter(|_| Column::named(target).is_specific_force()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_effects_parse_and_match_file_names() {
        for (id, text) in BUILT_IN {
            let effect = Effect::parse(id, text).unwrap();
            assert_eq!(effect.id, id);
            for text in [&effect.typical_size, &effect.source, &effect.gives_away, &effect.device] {
                assert!(!text.is_empty(), "{id}");
            }
        }
    }

    #[test]
    fn confused_with_is_symmetric() {
        let library = Library::built_in();
        for effect in library.effects() {
            for rival in &effect.confused_with {
                let other = library.get(&rival.effect).unwrap();
                let knows = other.confused_with.iter().any(|back| back.effect == effect.id);
                assert!(knows, "{} lists {}, not the other way round", effect.id, other.id);
            }
        }
    }

    #[test]
    fn own_line_takes_precedence_in_its_range() {
        let mut library = Library::built_in();
        let built_in = library.get("spectral_line").unwrap().clone();
        let mut hum = Effect { id: "mains_hum".to_owned(), ..built_in };
        let parameter = hum.parameter.as_mut().unwrap();
        (parameter.low, parameter.high) = (49.0, 51.0);
        library.add(hum);
        let found = |hz| library.found_as(Detector::Line, "gx_rads", hz).unwrap().id.as_str();
        assert_eq!(
            [found(50.02), found(16.4), found(480.0)],
            ["mains_hum", "spectral_line", "spectral_line"]
        );
        let none = Library { effects: Vec::new() };
        assert!(none.found_as(Detector::Line, "gx_rads", 50.0).unwrap_err().to_string().contains("help"));
    }

    #[test]
    fn unknown_effect_suggests_the_closest() {
        let error = Library::built_in().get("termal_lag").unwrap_err().to_string();
        assert!(error.contains("did you mean \"thermal_lag\"?"), "{error}");
    }

    #[test]
    fn rejects_invalid_effects_with_reason() {
        let start = "id = \"mine\"\nname = \"mine\"\nband = \"slow\"\nmechanism = \"m\"\nequation = \"e\"\nexperiment = \"x\"\n";
        let with = |terms: &str| Effect::parse("mine.toml", &format!("{start}{terms}"));
        assert!(with("[[terms]]\nregressor = \"temp_c * supply_v\"\ngyro = \"dps/K\"\n").is_ok());
        for (terms, expected) in [
            ("", "needs one"),
            ("[[terms]]\nregressor = \"temp_c:lowpas(3)\"\n", "lowpas"),
            ("[[terms]]\nregressor = \"temp_c:lowpas(3)\"\ntargets = \"accelerometer\"\n", "lowpas"),
            ("[[terms]]\nregressor = \"temp_c\"\ngyro = \"furlong\"\n", "furlong"),
            (
                "[[terms]]\nregressor = \"temp_c\"\n[parameter]\nname = \"tau_s\"\nlow = 5\nhigh = 1\n",
                "low < high",
            ),
            ("colour = \"red\"\n", "unknown field"),
        ] {
            let error = with(terms).unwrap_err().to_string();
            assert!(error.contains(expected) && error.starts_with("mine.toml"), "{error}");
        }
    }
}
