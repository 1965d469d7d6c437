//! Missing cells at the edges of a log change no diagnosis, and no hypothesis is dropped silently.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_diagnose::case::question_of_logs;
use fos_diagnose::detect::{Diagnosis, diagnose};
use fos_diagnose::effects::{Detector, Library};
use fos_simulate::{Axis, CasePlan, Durations, Effect, Plant, Setup, SimulatedCase, simulate_case};
use fos_testkit::is_thorough;

const NAN: f64 = f64::NAN;

/// Channels with a lower rate than the inertial ones in most logs.
const SLOW: [&str; 6] = ["temp_c", "supply_v", "load_pct", "mag_x_ut", "mag_y_ut", "mag_z_ut"];

fn case(effect: &str, setup: Setup, seed: u64) -> SimulatedCase {
    let effect = Effect::named(effect).expect("an effect");
    let mut plan = CasePlan::new(seed, fos_simulate::PARTS[0].name, setup, Axis::Gx);
    plan.planted = vec![Plant { effect, parameter: None, size: 80.0 }];
    plan.durations = Durations { reference_s: 200.0, log_s: 600.0, evaluation_s: 60.0 };
    simulate_case(&plan).expect("a case")
}

type Columns = Vec<(String, Vec<f64>)>;

/// The log to explain with its slow channels changed.
fn changed(case: &SimulatedCase, change: impl Fn(usize, f64) -> f64) -> Columns {
    let of_column = |(name, values): &(String, Vec<f64>)| {
        let is_slow = SLOW.contains(&name.as_str());
        let change = |(row, value): (usize, &f64)| if is_slow { change(row, *value) } else { *value };
        (name.clone(), values.iter().enumerate().map(change).collect())
    };
    case.log.iter().map(of_column).collect()
}

fn diagnosed(case: &SimulatedCase, field: Columns) -> Diagnosis {
    let options = LoadOptions { rate_hz: Some(case.meta.nominal_rate_hz), ..LoadOptions::default() };
    let recording =
        |columns| Recording::from_columns(Source::made_by("test"), columns, &options).expect("a recording");
    let (field, reference) = (recording(field), recording(case.reference.clone()));
    let library = Library::built_in();
    let answer = diagnose(&question_of_logs(&case.meta, &field, Some(&reference), None, &library))
        .expect("a diagnosis");

    // every slow effect that can act on this axis is listed
    let stands = |id: &String| {
        answer.findings.iter().any(|finding| finding.effect == *id)
            || answer.rejected.iter().any(|rejected| rejected.effect == *id)
            || answer.untested.iter().any(|untested| untested.effect == *id)
    };
    for effect in library.effects() {
        let is_slow = matches!(effect.search, Detector::Terms | Detector::Step);
        assert!(
            !is_slow || !effect.strikes(&case.meta.target) || stands(&effect.id),
            "{} is lost",
            effect.id
        );
    }
    answer
}

/// Effects found, with their sizes.
fn found(answer: &Diagnosis) -> Vec<(String, Vec<f64>)> {
    let sizes =
        |finding: &fos_diagnose::detect::Finding| finding.sizes.iter().map(|size| size.value).collect();
    answer.findings.iter().map(|finding| (finding.effect.clone(), sizes(finding))).collect()
}

/// Returns true if two diagnoses find the same effects with sizes within 1 %: a few cells have little influence.
fn alike(one: &Diagnosis, other: &Diagnosis) -> bool {
    let (one, other) = (found(one), found(other));
    let sizes = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.01 * b.abs());
    one.len() == other.len() && one.iter().zip(&other).all(|(a, b)| a.0 == b.0 && sizes(&a.1, &b.1))
}

/// A log merged from fast and slow channels begins with empty cells. A lag and a backlash used to start at 0 °C there,
/// and effects without a memory were dropped silently: a thermal hysteresis was reported for a plain temperature
/// coefficient.
#[test]
fn empty_cells_at_the_edges_change_no_diagnosis() {
    let mut cases = vec![("thermal_lag", Setup::Desk, 3)];
    if is_thorough() {
        cases.extend([
            ("temp_linear", Setup::Bench, 1),
            ("temp_poly", Setup::Bench, 2),
            ("supply_sensitivity", Setup::Desk, 2),
            ("mag_sensitivity", Setup::PoseRig, 5),
        ]);
    }
    let cases: Vec<_> = cases.into_iter().map(|(effect, setup, seed)| case(effect, setup, seed)).collect();
    let (mut same, mut control) = (0, 0);
    for case in &cases {
        let rows = case.log[0].1.len();
        let whole = diagnosed(case, case.log.clone());
        assert!(!whole.findings.is_empty(), "{}", whole.sentence);
        for lead in [1, 150] {
            let cut = diagnosed(
                case,
                changed(case, |row, value| if row < lead || row == rows - 1 { NAN } else { value }),
            );
            assert!(alike(&cut, &whole), "{lead}: {} for {}", cut.sentence, whole.sentence);
            same += 1;
        }
        // close to 0 °C, the former substitute for an empty cell; exactly 0 °C alone is recognised as a failed read
        let zero = diagnosed(case, changed(case, |row, value| if row == 0 { 0.1 } else { value }));
        control += usize::from(!alike(&zero, &whole));

        // once a second, not from the begin on; a field that turns with the device cannot be held for a second
        if whole.findings[0].effect == "mag_sensitivity" {
            continue;
        }
        let slow = diagnosed(case, changed(case, |row, value| if row % 200 == 77 { value } else { NAN }));
        assert!(
            found(&slow).first().map(|f| &f.0) == found(&whole).first().map(|f| &f.0),
            "{} for {}",
            slow.sentence,
            whole.sentence
        );
        same += 1;
    }
    assert!(control > 0, "numbers near zero in the first cells are seen");
    println!(
        "attack: missing cells, diagnosis | {same} logs of {} cases, with the first and last cells of every slow channel empty, or with one value per second: the reported effects are those of the complete log; every slow effect of the library is found, rejected with its score, or listed as not tested | negative control: 0.1 in the first cells, about the value once assumed for empty ones, is detected in {control} of {} cases",
        cases.len(),
        cases.len()
    );
}

#[test]
fn lists_unusable_channels_as_not_tested() {
    let case = case("temp_linear", Setup::Bench, 1);
    let rows = case.log[0].1.len();
    for (why, change) in [
        (
            "empty for the first",
            &(|row, value| if row < rows / 2 { NAN } else { value }) as &dyn Fn(usize, f64) -> f64,
        ),
        ("every cell is empty", &|_, _| NAN),
        ("never changes", &|_, _| 25.0),
    ] {
        let answer = diagnosed(&case, changed(&case, change));
        for effect in ["temp_linear", "thermal_lag", "thermal_hysteresis", "temp_rate"] {
            let untested = answer.untested.iter().find(|untested| untested.effect == effect);
            let needs = &untested.expect(effect).needs;
            assert!(
                needs.iter().any(|need| need.contains("temp_c") && need.contains(why)),
                "{effect}: {needs:?}"
            );
        }
    }
}
