//! `calibrate`: accuracy of the diagnosis on simulated cases.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::arguments::{OutputFile, library};
use super::numbers::count;
use super::output::{Failure, number, print_json, print_line, progress, table};
use super::world::possible_worlds;
use crate::calibration::{Calibration, Cases, Goal, Statistic, StoredOutcomes, calibrate, in_world};
use fos_data::file::write_atomically;
use fos_diagnose::effects::Library;
use fos_simulate::Disturbance;

/// Measure how often the diagnosis is right, on simulated cases
#[derive(Debug, Args)]
#[command(after_help = "Example: fos calibrate --cases 450 --seed 1")]
pub(super) struct Calibrate {
    /// Cases: a third with nothing missing
    #[arg(long, default_value_t = 450, value_parser = count(0..=100_000))]
    cases: usize,
    /// Seed of all cases
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Disturbance of the logs; "all" for a table of all
    #[arg(long, value_parser = worlds(), default_value = "clean")]
    world: Worlds,
    /// Diagnose every axis of the logs without a missing effect, not only one
    #[arg(long)]
    every_axis: bool,
    /// Write the outcome of every case to this file, as JSON. Until all are complete, they are in FILE.partial (with all
    /// worlds, in a FILE.WORLD.partial each), and interrupted calibrations resume
    #[arg(long, value_name = "FILE")]
    outcomes: Option<OutputFile>,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Fail if the 95 % interval of a figure is outside its limit
    #[arg(long)]
    check: bool,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

/// A disturbance, or all.
#[derive(Debug, Clone, Copy)]
struct Worlds(Option<Disturbance>);

fn worlds() -> impl TypedValueParser<Value = Worlds> {
    let all = PossibleValue::new("all").help("each of them, the same cases in all");
    PossibleValuesParser::new(possible_worlds().chain([all])).map(|name| Worlds(Disturbance::named(&name)))
}

impl Calibrate {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        let worlds = match self.world.0 {
            Some(world) => vec![world],
            None => Disturbance::ALL.to_vec(),
        };
        let (mut calibrations, mut all_stored) = (Vec::new(), Vec::new());
        for world in worlds {
            let stored = self.outcomes.as_ref().map(|path| self.stored(path, world, &library)).transpose()?;
            calibrations.push(self.calibrated(world, &library, stored.as_ref())?);
            all_stored.extend(stored);
        }
        let is_one = self.world.0.is_some();
        if let Some(path) = &self.outcomes {
            let outcomes: BTreeMap<&str, _> =
                calibrations.iter().map(|one| (one.world.name(), &one.outcomes)).collect();
            let text = match &calibrations[..] {
                [one] if is_one => serde_json::to_vec_pretty(&one.outcomes)?,
                _ => serde_json::to_vec_pretty(&outcomes)?,
            };
            write_atomically(path, &text)?;
        }
        all_stored.into_iter().for_each(StoredOutcomes::remove);
        let rated: Vec<(Disturbance, Vec<Statistic>)> = calibrations
            .iter()
            .map(|one| match is_one && one.world == Disturbance::Clean {
                true => (one.world, one.figures.clone()),
                false => (one.world, in_world(&one.outcomes)),
            })
            .collect();
        if self.json {
            let by_world: BTreeMap<&str, _> =
                rated.iter().map(|(world, figures)| (world.name(), figures)).collect();
            match &rated[..] {
                [(_, figures)] if is_one => print_json(figures)?,
                _ => print_json(&by_world)?,
            }
        } else {
            match &rated[..] {
                [(world, figures)] => print(&calibrations[0], *world, figures),
                _ => print_worlds(&calibrations[0], &rated),
            }
        }
        let missed: Vec<String> = rated
            .iter()
            .flat_map(|(world, figures)| {
                let missed = figures.iter().filter(|figure| !figure.may_hold());
                missed.map(|figure| match is_one {
                    true => figure.name.trim().to_owned(),
                    false => format!("{}: {}", world.name(), figure.name.trim()),
                })
            })
            .collect();
        if self.check && !missed.is_empty() {
            return Err(format!("not as it must be: {}", missed.join("; ")).into());
        }
        Ok(())
    }

    fn cases_in(&self, world: Disturbance) -> Cases {
        Cases { seed: self.seed, count: self.cases, world, every_axis: self.every_axis }
    }

    /// Results of a world, held until the outcomes of all are written.
    fn stored(
        &self,
        path: &OutputFile,
        world: Disturbance,
        library: &Library,
    ) -> Result<StoredOutcomes, Failure> {
        let mut of_world = path.as_os_str().to_owned();
        if self.world.0.is_none() {
            of_world.push(format!(".{}", world.name()));
        }
        Ok(StoredOutcomes::beside(Path::new(&of_world), &self.cases_in(world), library)?)
    }

    fn calibrated(
        &self,
        world: Disturbance,
        library: &Library,
        stored: Option<&StoredOutcomes>,
    ) -> Result<Calibration, Failure> {
        let bar = progress(self.cases as u64, world.name());
        let advance = |done| bar.set_position(done as u64);
        let calibration = calibrate(self.cases_in(world), library, stored, advance)?;
        bar.finish_and_clear();
        Ok(calibration)
    }
}

/// A row for each world.
fn print_worlds(calibration: &Calibration, rated: &[(Disturbance, Vec<Statistic>)]) {
    print_line!("{} cases in each world, seed {}\n", calibration.outcomes.len(), calibration.seed);
    let names = rated.first().map_or(&[][..], |(_, figures)| &figures[..]).iter();
    let header: Vec<&str> = std::iter::once("world").chain(names.map(|figure| figure.name.trim())).collect();
    let mut rows = table(&header);
    for (world, figures) in rated {
        let cell = |figure: &Statistic| {
            let value =
                figure.value.map_or_else(|| "–".to_owned(), |value| format!("{:.1} %", 100.0 * value));
            let interval = figure.interval.map_or_else(String::new, |[low, high]| {
                format!(" ({:.0} … {:.0}) of {}", 100.0 * low, 100.0 * high, figure.cases)
            });
            format!("{value}{interval}{}", if figure.holds() { "" } else { " missed" })
        };
        rows.add_row(std::iter::once(world.words().to_owned()).chain(figures.iter().map(cell)));
    }
    print_line!("{rows}");
}

fn print(calibration: &Calibration, world: Disturbance, figures: &[Statistic]) {
    print_line!("{} cases, seed {}, {}\n", calibration.outcomes.len(), calibration.seed, world.words());
    let mut rows = table(&["figure", "value", "95 % interval", "cases", "must", "aim", ""]);
    for figure in figures {
        let (must, aim) = match figure.goal {
            Goal::AtLeast(must, aim) => (format!("≥ {}", number(must)), format!("≥ {}", number(aim))),
            Goal::AtMost(must, aim) | Goal::Seconds(must, aim) => {
                (format!("≤ {}", number(must)), format!("≤ {}", number(aim)))
            }
            Goal::Within(must, aim) => (range(&must), range(&aim)),
        };
        rows.add_row(vec![
            figure.name.clone(),
            figure.value.map_or_else(|| "–".to_owned(), number),
            figure.interval.map_or_else(String::new, |interval| range(&interval)),
            figure.cases.to_string(),
            must,
            aim,
            mark(figure).to_owned(),
        ]);
    }
    print_line!("{rows}");
}

fn range([low, high]: &[f64; 2]) -> String {
    format!("{} … {}", number(*low), number(*high))
}

fn mark(figure: &Statistic) -> &'static str {
    if figure.holds() { "" } else { "missed" }
}
