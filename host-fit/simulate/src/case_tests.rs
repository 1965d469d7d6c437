//! Complete cases: every effect, every set-up, and the meaning of sizes.

use super::planting::assess;
use super::rivals::CELL;
use super::strength::{Blocks, Whitener};
use super::*;
use fos_data::case::CaseMeta;
use fos_data::statistics::{mean, variance};

const SHORT: Durations = Durations { reference_s: 60.0, log_s: 600.0, evaluation_s: 300.0 };

fn plan(seed: u64, setup: Setup, target: Axis) -> CasePlan {
    CasePlan { durations: SHORT, ..CasePlan::new(seed, "bmi270", setup, target) }
}

fn column<'a>(log: &'a [(String, Vec<f64>)], name: &str) -> &'a [f64] {
    &log.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no column {name}")).1
}

/// A set-up and axis that show the effect.
fn place(effect: Effect) -> (Setup, Axis) {
    let all = Setup::ALL.iter().flat_map(|setup| [(*setup, Axis::Gy), (*setup, Axis::Ax)]);
    all.into_iter().find(|(setup, axis)| effect.suits(*setup, *axis)).expect("some place shows it")
}

#[test]
fn every_effect_is_planted_at_the_size_asked_for() {
    for effect in Effect::all() {
        let (setup, target) = place(effect);
        let mut plan = plan(5, setup, target);
        plan.planted.push(Plant { effect, parameter: None, size: 30.0 });
        let case = simulate_case(&plan).unwrap_or_else(|error| panic!("{effect}: {error}"));
        let planted = &case.truth.planted[0];
        if planted.band == Band::Slow {
            // computed again from the recorded data
            let still = case.log.iter().find(|(name, _)| name == "still").map(|(_, still)| still);
            let rows = 0..case.truth.log.error.len();
            let usable = if still.is_some() && target.is_gyro() {
                fos_data::recording::runs(rows, |n| still.is_none_or(|still| still[n] > 0.5))
            } else {
                std::iter::once(rows).collect()
            };
            let blocks = Blocks::of(&usable, CELL);
            let lsb = Part::named("bmi270").expect("known").lsb(target);
            let whitener =
                Whitener::new(blocks.covariance(&case.truth.noise, lsb)).expect("positive definite");
            let size = whitener.whiten(&blocks.means(&case.truth.log.error)).norm();
            assert!((size / 30.0 - 1.0).abs() < 0.01, "{effect}: {size}");
        }
        // whole multiples of a step cannot have any size
        let tolerance = if effect == Effect::Quantisation { 0.2 } else { 0.01 };
        assert!((planted.size / 30.0 - 1.0).abs() < tolerance, "{planted:?}");
        for (log, truth) in [(&case.log, &case.truth.log), (&case.evaluation, &case.truth.evaluation)] {
            let rows = log[0].1.len();
            assert!(truth.error.len() == rows && truth.error.iter().all(|x| x.is_finite()), "{effect}");
            assert!(truth.regressors.iter().all(|(_, values)| values.len() == rows), "{effect}");
            assert!(log.iter().all(|(_, values)| values.len() == rows), "{effect}");
            assert!(log.iter().flat_map(|(_, values)| values).all(|x| x.is_finite()), "{effect}");
            if effect != Effect::DroppedSamples {
                assert!(variance(&[&truth.error]) > 0.0, "{effect} does nothing");
            }
        }
        let needed = effect.description().needs.iter();
        assert!(needed.clone().all(|name| case.log.iter().any(|(column, _)| column == name)), "{effect}");
    }
}

#[test]
fn regressors_times_coefficients_are_the_planted_error() {
    let mut plan = plan(11, Setup::PoseRig, Axis::Gz);
    for effect in [Effect::GSensitivity, Effect::ThermalLag] {
        plan.planted.push(Plant { effect, parameter: None, size: 25.0 });
    }
    let case = simulate_case(&plan).expect("it works");
    for truth in [&case.truth.log, &case.truth.evaluation] {
        let weights = case.truth.planted.iter().flat_map(|planted| &planted.coefficients);
        let mut sum = vec![0.0; truth.error.len()];
        for (weight, (_, values)) in weights.zip(&truth.regressors) {
            sum.iter_mut().zip(values).for_each(|(sum, x)| *sum += weight * x);
        }
        let largest = sum.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        assert!(sum.iter().zip(&truth.error).all(|(a, b)| (a - b).abs() < 1e-12 * largest));
    }
    assert_eq!(case.truth.log.regressors.len(), 4);
}

