//! Units of a part that were read, and those that were not.

use serde::Serialize;

use fos_data::statistics::median_of;
use fos_fleet::UnitRow;

/// Largest number of units that are listed by name; of more, those with the first names.
const LISTED: usize = 100;

/// Counts of the units of a part, and ranges of their logs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct UnitsRead {
    /// Number of units.
    pub units: usize,
    /// Number of units with complete results.
    pub whole: usize,
    /// Number of units with results for some axes only.
    pub partly: usize,
    /// Number of units without results.
    pub nothing: usize,
    /// Number of named lots.
    pub lots: usize,
    /// Shortest, median and longest length of a log, s.
    pub seconds: Option<[f64; 3]>,
    /// Lowest and highest temperature of all logs, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Change of temperature within a log, median over the logs, K.
    pub warming_k: Option<f64>,
    /// Units without complete results, at most 100.
    pub not_read: Vec<NotRead>,
    /// Number of further units without complete results.
    pub more: usize,
}

/// Unit without results, or with results for some axes only.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct NotRead {
    /// Name of the unit.
    pub unit: String,
    /// Lot of the unit.
    pub lot: Option<String>,
    /// True if some axes have results.
    pub is_partly: bool,
    /// Reasons, a line each.
    pub reasons: Vec<String>,
    /// Remedies, each once.
    pub help: Vec<String>,
}

impl NotRead {
    fn of(row: &UnitRow) -> Self {
        let (mut reasons, mut help) = (Vec::new(), Vec::new());
        for reason in &row.failed {
            let (why, what_helps) = reason.split_once("\nhelp: ").unwrap_or((reason, ""));
            reasons.push(why.to_owned());
            if !what_helps.is_empty() && !help.iter().any(|other| other == what_helps) {
                help.push(what_helps.to_owned());
            }
        }
        Self { unit: row.unit.clone(), lot: row.lot.clone(), is_partly: !row.axes.is_empty(), reasons, help }
    }
}

impl UnitsRead {
    pub(super) fn of(rows: &[&UnitRow]) -> Self {
        let failed = || rows.iter().filter(|row| !row.failed.is_empty());
        let partly = failed().filter(|row| !row.axes.is_empty()).count();
        let nothing = failed().count() - partly;
        let mut lots: Vec<&str> = rows.iter().filter_map(|row| row.lot.as_deref()).collect();
        lots.sort_unstable();
        lots.dedup();
        let lengths = || {
            let diagnosed = rows.iter().filter(|row| !row.axes.is_empty());
            diagnosed.filter_map(|row| row.log.as_ref())
        };
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
        let seconds = || lengths().map(|log| log.seconds);
        let ranges = || lengths().filter_map(|log| log.temperature_c);
        Self {
            units: rows.len(),
            whole: rows.len() - partly - nothing,
            partly,
            nothing,
            lots: lots.len(),
            seconds: median_of(seconds()).map(|median| [least(&mut seconds()), median, most(&mut seconds())]),
            temperature_c: (ranges().count() > 0).then(|| {
                [least(&mut ranges().map(|[low, _]| low)), most(&mut ranges().map(|[_, high]| high))]
            }),
            warming_k: median_of(ranges().map(|[low, high]| high - low)),
            not_read: failed().take(LISTED).map(|row| NotRead::of(row)).collect(),
            more: failed().count().saturating_sub(LISTED),
        }
    }
}
