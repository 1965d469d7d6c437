//! Axes with values in some rows only, since they are sampled at a separate rate: a table that was merged from streams.
//! They are split into streams again and resampled to a common time base like any others.

use super::Stream;
use super::channel::Channel;
use super::stream::stamps;
use super::streams::is_followed;

/// Minimum number of values that show a rate.
const MIN_VALUES: usize = 16;

/// Share of the intervals between values that lie within half of the median about it. Cells missing at random, one in
/// ten or more, give a smaller share.
const REGULAR: f64 = 0.95;

/// Longest mean run of rows that all have a value. Longer runs indicate lost samples; such an axis is fitted over the
/// rows that it has.
const LONGEST_RUN: f64 = 10.0;

/// Splits the channels of a table with timestamps (s) into streams if an axis has a separate rate; `None` if every axis
/// has a value in most rows, or only at irregular ones.
pub(super) fn streams(time_s: &[f64], channels: &[&Channel]) -> Option<Vec<Stream>> {
    let has_own_rate = |channel: &Channel| is_followed(&channel.name) && is_regular(time_s, &channel.values);
    if !channels.iter().copied().any(has_own_rate) {
        return None;
    }
    let all = stamps(time_s).into_iter().collect::<Option<Vec<i64>>>()?;
    // axes without a separate rate stay together, whatever cells they lack
    let mut patterns: Vec<(Vec<bool>, Vec<&Channel>)> = Vec::new();
    for channel in channels.iter().copied() {
        let pattern: Vec<bool> = match is_followed(&channel.name) && !has_own_rate(channel) {
            true => vec![true; all.len()],
            false => channel.values.iter().map(|value| value.is_finite()).collect(),
        };
        match patterns.iter_mut().find(|(other, _)| *other == pattern) {
            Some((_, channels)) => channels.push(channel),
            None => patterns.push((pattern, vec![channel])),
        }
    }
    let stream = |(pattern, channels): (Vec<bool>, Vec<&Channel>)| {
        let chosen = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(&pattern).filter(|(_, chosen)| **chosen).map(|(value, _)| *value).collect()
        };
        let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        Stream {
            name: names.join(", "),
            stamps_ns: all.iter().zip(&pattern).filter(|(_, chosen)| **chosen).map(|(ns, _)| *ns).collect(),
            columns: channels.iter().map(|one| (one.name.clone(), chosen(&one.values))).collect(),
        }
    };
    Some(patterns.into_iter().map(stream).collect())
}

/// Returns true if values come at one rate, and not in every row.
fn is_regular(time_s: &[f64], values: &[f64]) -> bool {
    let rows: Vec<usize> = (0..values.len()).filter(|row| values[*row].is_finite()).collect();
    if rows.len() < MIN_VALUES {
        return false;
    }
    let runs = 1 + rows.windows(2).filter(|pair| pair[1] > pair[0] + 1).count();
    let waits: Vec<f64> = rows.windows(2).map(|pair| time_s[pair[1]] - time_s[pair[0]]).collect();
    let median = super::rate::median(&mut waits.clone());
    let regular = waits.iter().filter(|wait| (*wait - median).abs() <= 0.5 * median).count();
    runs > 1
        && rows.len() as f64 <= LONGEST_RUN * runs as f64
        && regular as f64 >= REGULAR * waits.len() as f64
}

#[cfg(test)]
mod tests {
    use crate::recording::{HowJoined, LoadOptions, Recording, Source};

    const ROWS: usize = 400;

    /// ax and gx in the chosen rows, ax a line over the rows, at given times.
    fn recording(
        time_s: impl Fn(usize) -> f64,
        has_ax: impl Fn(usize) -> bool,
        has_gx: impl Fn(usize) -> bool,
    ) -> Recording {
        let column = |has: &dyn Fn(usize) -> bool| -> Vec<f64> {
            (0..ROWS).map(|row| if has(row) { 1e-3 * row as f64 } else { f64::NAN }).collect()
        };
        let columns = vec![
            ("t_s".to_owned(), (0..ROWS).map(time_s).collect()),
            ("ax_mps2".to_owned(), column(&has_ax)),
            ("gx_rads".to_owned(), column(&has_gx)),
            ("temp_c".to_owned(), (0..ROWS).map(|row| if row == 7 { 25.0 } else { f64::NAN }).collect()),
        ];
        Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
    }

    fn every_5_ms(row: usize) -> f64 {
        0.005 * row as f64
    }

    #[test]
    fn an_axis_in_every_kth_row_is_interpolated() {
        for every in [2, 3, 5, 20] {
            let recording = recording(every_5_ms, |row| row % every == 0, |_| true);
            assert_eq!(recording.n_rows(), ROWS);
            let ax = &recording.channel("ax_mps2").unwrap().values;
            for row in 0..ROWS - every {
                assert!((ax[row] - 1e-3 * row as f64).abs() < 1e-9, "every {every}, row {row}: {}", ax[row]);
            }
            let alignment = recording.alignment.unwrap();
            let ax = alignment.others.iter().find(|other| other.name == "ax_mps2").unwrap();
            assert!(matches!(ax.how, HowJoined::Interpolated { .. }), "{alignment}");
        }
    }

    #[test]
    fn axes_in_different_rows_have_the_rows_of_the_faster() {
        // gx at 200 Hz, ax at 100 Hz, 2.5 ms apart: no row has both
        let time_s = |row: usize| 0.01 * (row / 3) as f64 + 0.0025 * (row % 3) as f64;
        let recording = recording(time_s, |row| row % 3 == 1, |row| row % 3 != 1);
        let alignment = recording.alignment.as_ref().unwrap();
        assert_eq!(alignment.lead, "gx_rads");
        assert_eq!(recording.n_rows(), (0..ROWS).filter(|row| row % 3 != 1).count());
        assert_eq!(recording.channel("gx_rads").unwrap().n_missing(), 0);
        // before the first of ax, and after the last
        assert!(recording.channel("ax_mps2").unwrap().n_missing() <= 4);
    }

    #[test]
    fn lost_samples_are_not_a_rate() {
        let lost = |row: usize| !(row * row + row / 3).is_multiple_of(3);
        let block = |row: usize| (row / 50).is_multiple_of(2);
        for has in [&lost as &dyn Fn(usize) -> bool, &block, &|_| true, &|row| row % 10 != 0] {
            assert!(recording(every_5_ms, has, |_| true).alignment.is_none());
        }
    }
}
