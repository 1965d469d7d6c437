//! Diagnoses a log with a hidden effect: `cargo run -p fos-diagnose --example what_is_missing`.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_diagnose::case::question_of_logs;
use fos_diagnose::detect::{Verdict, diagnose};
use fos_diagnose::effects::Library;
use fos_simulate::{Axis, CasePlan, Effect, Plant, Setup, simulate_case};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut plan = CasePlan::new(3, "bmi270", Setup::Bench, Axis::Gx);
    let effect = Effect::named("temp_linear").ok_or("no such effect")?;
    plan.planted.push(Plant { effect, parameter: None, size: 60.0 });
    let case = simulate_case(&plan)?;
    let log =
        |columns| Recording::from_columns(Source::made_by("a simulation"), columns, &LoadOptions::default());
    let (field, reference, later) = (log(case.field)?, log(case.baseline)?, log(case.eval)?);

    let library = Library::built_in();
    let answer = diagnose(&question_of_logs(&case.meta, &field, Some(&reference), Some(&later), &library))?;
    println!("{}", answer.sentence);
    for finding in &answer.findings {
        let [low, high] = finding.predicted_reduction_interval.map(|share| 100.0 * share);
        println!(
            "  {}: score {:.0}, the error should fall by {low:.1} to {high:.1} %",
            finding.effect,
            finding.score.unwrap_or(f64::NAN)
        );
    }
    assert_eq!((answer.verdict, answer.findings[0].effect.as_str()), (Verdict::Missing, "temp_linear"));
    Ok(())
}
