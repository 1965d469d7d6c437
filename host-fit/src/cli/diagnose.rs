//! `diagnose`: missing effects of a model, or of a sensor without one, on a log.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use clap::Args;
use comfy_table::CellAlignment;

use super::arguments::{Reading, axes, library, print_excluded, usable};
use super::numbers::{IN_UNIT, within};
use super::output::{
    Failure, first, grouped, percent, print_hint, print_json, print_line, print_verdict, spinner, table,
    with_flags,
};
use super::refinement::{LogArguments, columns_of, read_logs};
use super::units::{Printed, three};
use fos_diagnose::detect::{
    Diagnosis, Finding, Question, Size, Verdict, diagnose_and_measure, with_shared_signal,
};
use fos_diagnose::effects::{Band, Library};
use fos_diagnose::refine::Logs;
use fos_diagnose::study::{LogSources, Study};

/// Find out why a sensor drifts: identify the missing physical effects
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos diagnose flight.ulg\nExample: fos diagnose log.parquet --reference reference.parquet --axis gx\nExample: fos diagnose unit.json --from log.parquet --axis gx"
)]
pub(super) struct Diagnose {
    /// The log to explain; or a study (.json), whose model is subtracted first
    #[arg(value_name = "LOG|STUDY")]
    of: PathBuf,
    /// gx, a column, or several with commas; all axes if not given
    #[arg(long)]
    axis: Option<String>,
    #[command(flatten)]
    logs: LogArguments,
    /// Effects of your own, one TOML file each. May be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Full scale of the axis, in SI units
    #[arg(long, value_parser = within(1.0 / IN_UNIT..=IN_UNIT))]
    full_scale: Option<f64>,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    printed: Printed,
    /// Print the answer as JSON
    #[arg(long)]
    json: bool,
}

impl Diagnose {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let library = library(&self.effects)?;
        let spinner = spinner("testing effects");
        let (answers, read_as) = match self.of.extension().is_some_and(|extension| extension == "json") {
            true => (self.of_study(&library)?, Vec::new()),
            false => self.of_log(&library)?,
        };
        spinner.finish_and_clear();
        if self.json {
            return print_json(&answers);
        }
        read_as.iter().for_each(|line| print_line!("{line}"));
        match &answers[..] {
            [_, _, ..] if !self.printed.details => print_overview(&answers, self.printed),
            answers => answers.iter().for_each(|answer| print_diagnosis(answer, self.printed)),
        }
        Ok(())
    }

    /// Diagnoses of all requested axes; and the format of the log, if it is not the log format.
    fn of_log(&self, library: &Library) -> Result<(Vec<Diagnosis>, Vec<String>), Failure> {
        if self.logs.from.is_some() {
            return Err(
                "--from goes with a study\nhelp: `fos diagnose STUDY --from LOG`, or the log alone".into()
            );
        }
        let field = self.reading.read(&self.of)?;
        let reference = self.logs.reference.as_ref().map(|path| self.reading.read(path)).transpose()?;
        let evaluation = self.logs.evaluate_on.as_ref().map(|path| self.reading.read(path)).transpose()?;
        // once for all axes
        let evaluation = evaluation.as_ref().map(|evaluation| evaluation.led_in_by(&field));
        let names = self.axis.as_deref().unwrap_or("all");
        let axes = axes(&field, names)?;
        let of_axis = |axis: &String| -> Result<Diagnosis, Failure> {
            Ok(diagnose_and_measure(&Question {
                reference: reference.as_ref(),
                evaluation: evaluation.as_ref().map(|(log, _)| &**log),
                evaluation_from: evaluation.as_ref().map_or(0, |(_, from)| *from),
                full_scale: self.full_scale,
                ..Question::new(&field, axis, library)
            })?)
        };
        let answers = usable(names, axes.iter().map(of_axis))?;
        for error in field.quality.empty_axes.iter().filter_map(|axis| field.axis(axis).err()) {
            print_excluded(&error.into());
        }
        let read_as = field.sources.iter().filter_map(|source| source.read_as.as_ref());
        let answers = with_shared_signal(answers, &field)?;
        let mut notes: Vec<String> = read_as.map(|read_as| format!("{}: {read_as}", field.paths())).collect();
        let joined = field.alignment.as_ref().map_or_else(String::new, ToString::to_string);
        notes.extend(joined.lines().map(|line| format!("  {line}")));
        Ok((answers, notes))
    }

    fn of_study(&self, library: &Library) -> Result<Vec<Diagnosis>, Failure> {
        let study = Study::read(&self.of)?;
        let columns = columns_of(&study, self.axis.as_deref())?;
        // axes that were refined on the same logs read them once
        let mut latest: Option<(Option<&LogSources>, Logs)> = None;
        let of_axis = |column: &String| -> Result<Diagnosis, Failure> {
            let refined = study.refinement_of(column);
            let sources = refined.map(|refinement| &refinement.logs);
            let logs = match latest.take().filter(|(of, _)| *of == sources) {
                Some((_, logs)) => logs,
                None => read_logs(&self.logs, &self.reading, &study, &self.of, column)?,
            };
            let logs = &latest.insert((sources, logs)).1;
            let refiner = logs.refiner(library);
            let refinement = match refined {
                Some(refinement) => refinement.clone(),
                None => refiner.begin(&study, column, logs.named(refiner.fitted_rows()))?,
            };
            Ok(refiner.diagnose(&refinement)?)
        };
        usable(if columns.len() > 1 { "all" } else { "" }, columns.iter().map(of_axis))
    }
}

