//! Sorts the samples of one stream among several.

use std::path::Path;

use super::super::error::RecordingError;
use super::lead::Group;

/// Largest delay of a sample that is sorted: the disorder of a bus, a queue or a batch. Beyond it the clock was set
/// back.
const STRAY_NS: i64 = 1_000_000_000;

/// Sorts by timestamp, those of one timestamp in the order of the file, and excludes duplicates and samples with an
/// isolated wrong timestamp. A stream in order is not changed.
pub(super) fn sort(path: &Path, group: &mut Group) -> Result<(), RecordingError> {
    let stamps = &group.stamps_ns;
    if stamps.is_sorted_by(|a, b| a < b) {
        return Ok(());
    }
    let rows = stamps.len();
    let mut order: Vec<usize> = Vec::with_capacity(rows);
    let (mut newest, mut backs) = (i64::MIN, 0);
    for (row, &stamp) in stamps.iter().enumerate() {
        let before = order.last().map(|&before| stamps[before]);
        let after = stamps.get(row + 1).copied();
        if is_far_off(stamp, before, after) {
            continue;
        }
        group.sorted += u64::from(stamp < newest);
        backs += u64::from(before.is_some_and(|before| is_far_back(before, stamp)));
        newest = newest.max(stamp);
        order.push(row);
    }
    if backs > 0 {
        let column = format!("the clock of {}", group.name);
        return Err(RecordingError::OutOfOrder { path: path.to_owned(), column, backs, rows });
    }
    order.sort_by_key(|&row| stamps[row]);
    let same = |a: usize, b: usize| {
        let equal = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
        stamps[a] == stamps[b] && group.columns.iter().all(|(_, values)| equal(values[a], values[b]))
    };
    order.dedup_by(|later, kept| same(*later, *kept));
    group.dropped = (rows - order.len()) as u64;
    group.stamps_ns = order.iter().map(|&row| stamps[row]).collect();
    for (_, values) in &mut group.columns {
        *values = order.iter().map(|&row| values[row]).collect();
    }
    Ok(())
}

fn is_far_back(before: i64, stamp: i64) -> bool {
    before > stamp && before.saturating_sub(stamp) > STRAY_NS
}

/// Returns true for a timestamp far ahead of consistent neighbours, or far behind both. The first timestamp has only one
/// neighbour: it is wrong if it is far ahead of it. The last one far ahead may follow a pause.
fn is_far_off(stamp: i64, before: Option<i64>, after: Option<i64>) -> bool {
    match (before, after) {
        (Some(before), Some(after)) => {
            !is_far_back(before, after) && (is_far_back(stamp, after) || is_far_back(before, stamp))
        }
        (None, Some(after)) => is_far_back(stamp, after),
        (_, None) => false,
    }
}
