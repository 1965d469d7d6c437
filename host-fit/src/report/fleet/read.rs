//! Which units of a part were read, and which were not.

use serde::Serialize;

use fos_data::statistics::median_of;
use fos_fleet::UnitRow;

/// Units that are listed by name; of more, those of the first names.
const LISTED: usize = 100;

/// What was read of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct UnitsRead {
    /// Units that were asked.
    pub units: usize,
    /// Those that told all.
    pub whole: usize,
    /// Those of which an axis could not be told.
    pub partly: usize,
    /// Those that told nothing.
    pub nothing: usize,
    /// Lots that are named.
    pub lots: usize,
    /// Length of the logs: the shortest, the median, the longest, s.
    pub seconds: Option<[f64; 3]>,
    /// Lowest and highest temperature of all logs, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// By how much the temperature changes in the median log, K.
    pub warming_k: Option<f64>,
    /// The units of which something could not be told.
    pub not_read: Vec<NotRead>,
    /// How many more there are.
    pub more: usize,
}

/// A unit of which nothing, or not everything, could be told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct NotRead {
    /// Its name.
    pub unit: String,
    /// Its lot.
    pub lot: Option<String>,
    /// Some axes could be told.
    pub is_partly: bool,
    /// Why, a line each.
    pub reasons: Vec<String>,
    /// What helps, each once.
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
            let told = rows.iter().filter(|row| !row.axes.is_empty());
            told.filter_map(|row| row.log.as_ref())
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
