//! Ranges of x that are set apart by their background, and the one that is the same wherever a log is drawn over time:
//! where the unit was moved.

use fos_data::disturbance::{Disturbance, told};
use fos_data::recording::Recording;

/// Shaded ranges of x with one legend entry for all of them.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Shading {
    /// Text in the legend.
    pub label: String,
    /// Why it is set apart; decides the colour.
    pub tone: Tone,
    /// What is shaded.
    pub ranges: Vec<ShadedRange>,
}

/// Why a range is set apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Tone {
    /// To be looked at (orange).
    #[default]
    Apart,
    /// It has no say (grey).
    LeftOut,
}

/// One shaded range.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ShadedRange {
    /// Left end, in units of x.
    pub from: f64,
    /// Right end, in units of x.
    pub to: f64,
    /// Short text at its top, a number for instance.
    pub mark: String,
    /// What it is, in words, for who points at it; empty where the legend says it all.
    pub says: String,
}

/// Where a unit was moved though it was meant to be at rest, over the time stamps of `recording`, s: those stretches
/// that are left out.
pub fn moved(recording: &Recording, disturbances: &[Disturbance]) -> Shading {
    let left_out = disturbances.iter().filter(|one| one.is_left_out() && !one.rows.is_empty());
    let ranges = left_out.map(|one| ShadedRange {
        from: recording.time_s[one.rows.start],
        to: recording.time_s[one.rows.end - 1],
        mark: String::new(),
        says: told(recording, std::slice::from_ref(one)).concat(),
    });
    Shading { label: "left out: the unit was moved".into(), tone: Tone::LeftOut, ranges: ranges.collect() }
}

#[cfg(test)]
mod tests {
    use super::super::compare::{SetApart, Subject, residual};
    use super::super::svg;
    use super::*;
    use fos_data::disturbance::Kind;
    use fos_data::recording::{LoadOptions, Source};
    use fos_data::stillness;
    use fos_fit::signal::blocks::envelope;
    use fos_simulate::{Simulation, simulate};

    /// When it is knocked, s.
    const KNOCK_S: [f64; 2] = [60.0, 60.3];

    /// Two minutes at rest, with a knock.
    fn knocked(keep_moved: bool) -> Recording {
        let log = simulate(&Simulation { duration_s: 120.0, motion: false, ..Simulation::default() });
        let mut columns = log.columns;
        let times = columns[0].1.clone();
        for (name, values) in &mut columns {
            let size = if name.starts_with('a') { 2.0 } else { 0.1 };
            let is_axis = name.ends_with("_mps2") || name.ends_with("_rads");
            for (time, value) in times.iter().zip(values).filter(|_| is_axis) {
                if (KNOCK_S[0]..KNOCK_S[1]).contains(time) {
                    *value += size * (300.0 * (time - KNOCK_S[0])).sin();
                }
            }
        }
        let options = LoadOptions { keep_moved, ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("a test"), columns, &options).unwrap()
    }

    fn drawn(log: &Recording, moved: &Shading) -> String {
        let subject = Subject { channel: "gyro x", unit: "rad/s" };
        let values = &log.channel("gx_rads").unwrap().values;
        let outline = envelope(values, log.time_s[0], log.rate.period_s, 1000, 1.0);
        svg(&residual(subject, &[outline], "1 s mean", SetApart { label: "worst", worst_s: &[], moved }))
            .unwrap()
    }

    #[test]
    fn where_the_unit_was_moved_is_shaded_and_named_once_in_each_panel() {
        let log = knocked(false);
        let moved = moved(&log, &stillness::find(&log).disturbances);
        let [knock] = &moved.ranges[..] else { panic!("one knock: {moved:?}") };
        assert!(
            knock.from <= KNOCK_S[0] && knock.to >= KNOCK_S[1] && knock.to - knock.from < 3.0,
            "{knock:?}"
        );
        assert!(
            knock.says.starts_with("knock at 5") || knock.says.starts_with("knock at 6"),
            "{}",
            knock.says
        );
        let picture = drawn(&log, &moved);
        assert_eq!(picture.matches(&moved.label).count(), 2, "an entry of each panel's legend");
        assert_eq!(picture.matches("fill=\"#6B727B\"").count(), 4, "the stretch and its key, in two panels");
    }

    #[test]
    fn what_is_taken_as_any_other_row_or_lasts_is_not_shaded() {
        let log = knocked(true);
        let none = moved(&log, &stillness::find(&log).disturbances);
        assert_eq!(none.ranges, []);
        let picture = drawn(&log, &none);
        assert!(!picture.contains(&none.label) && !picture.contains("fill=\"#6B727B\""));
        let vibration =
            Disturbance { rows: 100..9000, kind: Kind::Vibration, turned_rad: None, is_tilted: false };
        assert_eq!(moved(&log, &[vibration]).ranges, []);
    }

    #[test]
    fn a_stretch_beyond_the_panel_is_cut_to_it() {
        let log = knocked(false);
        let beyond = ShadedRange { from: -1e3, to: 10.0, ..ShadedRange::default() };
        let outside = ShadedRange { from: 1e3, to: 2e3, ..ShadedRange::default() };
        let shading = Shading { label: "moved".into(), tone: Tone::LeftOut, ranges: vec![beyond, outside] };
        let picture = drawn(&log, &shading);
        let shaded: Vec<&str> =
            picture.lines().filter(|line| line.contains("<rect") && line.contains("#6B727B")).collect();
        assert_eq!(shaded.len(), 4, "{shaded:?}");
        assert!(shaded.iter().all(|rect| !rect.contains("x=\"-")), "{shaded:?}");
    }
}
