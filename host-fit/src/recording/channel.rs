//! One measured quantity.

use std::ops::Range;
use std::sync::Arc;

use super::unit::Unit;

/// One measured quantity, a value per row of its recording.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Name, with the unit as its last part where it is known: `gx_rads`, `temp_c`.
    pub name: String,
    /// Unit of the values.
    pub unit: Unit,
    /// One value per row, in `unit`. NaN: the cell is empty or not finite.
    /// Shared by the recordings that are made of one another.
    pub values: Arc<Vec<f64>>,
}

impl Channel {
    /// The values of `rows` as a device would see them: where one is missing, the last one before it, over gaps
    /// and from before `rows` too. NaN as long as there was none at all.
    ///
    /// # Panics
    /// If `rows` reaches beyond the recording.
    pub fn held(&self, rows: Range<usize>) -> impl Iterator<Item = f64> + '_ {
        let mut last =
            self.values[..rows.start].iter().rev().copied().find(|value| !value.is_nan()).unwrap_or(f64::NAN);
        self.values[rows].iter().map(move |&value| {
            if !value.is_nan() {
                last = value;
            }
            last
        })
    }

    /// How many values are missing (NaN).
    pub fn n_missing(&self) -> usize {
        self.values.iter().filter(|value| value.is_nan()).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_value_is_held_from_the_row_before_even_outside_the_range() {
        let nan = f64::NAN;
        let values = vec![nan, 1.0, nan, nan, 2.0, nan];
        let channel = Channel { name: "temp_c".into(), unit: Unit::Celsius, values: values.into() };
        assert_eq!(channel.held(3..6).collect::<Vec<_>>(), [1.0, 2.0, 2.0]);
        let all: Vec<f64> = channel.held(0..6).collect();
        assert!(all[0].is_nan());
        assert_eq!(all[1..], [1.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!(channel.n_missing(), 4);
    }
}
