//! `simulate --case` and `--suite`: case folders with a known effect, for the diagnosis.

use std::path::Path;

use clap::Args;

use super::arguments::OutputFolder;
use super::numbers::{count, within};
use super::output::{Failure, Written, print_written, progress};
use super::world::{setup, world};
use fos_simulate::{Axis, CasePlan, Disturbance, Effect, Plant, Setup, simulate_case, suite_in};

/// Content of a case.
#[derive(Debug, Args)]
pub(super) struct CaseArguments {
    /// Write a case: reference log, log to explain and evaluation log of one device with known effects, and the truth
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["log", "minutes", "rate", "temperature", "at_rest", "band_limited", "truth"])]
    case: Option<OutputFolder>,
    /// Write a seeded mix of N cases, FOLDER/case_000 …: nothing missing, single effects, pairs, indistinguishable effects, effects outside the library
    #[arg(long, value_name = "N", conflicts_with_all = ["case", "minutes", "rate", "temperature", "at_rest", "band_limited", "truth"], value_parser = count(0..=100_000))]
    suite: Option<usize>,
    /// How the device of a case is used
    #[arg(long, value_parser = setup(), default_value = "bench", requires = "case", conflicts_with = "log")]
    setup: Setup,
    /// Part of the sensor: bmi160, bmi270, lsm6dso, icm42688, mpu6050
    #[arg(long, default_value = "bmi270", requires = "case", conflicts_with = "log")]
    part: String,
    /// The axis to be explained: ax … gz
    #[arg(long, default_value = "gx", requires = "case", conflicts_with = "log")]
    target: String,
    /// An effect to plant; may be repeated; without any, nothing is missing. `outside:…` are outside the library
    #[arg(long = "effect", value_name = "ID[:PARAMETER=VALUE]", requires = "case", conflicts_with = "log")]
    effects: Vec<String>,
    /// Size of each effect in the noise of the log to explain, in standard errors
    #[arg(long, default_value_t = 30.0, requires = "case", conflicts_with = "log", value_parser = within(1e-6..=1e6))]
    size: f64,
    /// Disturbance of the log to explain and the evaluation log of a case, or of the cases of a suite that it suits
    #[arg(long, value_parser = world(), default_value = "clean", conflicts_with_all = ["minutes", "rate", "temperature", "at_rest", "band_limited", "truth"])]
    world: Disturbance,
}

impl CaseArguments {
    /// Returns whether a case or a suite is requested.
    pub(super) fn are_given(&self) -> bool {
        self.case.is_some() || self.suite.is_some()
    }

    /// Writes the case or the suite; `folder` is that of a suite.
    pub(super) fn run(&self, folder: Option<&Path>, seed: u64, json: bool) -> Result<(), Failure> {
        match (&self.case, self.suite, folder) {
            (Some(folder), ..) => {
                let case = simulate_case(&self.plan(seed)?)?;
                case.write(folder)?;
                let planted: Vec<String> = case
                    .truth
                    .planted
                    .iter()
                    .map(|p| format!("{} of size {:.1}", p.effect, p.size))
                    .collect();
                let planted =
                    if planted.is_empty() { "nothing missing".to_owned() } else { planted.join(", ") };
                let what = format!("{planted} in {}", case.meta.target);
                print_written(&[Written { path: folder.display().to_string(), what }], json)
            }
            (None, Some(count), Some(folder)) => write_suite(folder, (seed, self.world), count, json),
            // clap requires the folder.
            _ => Err("name the folder to write into: fos simulate --suite 45 FOLDER".into()),
        }
    }

    fn plan(&self, seed: u64) -> Result<CasePlan, Failure> {
        let target = Axis::named(&self.target).ok_or_else(|| {
            format!("there is no axis {:?}; choose from ax, ay, az, gx, gy, gz", self.target)
        })?;
        let mut plan = CasePlan::new(seed, &self.part, self.setup, target);
        plan.disturbance = self.world;
        let plants = self.effects.iter().map(|text| parse(text, self.size));
        plan.plant(plants.collect::<Result<Vec<Plant>, Failure>>()?);
        Ok(plan)
    }
}

/// `thermal_lag`, `thermal_lag:tau_s=60`, `outside:recoveries`, `outside:recoveries:tau_s=30`.
fn parse(text: &str, size: f64) -> Result<Plant, Failure> {
    let (name, parameter) = match text.rsplit_once(':') {
        Some((name, parameter)) if parameter.contains('=') => (name, Some(parameter)),
        _ => (text, None),
    };
    let effect = Effect::try_from(name.to_owned())?;
    let known = effect.description().parameter;
    let parameter = match (parameter.and_then(|p| p.split_once('=')), known) {
        (None, _) => None,
        (Some((name, value)), Some((expected, _))) if name == expected => {
            Some(value.parse::<f64>().map_err(|_| format!("{text}: {value:?} is no number"))?)
        }
        (Some((name, _)), Some((expected, [low, high]))) => {
            return Err(format!(
                "{effect} has no parameter {name:?}; it has {expected}, usually {low} to {high}"
            )
            .into());
        }
        (Some(_), None) => return Err(format!("{effect} has no parameter").into()),
    };
    Ok(Plant { effect, parameter, size })
}

fn write_suite(
    folder: &Path,
    (seed, world): (u64, Disturbance),
    count: usize,
    json: bool,
) -> Result<(), Failure> {
    let plans = suite_in(seed, count, world);
    let bar = progress(plans.len() as u64, "writing cases");
    for (number, plan) in plans.iter().enumerate() {
        simulate_case(plan)?.write(folder.join(format!("case_{number:03}")))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let what = format!("{} cases", plans.len());
    print_written(&[Written { path: folder.display().to_string(), what }], json)
}
