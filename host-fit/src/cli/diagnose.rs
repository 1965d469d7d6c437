//! `diagnose`: what is missing from a model, or from none, on a log.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;

use super::arguments::{Reading, library};
use super::numbers::{IN_UNIT, within};
use super::output::{
    Failure, number, percent, print_json, print_line, print_verdict, print_warning, spinner, table,
    with_flags,
};
use super::refinement::{LogArguments, column_of, read_logs};
use fos_diagnose::detect::{Diagnosis, Finding, Question, Verdict, diagnose, with_measured_reduction};
use fos_diagnose::effects::{Band, Library};
use fos_diagnose::study::Study;

/// Say which physical effect is missing: what it is, how sure that is, and what the log cannot tell apart
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos diagnose flight.ulg\nExample: fos diagnose field.parquet --quiet quiet.parquet --axis gx\nExample: fos diagnose unit.json --from field.parquet --axis gx"
)]
pub(super) struct Diagnose {
    /// The log to explain; or a study (.json), whose model is taken off first
    #[arg(value_name = "LOG|STUDY")]
    of: PathBuf,
    /// gx, a column, or several with commas; all axes of a log if not given, needed for a study of several
    #[arg(long)]
    axis: Option<String>,
    #[command(flatten)]
    logs: LogArguments,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Full scale of the axis, in its SI unit
    #[arg(long, value_parser = within(1.0 / IN_UNIT..=IN_UNIT))]
    full_scale: Option<f64>,
    #[command(flatten)]
    reading: Reading,
    /// Print the answer as JSON
    #[arg(long)]
    json: bool,
}

impl Diagnose {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        let spinner = spinner("looking for what is missing");
        let (answers, read_as) = match self.of.extension().is_some_and(|extension| extension == "json") {
            true => (vec![self.of_study(&library)?], Vec::new()),
            false => self.of_log(&library)?,
        };
        spinner.finish_and_clear();
        if self.json {
            return print_json(&answers);
        }
        read_as.iter().for_each(|line| print_line!("{line}"));
        answers.iter().for_each(print_diagnosis);
        Ok(())
    }

    /// Of every axis that was asked for; and as what the log was read, if it is not in the log format.
    fn of_log(&self, library: &Library) -> Result<(Vec<Diagnosis>, Vec<String>), Failure> {
        if self.logs.from.is_some() {
            return Err(
                "--from goes with a study\nhelp: `fos diagnose STUDY --from LOG`, or the log alone".into()
            );
        }
        let field = self.reading.read(&self.of)?;
        let quiet = self.logs.quiet.as_ref().map(|path| self.reading.read(path)).transpose()?;
        let judged = self.logs.judge.as_ref().map(|path| self.reading.read(path)).transpose()?;
        let axes = super::arguments::axes(&field, self.axis.as_deref().unwrap_or("all"))?;
        let of_axis = |axis: &String| -> Result<Diagnosis, Failure> {
            let diagnosis = diagnose(&Question {
                quiet: quiet.as_ref(),
                judged: judged.as_ref(),
                full_scale: self.full_scale,
                ..Question::new(&field, axis, library)
            })?;
            Ok(match &judged {
                Some(judged) => with_measured_reduction(diagnosis, &field, judged)?,
                None => diagnosis,
            })
        };
        let mut answers = Vec::new();
        let mut refused = Vec::new();
        for axis in &axes {
            match of_axis(axis) {
                Ok(answer) => answers.push(answer),
                // an axis that is not named, as one that is stuck, does not keep the others from being explained
                Err(error) if self.axis.as_ref().is_none_or(|axis| axis == "all") => refused.push(error),
                Err(error) => return Err(error),
            }
        }
        if answers.is_empty() && !refused.is_empty() {
            return Err(refused.swap_remove(0));
        }
        refused
            .extend(field.quality.empty_axes.iter().filter_map(|axis| Some(field.axis(axis).err()?.into())));
        for error in &refused {
            // what to do is what was done
            let said = error.to_string();
            print_warning(&format!("left out: {}", said.split("\nhelp: ").next().unwrap_or_default()));
        }
        let read_as = field.sources.iter().filter_map(|source| source.read_as.as_ref());
        let mut said: Vec<String> = read_as.map(|read_as| format!("{}: {read_as}", field.paths())).collect();
        let joined = field.alignment.as_ref().map_or_else(String::new, ToString::to_string);
        said.extend(joined.lines().map(|line| format!("  {line}")));
        Ok((answers, said))
    }

    fn of_study(&self, library: &Library) -> Result<Diagnosis, Failure> {
        let study = Study::read(&self.of)?;
        let column = column_of(&study, self.axis.as_deref())?;
        let logs = read_logs(&self.logs, &self.reading, &study, &self.of, &column)?;
        let refiner = logs.refiner(library);
        let refinement = match study.refinement_of(&column) {
            Some(refinement) => refinement.clone(),
            None => refiner.begin(&study, &column, logs.named(refiner.fitted_rows()))?,
        };
        Ok(refiner.diagnose(&refinement)?)
    }
}

