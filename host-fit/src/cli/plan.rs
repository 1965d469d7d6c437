//! `plan`: what to record so that an effect of the library shows, and shows apart from the others.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::arguments::{Reading, axes, library};
use super::numbers::within;
use super::output::{Failure, print_json, print_line, spinner, table};
use super::units::{UnitsOption, three};
use fos_data::file::name_of;
use fos_data::recording::Recording;
use fos_diagnose::detect::{Course, Visibility, visibility};
use fos_diagnose::effects::Library;
use fos_figures::units::{ShownUnit, Units};

/// Plan a recording: the smallest effects that a temperature course shows
///
/// States the smallest coefficient of each effect of temperature and time that a recording shows with 90 % probability, and the
/// smallest that is distinguishable from the most similar other effect. Needs a log of the device at rest, which gives the noise
/// of each axis. In planned recordings the device lies still while the temperature rises and falls.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos plan rest.parquet --axis gx\nExample: fos plan rest.parquet --axis gx --minutes 60 --span 20 --cycles 3\nExample: fos plan rest.parquet --axis gx --log log.parquet"
)]
pub(super) struct Plan {
    /// A log of the device at rest, 10 min or longer
    #[arg(value_name = "REST")]
    rest: PathBuf,
    /// gx, a column, several with commas, or all
    #[arg(long, default_value = "all")]
    axis: String,
    /// Length of the planned recording, min
    #[arg(long, value_parser = within(1.0..=10_080.0))]
    minutes: Option<f64>,
    /// Difference between its highest and lowest temperature, K
    #[arg(long, value_parser = within(0.1..=200.0))]
    span: Option<f64>,
    /// Number of times the temperature rises and falls; 0.5 is one rise
    #[arg(long, value_parser = within(0.5..=1000.0))]
    cycles: Option<f64>,
    /// A recorded log, to compare it with the planned recordings
    #[arg(long, value_name = "LOG")]
    log: Option<PathBuf>,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    #[command(flatten)]
    shown: UnitsOption,
    #[command(flatten)]
    reading: Reading,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

/// Temperature at the start of a planned recording, °C.
const START_C: f64 = 25.0;

/// Planned recordings if no option describes one: minutes, K, cycles.
const USUAL: [(f64, f64, f64); 3] = [(30.0, 10.0, 0.5), (30.0, 10.0, 2.0), (60.0, 20.0, 2.0)];

/// Visibility of the effects on one axis in one recording.
#[derive(Debug, Serialize)]
struct OfRecording {
    /// The recording in words.
    recording: String,
    effects: Vec<Visibility>,
}

#[derive(Debug, Serialize)]
struct OfAxis {
    column: String,
    recordings: Vec<OfRecording>,
}

impl Plan {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        let rest = self.reading.read(&self.rest)?;
        let log = self.log.as_ref().map(|path| self.reading.read(path)).transpose()?;
        let spinner = spinner("planning");
        let of_axis = |column: String| self.of_axis(column, &rest, log.as_ref(), &library);
        let found = axes(&rest, &self.axis)?.into_iter().map(of_axis).collect::<Result<Vec<_>, Failure>>();
        spinner.finish_and_clear();
        let found = found?;
        if self.json {
            return print_json(&found);
        }
        found.iter().for_each(|axis| print_axis(axis, self.shown.units));
        print_line!(
            "\nEach cell: smallest coefficient found with 90 % probability / smallest distinguishable from the most similar effect; – at no size.\n\
             Typical: largest coefficient of usual sensors. In brackets: time constant in s or half width in K.\n\
             With the noise of {} as the `--reference` of `fos diagnose`, and the device at rest.",
            name_of(&rest.paths())
        );
        Ok(())
    }

    fn of_axis(
        &self,
        column: String,
        rest: &Recording,
        log: Option<&Recording>,
        library: &Library,
    ) -> Result<OfAxis, Failure> {
        let of = |recording: String, log: &Recording| -> Result<OfRecording, Failure> {
            Ok(OfRecording { recording, effects: visibility(log, rest, &column, library)? })
        };
        let recorded =
            log.map(|log| of(format!("{}, {:.0} min", name_of(&log.paths()), log.duration_s() / 60.0), log));
        let planned =
            self.courses().into_iter().map(|course| of(in_words(&course), &course.recording(&column)?));
        let recordings = recorded.into_iter().chain(planned).collect::<Result<_, Failure>>()?;
        Ok(OfAxis { column, recordings })
    }

    /// The recordings to plan: the one that the options describe, or three usual ones.
    fn courses(&self) -> Vec<Course> {
        let course = |minutes: f64, span_k, cycles| Course {
            seconds: 60.0 * minutes,
            start_c: START_C,
            span_k,
            cycles,
        };
        match (self.minutes, self.span, self.cycles) {
            (None, None, None) => USUAL.map(|(minutes, span, cycles)| course(minutes, span, cycles)).to_vec(),
            (minutes, span, cycles) => {
                let (usual_minutes, usual_span, usual_cycles) = USUAL[1];
                vec![course(
                    minutes.unwrap_or(usual_minutes),
                    span.unwrap_or(usual_span),
                    cycles.unwrap_or(usual_cycles),
                )]
            }
        }
    }
}

fn in_words(course: &Course) -> String {
    let cycles = match course.cycles {
        0.5 => "one rise".to_owned(),
        1.0 => "1 cycle".to_owned(),
        cycles => format!("{cycles} cycles"),
    };
    format!("{:.0} min, {} K, {cycles}", course.seconds / 60.0, course.span_k)
}

fn print_axis(axis: &OfAxis, units: Units) {
    let Some(best) = axis.recordings.last() else { return };
    let mut header = vec![format!("  {}", axis.column), "unit".to_owned(), "typical".to_owned()];
    header.extend(axis.recordings.iter().map(|recording| recording.recording.clone()));
    header.push("most similar".to_owned());
    let mut rows = table(&header);
    for effect in &best.effects {
        let shown = ShownUnit::of_size(&effect.unit, units);
        let in_unit = |size: f64| three(size / shown.divisor);
        let show = |size: Option<f64>| size.map_or_else(|| "–".to_owned(), in_unit);
        let name = match effect.parameter {
            Some(value) => format!("  {} ({})", effect.effect, three(value)),
            None => format!("  {}", effect.effect),
        };
        let mut row = vec![name, shown.label.clone(), effect.typical.map_or_else(String::new, in_unit)];
        for recording in &axis.recordings {
            let found = recording.effects.iter().find(|other| other.effect == effect.effect);
            row.push(found.map_or_else(
                || "–".to_owned(),
                |found| format!("{} / {}", show(found.detected_from), show(found.distinguishable_from)),
            ));
        }
        row.push(effect.rival.clone().unwrap_or_default());
        rows.add_row(row);
    }
    print_line!("\n{rows}");
}
