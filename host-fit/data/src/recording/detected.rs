//! Rows at rest and detected motion: results of the detectors, stored with the recording they were computed from.

use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use fos_core::StillnessLimits;

/// Results of the detectors; none in a derived recording, and a clone has those of the original.
#[derive(Clone, Debug, Default)]
pub(crate) struct Detected {
    /// By the number of rows for fitting, from which later rows are separated.
    pub(crate) stillness: Found<usize, Stillness>,
    pub(crate) marks: Found<(), Marks>,
}

/// Results by key, each computed once.
#[derive(Debug)]
pub(crate) struct Found<K, T>(Mutex<Vec<(K, Arc<T>)>>);

impl<K: PartialEq, T> Found<K, T> {
    pub(crate) fn get_or_find(&self, key: K, find: impl FnOnce() -> T) -> Arc<T> {
        let known =
            |all: &[(K, Arc<T>)]| all.iter().find(|(of, _)| *of == key).map(|(_, one)| Arc::clone(one));
        if let Some(known) = known(&self.lock()) {
            return known;
        }
        // without the lock: `find` takes long, and its threads may come here again
        let new = Arc::new(find());
        let mut all = self.lock();
        if let Some(known) = known(&all) {
            return known;
        }
        all.push((key, Arc::clone(&new)));
        new
    }
}

impl<K, T> Found<K, T> {
    fn lock(&self) -> MutexGuard<'_, Vec<(K, Arc<T>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<K: Clone, T> Clone for Found<K, T> {
    fn clone(&self) -> Self {
        Self(Mutex::new(self.lock().clone()))
    }
}

impl<K, T> Default for Found<K, T> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

/// Rows at rest, and the source of this knowledge.
#[derive(Debug, Clone, PartialEq)]
pub struct Stillness {
    pub still: Vec<bool>,
    pub known_by: KnownBy,
    /// Detected motion in rows that should be at rest; those rows are not still.
    pub disturbances: Vec<Disturbance>,
    /// Rows from which gravity may have a different direction.
    pub turns: Vec<usize>,
    /// Limits for the detector on the device, from the quietest windows; `None` without all six axes.
    pub limits: Option<StillnessLimits<f64>>,
}

/// Source of the rows at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum KnownBy {
    /// The log has a `still` column.
    Column,
    /// The detector of fos-core ran over accelerometers and gyros.
    Detector,
    /// The detector finds little rest, but no motion is detected; the whole log is assumed to be still.
    NoMotion,
    /// Neither; the whole log is assumed to be still.
    Assumed,
}

impl KnownBy {
    /// Phrase for the middle of a sentence, such as `by its column …`.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Column => "by its column `still`",
            Self::Detector => "by the stillness detector",
            Self::NoMotion => "by the absence of detected motion",
            Self::Assumed => "by assumption (no column `still`, and not all six axes to detect it from)",
        }
    }
}

/// Stretch of a log in which the device was moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbance {
    /// Rows of the motion, including the ring-down of the sensor.
    pub rows: Range<usize>,
    pub kind: Kind,
    /// Rotation by the gyros, rad; `None` without all three.
    pub turned_rad: Option<f64>,
    /// Gravity may have a different direction afterwards: each rest has its own level.
    pub is_tilted: bool,
    /// Logged channel that explains it, of [`Kind::Explained`] only.
    pub channel: Option<String>,
}

impl Disturbance {
    /// A disturbance without rotation or tilt.
    pub(crate) fn level(rows: Range<usize>, kind: Kind) -> Self {
        Self { rows, kind, turned_rad: None, is_tilted: false, channel: None }
    }

    /// Returns true if its rows are excluded: neither those of lasting vibration, a state of the surroundings that may
    /// cause an effect, nor those that a logged channel explains.
    pub fn is_excluded(&self) -> bool {
        !matches!(self.kind, Kind::Vibration | Kind::Explained)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Short: a blow.
    Knock,
    /// Seconds of shaking: steps, a motor.
    Shaking,
    /// Picked up, or turned.
    Handling,
    /// Slow, of small size, for long: a building that sways.
    Sway,
    /// Lasting vibration: a machine that runs.
    Vibration,
    /// The device moves all along: a vehicle, a body.
    Motion,
    /// No motion: a shared step of the axes that a logged channel explains.
    Explained,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Knock => "knock",
            Self::Shaking => "shaking",
            Self::Handling => "handling",
            Self::Sway => "sway",
            Self::Vibration => "vibration",
            Self::Motion => "motion",
            Self::Explained => "effect of a logged channel",
        }
    }
}

/// Detected motion within the rows that a recording states are at rest, or within all rows without that statement.
#[derive(Debug, Clone)]
pub(crate) struct Marks {
    pub(crate) found: Vec<Disturbance>,
    /// Rows at rest without detected motion.
    pub(crate) rest: Vec<bool>,
    pub(crate) turns: Vec<usize>,
}
