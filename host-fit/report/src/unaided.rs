//! Heading and position errors without aiding as people read them: before the model and after it.

use serde::Serialize;

use fos_data::column::{ACCELEROMETERS, Column, GYROS};
use fos_data::text::capitalised;
use fos_diagnose::compare::AxisComparison;
use fos_figures::units::{ShownUnit, Units, three};
use fos_fit::evaluate::{FEWEST_WINDOWS, RmsInterval, UnaidedError};

/// Legend of `before` and `after`.
pub const LEGEND: &str = "before: raw error minus the constant bias estimated in training; after: free run of the model, which \
                                 does not use the error measured in the window";

/// Legend of the errors of six axes together.
pub const LEGEND_STRAPDOWN: &str = "strapdown: all six axes together, where an attitude error tilts gravity into the position; position is a distance in space";

const POSITION: &str = "position error";

/// Errors of one axis after one time without aiding, as text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct UnaidedRow {
    /// `60 s`, `10 min`.
    pub window: String,
    /// `heading error`, `position error`.
    pub quantity: &'static str,
    /// `°`, `m`.
    pub unit: String,
    /// Number of windows.
    pub windows: usize,
    /// RMS before and after, in the unit; none where the log is too short.
    pub rms: Option<[Bounded; 2]>,
}

/// An RMS with its 90 % interval, without the unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Bounded {
    pub rms: String,
    pub low: String,
    pub high: String,
}

impl UnaidedRow {
    /// One row for each length of windows; none for an axis that is neither gyro nor accelerometer.
    pub fn all(axis: &AxisComparison, units: Units) -> Vec<Self> {
        axis.unaided().into_iter().map(|errors| Self::of(&axis.column, errors, units)).collect()
    }

    /// A heading and a position for each length of windows, of a strapdown of six axes.
    pub fn of_strapdown(errors: &[[UnaidedError; 2]], units: Units) -> Vec<Self> {
        let of_column = |errors: &[UnaidedError; 2], column: &str, is_heading: bool| {
            let only = |error: UnaidedError| UnaidedError {
                heading_rad: error.heading_rad.filter(|_| is_heading),
                position_m: error.position_m.filter(|_| !is_heading),
                ..error
            };
            Self::of(column, errors.map(only), units)
        };
        let [heading, position] = [(GYROS[0], true), (ACCELEROMETERS[0], false)]
            .map(|(column, is_heading)| errors.iter().map(move |of| of_column(of, column, is_heading)));
        heading.chain(position).collect()
    }

    fn of(column: &str, errors: [UnaidedError; 2], units: Units) -> Self {
        let unit = ShownUnit::of_unaided(column, units);
        let shown = |value: f64| three(value / unit.divisor);
        let bounded =
            |RmsInterval { rms, low, high }| Bounded { rms: shown(rms), low: shown(low), high: shown(high) };
        let [before, after] = errors.map(|error| error.rms().map(bounded));
        let UnaidedError { window_s, windows, .. } = errors[1];
        let is_gyro = Column::named(column).is_angular_rate();
        Self {
            window: if window_s > 60.0 {
                format!("{} min", window_s / 60.0)
            } else {
                format!("{window_s} s")
            },
            quantity: if is_gyro { "heading error" } else { POSITION },
            unit: unit.label,
            windows,
            rms: before.zip(after).map(|(before, after)| [before, after]),
        }
    }

    /// `Heading error after 60 s without aiding: 0.91° → 0.12° (RMS of 14 windows; 90 %: 0.70° … 1.30° → 0.09° … 0.16°)`.
    pub fn sentence(&self) -> String {
        let Self { window, quantity, windows, .. } = self;
        let begin = format!("{} after {window} without aiding", capitalised(quantity));
        let Some([before, after]) = &self.rms else {
            let place = match self.quantity {
                POSITION => " in the orientation of the fit",
                _ => "",
            };
            return format!("{begin}: too few windows at rest{place} ({windows} of {FEWEST_WINDOWS})");
        };
        let unit = if self.unit == "°" { "°".to_owned() } else { format!(" {}", self.unit) };
        let range = |Bounded { low, high, .. }: &Bounded| format!("{low} … {high}{unit}");
        format!(
            "{begin}: {}{unit} → {}{unit} (RMS of {windows} windows; 90 %: {} → {})",
            before.rms,
            after.rms,
            range(before),
            range(after)
        )
    }

    /// `0.91 → 0.12`, `too short`.
    pub fn cell(&self) -> String {
        match &self.rms {
            Some([before, after]) => format!("{} → {}", before.rms, after.rms),
            None => "too few".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(
        windows: usize,
        heading_rad: Option<RmsInterval>,
        position_m: Option<RmsInterval>,
    ) -> UnaidedError {
        UnaidedError { window_s: if windows < 3 { 600.0 } else { 60.0 }, windows, heading_rad, position_m }
    }

    #[test]
    fn sentences_state_both_errors_with_unit_windows_and_intervals() {
        let of = |rms: f64| Some(RmsInterval { rms, low: 0.8 * rms, high: 1.6 * rms });
        let heading = [0.91_f64, 0.12].map(|degrees| error(14, of(degrees.to_radians()), None));
        let row = UnaidedRow::of("gx_rads", heading, Units::Field);
        assert_eq!(
            row.sentence(),
            "Heading error after 60 s without aiding: 0.910° → 0.120° (RMS of 14 windows; 90 %: 0.728 … 1.46° → 0.0960 … 0.192°)"
        );
        assert_eq!(row.cell(), "0.910 → 0.120");
        let row = UnaidedRow::of("gx_rads", heading, Units::Si);
        assert!(row.sentence().contains(": 0.0159 rad → 0.00209 rad ("), "{}", row.sentence());
        let position = [12.0, 3.0].map(|metres| error(14, None, of(metres)));
        let sentence = UnaidedRow::of("ax_mps2", position, Units::Field).sentence();
        assert!(
            sentence.starts_with("Position error after 60 s without aiding: 12.0 m → 3.00 m ("),
            "{sentence}"
        );
    }

    #[test]
    fn too_few_windows_give_no_number() {
        let row = UnaidedRow::of("gx_rads", [error(2, None, None); 2], Units::Field);
        assert_eq!(
            row.sentence(),
            "Heading error after 10 min without aiding: too few windows at rest (2 of 3)"
        );
        assert_eq!(row.cell(), "too few");
    }
}
