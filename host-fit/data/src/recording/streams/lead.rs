//! Groups streams with equal timestamps, and chooses the lead.

use super::super::Stream;
use super::super::rate::median;
use super::clocks::Triad;
use crate::column::{AXES, GYROS};

/// Relative difference of rates that count as equal: oscillators of one nominal rate differ by up to that.
const SAME_RATE: f64 = 0.05;

/// Maximum number of intervals examined, evenly spread over the stream.
const MAX_WAITS: usize = 1 << 16;

/// Streams with equal timestamps.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) name: String,
    pub(super) stamps_ns: Vec<i64>,
    pub(super) columns: Vec<(String, Vec<f64>)>,
    /// Names of the streams that were joined to the first and contribute columns.
    pub(super) joined: Vec<String>,
    /// Samples that were out of order, and samples that were excluded.
    pub(super) sorted: u64,
    pub(super) dropped: u64,
}

impl Group {
    fn of(stream: Stream) -> Self {
        let Stream { name, stamps_ns, columns } = stream;
        Self { name, stamps_ns, columns, joined: Vec::new(), sorted: 0, dropped: 0 }
    }

    /// Usual time between two samples, ns; `None` if there is only one timestamp.
    pub(super) fn period_ns(&self) -> Option<i64> {
        let stride = self.stamps_ns.len().div_ceil(MAX_WAITS).max(1);
        let waits = self.stamps_ns.windows(2).step_by(stride).map(|pair| pair[1].saturating_sub(pair[0]));
        let mut waits: Vec<f64> = waits.filter(|wait| *wait > 0).map(|wait| wait as f64).collect();
        (!waits.is_empty()).then(|| median(&mut waits) as i64)
    }

    /// Usual rate, Hz; 0 if there is none.
    pub(super) fn rate_hz(&self) -> f64 {
        self.period_ns().map_or(0.0, |period_ns| 1e9 / period_ns as f64)
    }

    /// Three channels of the group, if it has all of them.
    pub(super) fn triad(&self, names: [&str; 3]) -> Option<Triad<'_>> {
        let of = |name: &str| {
            self.columns.iter().find(|(column, _)| column == name).map(|(_, values)| &values[..])
        };
        let [x, y, z] = names.map(of);
        Some(Triad { stamps_ns: &self.stamps_ns, values: [x?, y?, z?] })
    }

    fn count(&self, names: &[&str]) -> usize {
        self.columns.iter().filter(|(name, _)| names.contains(&name.as_str())).count()
    }
}

/// Groups streams with equal timestamps. Nothing is copied.
pub(super) fn groups(streams: Vec<Stream>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for stream in streams {
        match groups.iter_mut().find(|group| group.stamps_ns == stream.stamps_ns) {
            Some(group) => {
                group.columns.extend(stream.columns);
                group.joined.push(stream.name);
            }
            None => groups.push(Group::of(stream)),
        }
    }
    groups
}

/// Index of the lead: the fastest among those with inertial channels (among all, if none has any); of equally fast ones
/// that with most axes, then one with a gyro, then the first.
pub(super) fn choose(groups: &[Group]) -> Option<usize> {
    let axes = |group: &Group| group.count(&AXES);
    let any = groups.iter().any(|group| axes(group) > 0);
    let rates: Vec<f64> = groups.iter().map(Group::rate_hz).collect();
    let may = || (0..groups.len()).filter(|&index| !any || axes(&groups[index]) > 0);
    let highest = may().map(|index| rates[index]).fold(0.0, f64::max);
    let fastest = may().filter(|&index| rates[index] >= (1.0 - SAME_RATE) * highest);
    fastest.min_by_key(|&index| {
        let group = &groups[index];
        std::cmp::Reverse((axes(group), group.count(&GYROS)))
    })
}