/// Findings of one axis that a summary shows, and the remarks of one kind.
const SHOWN: usize = 3;

/// A diagnosis for people.
pub(super) fn print_diagnosis(diagnosis: &Diagnosis, printed: Printed) {
    let is_good = diagnosis.verdict == Verdict::NothingMissing;
    print_verdict(&diagnosis.target, &diagnosis.sentence, is_good);
    print_remarks(std::slice::from_ref(diagnosis), printed);
    let (faults, effects): (Vec<&Finding>, Vec<&Finding>) =
        diagnosis.findings.iter().partition(|finding| finding.band == Band::Data);
    if !effects.is_empty() {
        print_line!();
        let mut rows =
            table(&["  effect", "score", "size", "parameter", "predicted RMS reduction (90 %)", "measured"]);
        for finding in &effects {
            rows.add_row(row(finding, printed));
        }
        print_line!("{rows}");
        for line in effects.iter().flat_map(|finding| evidence(finding)) {
            print_line!("  {line}");
        }
    }
    if !faults.is_empty() {
        print_line!("\n  faults of the data:");
        for fault in faults {
            let params = fault.params.iter().map(|(name, value)| format!(" {name} {}", three(*value)));
            print_line!("    {}{}", fault.effect, params.collect::<String>());
        }
    }
    if !diagnosis.leads.is_empty() {
        print_line!("\n  leads in the residual (not findings):");
        for lead in diagnosis.leads.iter().take(printed.at_most(SHOWN)) {
            print_line!("    {} (score {})", lead.follows, three(lead.score));
        }
    }
    let rejected = diagnosis.rejected.iter().take(2 * SHOWN);
    let rejected: Vec<String> =
        rejected.map(|rejected| format!("{} ({:.0})", rejected.effect, rejected.score)).collect();
    if !rejected.is_empty() {
        print_line!("\n  tested alone and not chosen, with score: {}", rejected.join(", "));
    }
    for rejected in diagnosis.rejected.iter().take(printed.at_most(SHOWN)) {
        if let Some(why) = &rejected.why {
            print_line!("    {}: {why}", rejected.effect);
        }
    }
    if !diagnosis.tested.is_empty() {
        print_line!("  tested: {}", diagnosis.tested.join(", "));
    }
    print_tests(std::slice::from_ref(diagnosis));
    print_hint(printed);
}

