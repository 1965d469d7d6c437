//! Units of N, B and K, in characters that every reader of configuration files accepts.

/// Units of the noise of an axis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoiseUnits {
    pub white: String,
    pub flicker: String,
    /// Unit of K.
    pub walk: String,
}

impl NoiseUnits {
    /// Returns the units for an axis in `unit`.
    pub fn of(unit: &str) -> Self {
        let per_second = match unit {
            "m/s²" => "m/s^3".to_owned(),
            "rad/s" => "rad/s^2".to_owned(),
            other => format!("{other}/s"),
        };
        let plain = if unit == "m/s²" { "m/s^2" } else { unit };
        Self {
            white: format!("{plain}/sqrt(Hz)"),
            flicker: plain.to_owned(),
            walk: format!("{per_second}/sqrt(Hz)"),
        }
    }
}
