//! Invalid samples: bits flipped on the bus, a register that was not updated.

use super::Disturbance;
use super::motion::Disturbed;
use crate::random::{Random, Stream, between, log_between, random, sign};

/// Corrupts samples of the target, given its sample-to-sample noise; returns the affected stretches.
pub(crate) fn spoil(
    disturbance: Disturbance,
    values: &mut [f64],
    (deviation, period_s): (f64, f64),
    (seed, log): (u64, u64),
) -> Vec<Disturbed> {
    let random: &mut Random = &mut random(seed, Stream::Wild(log));
    let mut when = match disturbance {
        Disturbance::Spikes => spikes(values, deviation, period_s, random),
        Disturbance::Stuck => stuck(values, period_s, random),
        _ => Vec::new(),
    };
    when.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    when
}

/// 1 to 50 outliers, in groups of up to three, 5 to 1000 standard deviations off.
fn spikes(values: &mut [f64], deviation: f64, period_s: f64, random: &mut Random) -> Vec<Disturbed> {
    let wanted = log_between(random, 1.0, 50.99) as usize;
    let mut when = Vec::new();
    let mut spoilt = 0;
    while spoilt < wanted {
        let together = (1 + (between(random, 0.0, 1.0).powi(4) * 3.0) as usize).min(wanted - spoilt);
        let row = between(random, 0.0, (values.len() - together) as f64) as usize;
        let size = sign(random) * log_between(random, 5.0, 1000.0) * deviation;
        for value in &mut values[row..row + together] {
            *value += size * between(random, 0.5, 1.0);
        }
        when.push(Disturbed { from_s: row as f64 * period_s, to_s: (row + together) as f64 * period_s });
        spoilt += together;
    }
    when
}

/// 1 to 10 stretches of 0.1 to 2 s that repeat the last value.
fn stuck(values: &mut [f64], period_s: f64, random: &mut Random) -> Vec<Disturbed> {
    (0..log_between(random, 1.0, 10.99) as usize)
        .map(|_| {
            let rows = (log_between(random, 0.1, 2.0) / period_s) as usize;
            let row = between(random, 0.0, (values.len() - rows) as f64) as usize;
            let held = values[row];
            values[row..row + rows].fill(held);
            Disturbed { from_s: row as f64 * period_s, to_s: (row + rows) as f64 * period_s }
        })
        .collect()
}