/// One row for each axis, then the remarks on all of them.
fn print_overview(answers: &[Diagnosis], printed: Printed) {
    let mut rows = table(&["axis", "verdict", "effects", "predicted RMS reduction", "measured"]);
    for column in rows.column_iter_mut().skip(1).take(2) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    for answer in answers {
        let (conclusive, doubtful): (Vec<&Finding>, Vec<&Finding>) =
            answer.findings.iter().partition(|finding| finding.doubt.is_none());
        let mut cell: Vec<String> =
            conclusive.iter().take(SHOWN).map(|finding| in_short(finding, printed)).collect();
        if conclusive.len() > SHOWN {
            cell.push(format!("and {} more", conclusive.len() - SHOWN));
        }
        if !doubtful.is_empty() {
            let names: Vec<&str> = doubtful.iter().map(|finding| finding.effect.as_str()).collect();
            cell.push(format!("not conclusive: {}", names.join(", ")));
        }
        if cell.is_empty() {
            cell.extend(match (&answer.shared_signal, answer.leads.first()) {
                (Some(_), _) => Some("a slow signal that axes share".to_owned()),
                (None, lead) => lead.map(|lead| format!("residual follows {}", lead.follows)),
            });
        }
        rows.add_row(vec![
            answer.target.clone(),
            answer.verdict.words().to_owned(),
            cell.join(", "),
            all_of(answer, |finding| Some(finding.predicted_reduction)),
            all_of(answer, |finding| finding.measured_reduction),
        ]);
    }
    print_line!("{rows}\n");
    print_remarks(answers, printed);
    let evidence = answers.iter().flat_map(|answer| {
        let lines = answer.findings.iter().flat_map(evidence);
        lines.map(|line| (answer.target.as_str(), line))
    });
    for line in grouped(evidence, answers.len()).into_iter().take(2 * SHOWN) {
        print_line!("  {line}");
    }
    print_tests(answers);
    let alarm = answers.iter().find(|answer| answer.verdict.is_alarm()).unwrap_or(&answers[0]);
    print_line!("--axis {} prints one axis, --details all of them", alarm.target);
}

/// The reduction of the RMS with all findings of a slow or stochastic effect in the model.
fn all_of(answer: &Diagnosis, reduction: impl Fn(&Finding) -> Option<f64>) -> String {
    let claims = answer.findings.iter().filter(|finding| {
        finding.doubt.is_none() && matches!(finding.band, Band::Slow) && finding.predicted_reduction != 0.0
    });
    let left: Option<Vec<f64>> = claims.map(|finding| Some(1.0 - reduction(finding)?)).collect();
    match left {
        Some(left) if !left.is_empty() => percent(1.0 - left.iter().product::<f64>()),
        _ => "–".to_owned(),
    }
}

/// Cautions, notes and disturbances, each once with the axes that it holds for.
fn print_remarks(answers: &[Diagnosis], printed: Printed) {
    let options = Diagnose::augment_args(clap::Command::new("diagnose"));
    let of = |remarks: fn(&Diagnosis) -> &Vec<String>| {
        let each = answers.iter().flat_map(move |answer| {
            remarks(answer).iter().map(|remark| (answer.target.as_str(), remark.clone()))
        });
        grouped(each, answers.len())
    };
    for (kind, lines) in [
        ("caution", of(|answer| &answer.cautions)),
        ("note", of(|answer| &answer.notes)),
        ("motion", of(|answer| &answer.moved)),
    ] {
        for line in first(lines, printed.at_most(2 * SHOWN)) {
            print_line!("  {kind}: {}", with_flags(&line, options.get_arguments()));
        }
    }
}