/// A diagnosis for people.
pub(super) fn print_diagnosis(diagnosis: &Diagnosis) {
    let is_good = diagnosis.verdict == Verdict::NothingMissing;
    print_verdict(&diagnosis.target, &diagnosis.sentence, is_good);
    let options = Diagnose::augment_args(clap::Command::new("diagnose"));
    for caution in &diagnosis.cautions {
        print_line!("  caution: {}", with_flags(caution, options.get_arguments()));
    }
    for note in &diagnosis.notes {
        print_line!("  note: {note}");
    }
    for moved in &diagnosis.moved {
        print_line!("  moved: {moved}");
    }
    let (faults, effects): (Vec<&Finding>, Vec<&Finding>) =
        diagnosis.findings.iter().partition(|finding| finding.band == Band::Data);
    if !effects.is_empty() {
        print_line!();
        let mut rows =
            table(&["  effect", "score", "size", "parameter", "predicted RMS reduction (90 %)", "measured"]);
        for finding in &effects {
            rows.add_row(row(finding));
        }
        print_line!("{rows}");
        for finding in &effects {
            print_evidence(finding);
        }
    }
    if !faults.is_empty() {
        print_line!("\n  faults of the data:");
        for fault in faults {
            let params = fault.params.iter().map(|(name, value)| format!(" {name} {}", number(*value)));
            print_line!("    {}{}", fault.effect, params.collect::<String>());
        }
    }
    if !diagnosis.leads.is_empty() {
        print_line!("\n  leads in the residual (not findings):");
        for lead in diagnosis.leads.iter().take(5) {
            print_line!("    {} (score {})", lead.follows, number(lead.score));
        }
    }
    let rejected: Vec<String> = diagnosis
        .rejected
        .iter()
        .take(6)
        .map(|rejected| format!("{} ({:.0})", rejected.effect, rejected.score))
        .collect();
    if !rejected.is_empty() {
        print_line!("\n  tested alone and not chosen, with score: {}", rejected.join(", "));
    }
    for rejected in &diagnosis.rejected {
        if let Some(why) = &rejected.why {
            print_line!("    {}: {why}", rejected.effect);
        }
    }
    if !diagnosis.tested.is_empty() {
        print_line!("  tested: {}", diagnosis.tested.join(", "));
    }
    let mut by_needs: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for untested in &diagnosis.untested {
        by_needs.entry(untested.needs.join(", ")).or_default().push(&untested.effect);
    }
    for (needs, effects) in by_needs {
        print_line!("  not tested, needs {needs}: {}", effects.join(", "));
    }
    print_line!(
        "  noise estimated from {}; {} blocks of {:.2} s",
        diagnosis.noise.learnt_from,
        diagnosis.noise.blocks,
        diagnosis.noise.block_s
    );
}

fn row(finding: &Finding) -> Vec<String> {
    let sizes: Vec<String> = finding
        .sizes
        .iter()
        .map(|size| {
            let half = 0.5 * (size.interval[1] - size.interval[0]);
            format!("{} ± {} {}", number(size.value), number(half), size.unit)
        })
        .collect();
    let params: Vec<String> = finding
        .params
        .iter()
        .map(|(name, value)| match finding.params_interval.get(name) {
            Some([low, high]) => format!("{name} {} ({} … {})", number(*value), number(*low), number(*high)),
            None => format!("{name} {}", number(*value)),
        })
        .collect();
    let fall = match finding.predicted_reduction != 0.0 {
        true => format!(
            "{} ({} … {})",
            percent(finding.predicted_reduction),
            percent(finding.predicted_reduction_interval[0]),
            percent(finding.predicted_reduction_interval[1])
        ),
        false => "–".to_owned(),
    };
    vec![
        format!("  {}", finding.effect),
        finding.score.map_or_else(|| "–".to_owned(), |score| format!("{score:.0}")),
        sizes.join(", "),
        params.join(", "),
        fall,
        finding.measured_reduction.map_or_else(String::new, percent),
    ]
}

fn print_evidence(finding: &Finding) {
    if let Some(doubt) = &finding.doubt {
        print_line!("  {}: not conclusive: {doubt}", finding.effect);
    }
    if let Some([begin, end]) = finding.shows_from_to_s {
        let against =
            finding.shows_against.as_ref().map(|column| format!("against {column}, ")).unwrap_or_default();
        print_line!("  {}: shows {against}most from {begin:.1} s to {end:.1} s", finding.effect);
    }
    for separation in &finding.separate {
        print_line!("  indistinguishable from {}: {}", separation.effect, separation.experiment);
    }
}
