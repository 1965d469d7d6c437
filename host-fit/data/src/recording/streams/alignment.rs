//! Description of how streams were resampled, for readers of a log.

use std::fmt;

use super::clocks::Clocks;
use super::lead::Group;

/// Resampling of the streams of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// Name of the lead, the stream whose timestamps are those of the rows.
    pub lead: String,
    /// Rate of the lead, Hz.
    pub rate_hz: f64,
    /// Samples of the lead that were out of order and were sorted.
    pub samples_sorted: u64,
    /// Samples of the lead that were excluded: duplicates, or with an isolated wrong timestamp.
    pub samples_dropped: u64,
    /// The other streams; one that was both interpolated and held appears twice.
    pub others: Vec<JoinedStream>,
}

/// A stream other than the lead.
#[derive(Clone, Debug, PartialEq)]
pub struct JoinedStream {
    /// Name in the file.
    pub name: String,
    /// Rate of the stream, Hz.
    pub rate_hz: f64,
    pub how: HowJoined,
    /// Number of rows without a value of it.
    pub rows_missing: u64,
    /// Samples that were out of order and were sorted.
    pub samples_sorted: u64,
    /// Samples that were excluded: duplicates, or with an isolated wrong timestamp.
    pub samples_dropped: u64,
}

/// Method of resampling a stream at the timestamps of the lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HowJoined {
    /// Unchanged: its timestamps are those of the lead.
    SameStamps,
    /// Interpolated between its neighbours.
    Interpolated {
        /// Remaining share of the variance of white noise: the mean of (1 − w)² + w² for weights w.
        noise_kept: f64,
        /// Offset of its clock from that of the lead; `None` if it is not estimated.
        clocks: Option<Clocks>,
    },
    Held {
        /// Mean age of the values, s.
        mean_age_s: f64,
    },
}

impl Alignment {
    pub(super) fn led_by(lead: &Group) -> Self {
        let rate_hz = lead.rate_hz();
        let joined = |name: &String| JoinedStream {
            name: name.clone(),
            rate_hz,
            how: HowJoined::SameStamps,
            rows_missing: 0,
            samples_sorted: 0,
            samples_dropped: 0,
        };
        Self {
            lead: lead.name.clone(),
            rate_hz,
            samples_sorted: lead.sorted,
            samples_dropped: lead.dropped,
            others: lead.joined.iter().map(joined).collect(),
        }
    }
}

impl fmt::Display for Alignment {
    /// Writes a line for the lead, and one for each other stream.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rows are the samples of {} ({:.1} Hz)", self.lead, self.rate_hz)?;
        strays(f, self.samples_sorted, self.samples_dropped)?;
        self.others.iter().try_for_each(|other| write!(f, "\n{other}"))
    }
}

impl fmt::Display for JoinedStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({:.1} Hz) ", self.name, self.rate_hz)?;
        match self.how {
            HowJoined::SameStamps => write!(f, "has the same timestamps")?,
            HowJoined::Interpolated { noise_kept, clocks } => {
                write!(
                    f,
                    "is interpolated, which leaves {:.0} % of the variance of its fast noise and makes neighbouring rows alike: one-step errors of it are of the rows, not of the sensor",
                    100.0 * noise_kept
                )?;
                if let Some(clocks) = clocks {
                    write!(f, "; {clocks}")?;
                }
            }
            HowJoined::Held { mean_age_s } => write!(f, "is held, {mean_age_s:.3} s old on average")?,
        }
        if self.rows_missing > 0 {
            write!(f, "; {} rows have none of it", self.rows_missing)?;
        }
        strays(f, self.samples_sorted, self.samples_dropped)
    }
}

fn strays(f: &mut fmt::Formatter<'_>, sorted: u64, dropped: u64) -> fmt::Result {
    if sorted > 0 {
        write!(f, "; {sorted} samples were out of order and were sorted")?;
    }
    if dropped > 0 {
        write!(f, "; {dropped} duplicate samples, or samples with wrong timestamps, were excluded")?;
    }
    Ok(())
}
