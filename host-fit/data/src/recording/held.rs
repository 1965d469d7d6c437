//! Replacement of missing cells by held values.

use std::sync::Arc;

use super::channel::Channel;
use super::{Boundary, Recording};

impl Recording {
    /// Values of a channel as a device has them, one per row: a missing value is replaced by the last one before it,
    /// across gaps too. NaN before the first value after power-on, that is, after the start of each joined recording.
    /// Shared with the channel if that lacks none.
    pub fn held(&self, channel: &Channel) -> Arc<Vec<f64>> {
        if channel.n_missing() == 0 {
            return Arc::clone(&channel.values);
        }
        let mut values = channel.values.to_vec();
        for rows in self.power_ons() {
            let mut last = f64::NAN;
            for value in &mut values[rows] {
                match value.is_nan() {
                    true => *value = last,
                    false => last = *value,
                }
            }
        }
        Arc::new(values)
    }

    /// The same with a value in every row: rows before the first value get that value. NaN only if the channel has no
    /// value at all.
    pub fn held_from_first(&self, channel: &Channel) -> Arc<Vec<f64>> {
        let mut held = self.held(channel);
        if held.iter().any(|value| value.is_nan()) {
            let values: &mut Vec<f64> = Arc::make_mut(&mut held);
            back_filled(values);
        }
        held
    }

    /// Ranges of rows from one power-on to the next.
    pub(super) fn power_ons(&self) -> Vec<std::ops::Range<usize>> {
        let mut starts: Vec<usize> = self
            .segments
            .iter()
            .filter(|s| s.boundary == Boundary::Recording)
            .map(|s| s.rows.start)
            .collect();
        starts.insert(0, 0);
        starts.push(self.n_rows());
        starts.windows(2).map(|pair| pair[0]..pair[1]).collect()
    }
}

/// Fills missing values with the next known one, and those after the last with the last.
pub fn back_filled(values: &mut [f64]) {
    let mut next = values.iter().rev().copied().find(|value| !value.is_nan()).unwrap_or(f64::NAN);
    for value in values.iter_mut().rev() {
        match value.is_nan() {
            true => *value = next,
            false => next = *value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, Source};
    use super::*;

    const NAN: f64 = f64::NAN;

    fn recording(temp_c: &[f64]) -> Recording {
        let columns = vec![("temp_c".to_owned(), temp_c.to_vec())];
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), columns, &options).unwrap()
    }

    fn equal(found: &[f64], wanted: &[f64]) {
        assert!(
            found.iter().zip(wanted).all(|(f, w)| f == w || f.is_nan() && w.is_nan())
                && found.len() == wanted.len(),
            "{found:?} {wanted:?}"
        );
    }

    #[test]
    fn holds_missing_values_from_the_first_one_on() {
        let recording = recording(&[NAN, 1.0, NAN, NAN, 2.0, NAN]);
        let channel = recording.channel("temp_c").unwrap();
        equal(&recording.held(channel), &[NAN, 1.0, 1.0, 1.0, 2.0, 2.0]);
        equal(&recording.held_from_first(channel), &[1.0, 1.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!(channel.n_missing(), 4);
    }

    /// The last value of one log used to be held into the next, though the device may have been off for a week.
    #[test]
    fn holds_no_value_across_recordings() {
        let both = Recording::join(vec![recording(&[1.0, 2.0, 3.0]), recording(&[NAN, 7.0, NAN])]).unwrap();
        let channel = both.channel("temp_c").unwrap();
        equal(&both.held(channel), &[1.0, 2.0, 3.0, NAN, 7.0, 7.0]);
        equal(&both.held_from_first(channel), &[1.0, 2.0, 3.0, 7.0, 7.0, 7.0]);
    }
}