/// Untested effects, with their axes where others tested them, and the source of the noise levels, one line each.
fn print_tests(answers: &[Diagnosis]) {
    let mut needs: BTreeMap<&str, (BTreeSet<&str>, Vec<&str>)> = BTreeMap::new();
    for answer in answers {
        for untested in &answer.untested {
            let (needs, axes) = needs.entry(&untested.effect).or_default();
            needs.extend(untested.needs.iter().map(String::as_str));
            axes.push(&answer.target);
        }
    }
    let mut effects: BTreeMap<BTreeSet<&str>, Vec<String>> = BTreeMap::new();
    for (effect, (needs, axes)) in needs {
        let is_tested = |answer: &Diagnosis| answer.tested.iter().any(|tested| tested == effect);
        let on = match answers.iter().any(is_tested) {
            true => format!(" on {}", axes.join(", ")),
            false => String::new(),
        };
        effects.entry(needs).or_default().push(format!("{effect}{on}"));
    }
    let untested = effects.into_iter().map(|(needs, effects)| {
        let verb = if effects.len() == 1 { "needs" } else { "need" };
        format!("{} ({verb} {})", effects.join(", "), needs.into_iter().collect::<Vec<_>>().join(", "))
    });
    let untested: Vec<String> = untested.collect();
    if !untested.is_empty() {
        print_line!("  not tested: {}", untested.join("; "));
    }
    let noise = answers.iter().map(|answer| {
        let noise = &answer.noise;
        let text = format!(
            "noise estimated from {}; {} blocks of {:.2} s",
            noise.learnt_from, noise.blocks, noise.block_s
        );
        (answer.target.as_str(), text)
    });
    for line in grouped(noise, answers.len()) {
        print_line!("  {line}");
    }
}

fn sizes(finding: &Finding, printed: Printed, with_interval: bool) -> String {
    let size = |size: &Size| {
        let (value, unit) = printed.coefficient(size.value, &size.unit);
        let (half, _) = printed.coefficient(0.5 * (size.interval[1] - size.interval[0]), &size.unit);
        let has_interval = with_interval && size.interval.iter().all(|end| end.is_finite());
        let value = if has_interval { format!("{value} ± {half}") } else { value };
        let value = if unit == "1" { value } else { format!("{value} {unit}") };
        // sizes of one effect in other units
        if finding.band == Band::Stochastic && finding.sizes.len() > 1 {
            format!("{} {value}", size.of)
        } else {
            value
        }
    };
    let sizes = finding.sizes.iter().map(size).collect::<Vec<_>>().join(", ");
    match &finding.sizes[..] {
        [first, second, ..] if second.of == format!("({})²", first.of) => {
            format!("{sizes} (powers of {})", first.of)
        }
        _ => sizes,
    }
}

/// An effect with its size.
fn in_short(finding: &Finding, printed: Printed) -> String {
    format!("{} {}", finding.effect, sizes(finding, printed, false)).trim_end().to_owned()
}

fn row(finding: &Finding, printed: Printed) -> Vec<String> {
    let params: Vec<String> = finding
        .params
        .iter()
        .map(|(name, value)| match finding.params_interval.get(name) {
            Some([low, high]) => format!("{name} {} ({} … {})", three(*value), three(*low), three(*high)),
            None => format!("{name} {}", three(*value)),
        })
        .collect();
    let predicted = match finding.predicted_reduction != 0.0 {
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
        sizes(finding, printed, true),
        params.join(", "),
        predicted,
        finding.measured_reduction.map_or_else(String::new, percent),
    ]
}

/// Doubts, locations of the effect, and indistinguishable effects.
fn evidence(finding: &Finding) -> Vec<String> {
    let effect = &finding.effect;
    let mut lines = Vec::new();
    lines.extend(finding.doubt.as_ref().map(|doubt| format!("{effect}: not conclusive: {doubt}")));
    if let Some([begin, end]) = finding.shows_from_to_s {
        let against =
            finding.shows_against.as_ref().map(|column| format!("against {column}, ")).unwrap_or_default();
        // without the sign of a zero
        let [begin, end] = [begin, end].map(|time_s| (10.0 * time_s).round() / 10.0 + 0.0);
        lines.push(format!("{effect}: shows {against}most from {begin:.1} s to {end:.1} s"));
    }
    lines.extend(finding.separate.iter().map(|separation| {
        format!("{effect}: indistinguishable from {}: {}", separation.effect, separation.experiment)
    }));
    lines
}