#[test]
fn a_plan_gives_the_same_bits_and_another_seed_others() {
    let mut plan = plan(7, Setup::Desk, Axis::Ay);
    plan.planted.push(Plant { effect: Effect::LoadHeating, parameter: None, size: 20.0 });
    let [first, second] = [0, 1].map(|_| simulate_case(&plan).expect("it works"));
    assert!(
        first.log == second.log
            && first.evaluation == second.evaluation
            && first.reference == second.reference
    );
    let other = simulate_case(&CasePlan { seed: 8, ..plan }).expect("it works");
    assert_ne!(first.log, other.log);
}

#[test]
fn planted_effects_change_only_the_target() {
    let quiet = plan(9, Setup::Bench, Axis::Gx);
    let without = simulate_case(&quiet).expect("it works");
    assert!(without.truth.log.error.iter().chain(&without.truth.evaluation.error).all(|x| *x == 0.0));
    let mut planted = quiet.clone();
    planted.planted.push(Plant { effect: Effect::WarmupExp, parameter: Some(60.0), size: 200.0 });
    let with = simulate_case(&planted).expect("it works");
    assert_eq!(with.reference, without.reference);
    for (log, other) in [(&with.log, &without.log), (&with.evaluation, &without.evaluation)] {
        let differ: Vec<&str> =
            log.iter().zip(other).filter(|(a, b)| a != b).map(|(a, _)| a.0.as_str()).collect();
        assert_eq!(differ, ["gx_rads"]);
    }
    // up to rounding, the difference is the planted error
    let (a, b) = (column(&with.log, "gx_rads"), column(&without.log, "gx_rads"));
    let lsb = with.meta.gyro_lsb_rads.expect("stated");
    for ((a, b), error) in a.iter().zip(b).zip(&with.truth.log.error) {
        assert!((a - b - error).abs() <= 1.0001 * lsb);
    }
}

#[test]
fn generalised_least_squares_scatters_by_one_over_the_size() {
    use super::random::{Stream, random};
    use super::regressors::low_pass;
    let part = Part::named("bmi160").expect("known");
    let noise = part.draw_noise(Axis::Gx, 50.0, &mut random(1, Stream::Unit));
    let n = 20_000;
    let steps: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k / 3000 % 2 == 1))).collect();
    let path = low_pass(&steps, 30.0, noise.period_s);
    // with a gap, as of a rig
    let blocks = Blocks::of(&[0..9000, 9500..n], CELL);
    let whitener = Whitener::new(blocks.covariance(&noise, 0.0)).expect("positive definite");
    let white = whitener.whiten(&blocks.means(&path));
    let estimates: Vec<f64> = (0..300)
        .map(|seed| {
            let series = noise.series(n, &mut random(seed, Stream::Noise(0, 0)));
            whitener.whiten(&blocks.means(&series)).dot(&white) / white.norm_squared()
        })
        .collect();
    let scatter = variance(&[&estimates]).sqrt() * white.norm();
    // 300 estimates: 4 % of scatter of a deviation, three of them
    assert!((scatter - 1.0).abs() < 0.13, "{scatter}");
    assert!(mean(&[&estimates]).abs() * white.norm() < 0.2);
}

