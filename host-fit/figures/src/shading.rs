//! Ranges of x with a shaded background, and detected motion, which is shaded in all figures over time.

use std::ops::Range;

use fos_data::disturbance::{describe_disturbances, marked};
use fos_data::recording::{Recording, runs};
use fos_data::stillness::Stillness;

/// Shaded ranges of x with one legend entry for all of them.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Shading {
    /// Text in the legend.
    pub label: String,
    /// Reason for the shading; decides the colour.
    pub tone: Tone,
    /// Ranges of x.
    pub ranges: Vec<ShadedRange>,
}

/// Reason for the shading of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub enum Tone {
    /// Range of interest (orange).
    #[default]
    Apart,
    /// Excluded range (grey).
    LeftOut,
}

/// One shaded range.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ShadedRange {
    /// Left end, in units of x.
    pub from: f64,
    /// Right end, in units of x.
    pub to: f64,
    /// Short text at the top, such as a number.
    pub mark: String,
    /// Description for a tooltip; empty if the legend suffices.
    pub says: String,
}

/// Detected motion on a device meant to be at rest, over the timestamps of `recording`, s, where `stillness` excludes it. Descriptions come
/// from the whole log, because only parts of a motion remain among the rows that the detector accepts as still.
pub fn moved(recording: &Recording, stillness: &Stillness) -> Shading {
    let mut stretches: Vec<(Range<usize>, String)> = Vec::new();
    for one in marked(recording).1.iter().chain(&stillness.disturbances).filter(|one| one.is_excluded()) {
        let overlaps = |rows: &Range<usize>| rows.start < one.rows.end && one.rows.start < rows.end;
        match stretches.iter_mut().find(|(rows, _)| overlaps(rows)) {
            Some((rows, _)) => *rows = rows.start.min(one.rows.start)..rows.end.max(one.rows.end),
            None => stretches.push((
                one.rows.clone(),
                describe_disturbances(recording, std::slice::from_ref(one)).concat(),
            )),
        }
    }
    stretches.sort_by_key(|(rows, _)| rows.start);
    let ranges = stretches.into_iter().flat_map(|(rows, says)| {
        let left_out = runs(rows, |row| !stillness.still[row]);
        left_out.into_iter().map(move |rows| ShadedRange {
            from: recording.time_s[rows.start],
            to: recording.time_s[rows.end - 1],
            mark: String::new(),
            says: says.clone(),
        })
    });
    Shading { label: "excluded: detected motion".into(), tone: Tone::LeftOut, ranges: ranges.collect() }
}

#[cfg(test)]
mod tests {
    use super::super::compare::{Subject, over_time, shading};
    use super::super::{Figure, Ink, svg};
    use super::*;
    use fos_data::disturbance::Kind;
    use fos_data::recording::{LoadOptions, Source};
    use fos_data::stillness;
    use fos_fit::signal::blocks::envelope;
    use fos_simulate::{
        Axis, CasePlan, Disturbance as Disturbed, Setup, Simulation, simulate, simulate_case,
    };

    /// Times of the knock, s.
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
        let traces = [("residual", Ink::Residual)];
        let panels = over_time(subject, &traces, &[vec![outline]], shading(moved, []));
        svg(&Figure { title: "residual".into(), panels }).unwrap()
    }

    #[test]
    fn motion_is_shaded_with_one_legend_entry_per_panel() {
        let log = knocked(false);
        let moved = moved(&log, &stillness::find(&log));
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
    fn included_rows_and_lasting_vibration_are_not_shaded() {
        let log = knocked(true);
        let none = moved(&log, &stillness::find(&log));
        assert_eq!(none.ranges, []);
        let picture = drawn(&log, &none);
        assert!(!picture.contains(&none.label) && !picture.contains("fill=\"#6B727B\""));
        // Lasting vibration is a property of the environment.
        let log = knocked(false);
        let mut lasting = stillness::find(&log);
        lasting.disturbances[0].kind = Kind::Vibration;
        lasting.disturbances[0].rows = 0..2000;
        assert_eq!(moved(&log, &lasting).ranges.len(), 1, "the knock alone");
    }

    /// Regression test: motion found by the detector of stillness was described incompletely.
    #[test]
    fn shaded_rows_are_excluded_rows() {
        for (disturbance, seed) in
            [(Disturbed::Knocks, 1), (Disturbed::Handling, 1), (Disturbed::Handling, 8)]
        {
            let plan = CasePlan { disturbance, ..CasePlan::new(seed, "bmi270", Setup::Bench, Axis::Gx) };
            let columns = simulate_case(&plan).unwrap().log;
            let log =
                Recording::from_columns(Source::made_by("a test"), columns, &LoadOptions::default()).unwrap();
            let stillness = stillness::find(&log);
            let moved = moved(&log, &stillness);
            let shaded = |time: &f64| moved.ranges.iter().any(|range| (range.from..=range.to).contains(time));
            let is_shaded: Vec<bool> = log.time_s.iter().map(shaded).collect();
            let evaluation =
                is_shaded.iter().zip(&stillness.still).filter(|(shaded, still)| **shaded && **still);
            assert_eq!(evaluation.count(), 0, "{disturbance:?} {seed}: {:?}", moved.ranges);
            let excluded = stillness.disturbances.iter().filter(|one| one.is_excluded());
            assert!(excluded.clone().all(|one| is_shaded[one.rows.clone()].iter().all(|shaded| *shaded)));
            let longest = moved.ranges.iter().map(|range| range.to - range.from).fold(0.0, f64::max);
            let is_hand = moved.ranges.iter().any(|range| range.says.starts_with("handling"));
            assert_eq!(is_hand && longest > 8.0, disturbance == Disturbed::Handling, "{:?}", moved.ranges);
        }
    }

    #[test]
    fn shading_is_clipped_to_the_panel() {
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