#[test]
fn logs_have_the_columns_of_their_set_up() {
    for setup in Setup::ALL {
        let case = simulate_case(&plan(4, setup, Axis::Gx)).expect("it works");
        let names = |log: &[(String, Vec<f64>)]| log.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let fixed = ["t_s", "ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];
        let field = names(&case.log);
        assert_eq!(field[..7], fixed);
        assert_eq!(field, names(&case.evaluation));
        let has = |name: &str| field.iter().any(|column| column == name);
        assert_eq!(has("ref_ax_mps2"), matches!(setup, Setup::PoseRig | Setup::RateTable), "{setup:?}");
        assert_eq!(has("ref_gz_rads"), setup == Setup::RateTable, "{setup:?}");
        assert_eq!(has("still"), setup == Setup::PoseRig, "{setup:?}");
        assert!(!names(&case.reference).iter().any(|name| name.starts_with("ref_") || name == "still"));
        let t = column(&case.log, "t_s");
        assert!(t[0] == 0.0 && t.windows(2).all(|pair| pair[1] > pair[0]));
        assert!((t.len() as f64 / 120_000.0 - 1.0).abs() < 0.016);
        // the measurement is the truth plus bias and noise
        if has("ref_gx_rads") {
            let pairs = column(&case.log, "gx_rads").iter().zip(column(&case.log, "ref_gx_rads"));
            let error: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
            assert!(variance(&[&error]).sqrt() < 2e-3);
        }
    }
}

#[test]
fn the_reference_force_is_gravity_carried_along_by_the_reference_rate() {
    let case = simulate_case(&plan(6, Setup::RateTable, Axis::Gz)).expect("it works");
    let get = |name: &str| column(&case.log, name);
    let force = [get("ref_ax_mps2"), get("ref_ay_mps2"), get("ref_az_mps2")];
    let rate = [get("ref_gx_rads"), get("ref_gy_rads"), get("ref_gz_rads")];
    let dt = 1.0 / case.truth.rate_hz;
    for n in (0..force[0].len() - 1).step_by(997) {
        let f = force.map(|column| column[n]);
        let w = rate.map(|column| column[n]);
        assert!((f.iter().map(|x| x * x).sum::<f64>().sqrt() - 9.80665).abs() < 1e-5);
        // df/dt = −ω × f; to second order in a turn of 1 mrad … 20 mrad a sample
        let turned = [w[1] * f[2] - w[2] * f[1], w[2] * f[0] - w[0] * f[2], w[0] * f[1] - w[1] * f[0]];
        for k in 0..3 {
            let error = force[k][n + 1] - f[k] + dt * turned[k];
            let angle = dt * w.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(error.abs() < 9.9 * angle * angle + 5e-6, "row {n}: {error}");
        }
    }
}

#[test]
fn case_metadata_survives_a_round_trip() {
    let mut plan = plan(2, Setup::Shaker, Axis::Az);
    plan.durations = Durations { reference_s: 60.0, log_s: 200.0, evaluation_s: 60.0 };
    plan.planted.push(Plant { effect: Effect::VibrationRectification, parameter: None, size: 30.0 });
    let case = simulate_case(&plan).expect("it works");
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().join("case_007");
    case.write(&folder).expect("written");
    let text = std::fs::read_to_string(folder.join("meta.json")).expect("there");
    let meta: CaseMeta = serde_json::from_str(&text).expect("JSON");
    assert_eq!(meta, CaseMeta { case: "case_007".to_owned(), ..case.meta.clone() });
    assert!(!text.contains("rectification"));
    let truth = std::fs::read_to_string(folder.join("truth.json")).expect("there");
    assert!(truth.contains("vibration_rectification"));
    let recording =
        fos_data::recording::load(folder.join("log.parquet"), &Default::default()).expect("a log");
    assert_eq!(**recording.channel("az_mps2").expect("there").values, *column(&case.log, "az_mps2"));
    assert_eq!(recording.segments.len(), 1);
}

#[test]
fn rejects_unsuitable_plans_with_the_choices() {
    let refused = |plan: CasePlan| simulate_case(&plan).expect_err("refused").to_string();
    let mut unsuited = plan(1, Setup::Bench, Axis::Gx);
    unsuited.planted.push(Plant { effect: Effect::GSensitivity, parameter: None, size: 30.0 });
    assert!(refused(unsuited.clone()).contains("a gyro in the set-up pose-rig"));
    unsuited.planted[0] = Plant { effect: Effect::TempLinear, parameter: None, size: f64::NAN };
    assert!(refused(unsuited).contains("positive"));
    let unknown = CasePlan { part: "adxl".to_owned(), ..plan(1, Setup::Bench, Axis::Gx) };
    assert!(refused(unknown).contains("icm42688"));
}

#[test]
fn equivalent_rival_leaves_no_remainder() {
    let mut plan = plan(3, Setup::Bench, Axis::Gx);
    plan.path = Path::TemperatureRamp;
    plan.planted.push(Plant { effect: Effect::TempLinear, parameter: None, size: 40.0 });
    let planted = &assess(&plan).expect("it works")[0];
    assert!(planted.left_after_best_rival.expect("slow") < 1e-3 * 40.0, "{planted:?}");
    plan.path = Path::Drawn;
    let planted = &assess(&plan).expect("it works")[0];
    assert!(planted.left_after_best_rival.expect("slow") > 1.0, "{planted:?}");
}
