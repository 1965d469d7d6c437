//! Statistics of populations of random estimates with known truth, without logs.

use fos_fleet::{Estimate, Member, Population, assess, discoveries};
use fos_testkit::is_thorough;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A random fleet: bias and slope of each unit, and an estimate of both with a covariance that differs between units.
struct Drawn {
    truth: Vec<[f64; 2]>,
    estimates: Vec<Estimate>,
    lots: Vec<String>,
}

/// Standard deviations of bias and slope: between units of a lot, between lots, of an estimate.
#[derive(Clone, Copy)]
struct Spread {
    units: [f64; 2],
    lots: [f64; 2],
    errors: [f64; 2],
}

const MEAN: [f64; 2] = [3.0, -0.2];
const SPREAD: Spread = Spread { units: [1.0, 0.1], lots: [0.5, 0.0], errors: [0.3, 0.15] };

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

fn names() -> Vec<String> {
    vec!["bias".to_owned(), "temp_c".to_owned()]
}

/// Correlation of the errors of bias and slope; negative if a log is warmer than the reference temperature.
const CORRELATION: f64 = -0.6;

fn draw(units: usize, a_lot: usize, spread: Spread, seed: u64) -> Drawn {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = Drawn { truth: Vec::new(), estimates: Vec::new(), lots: Vec::new() };
    let mut of_lot = [0.0; 2];
    for unit in 0..units {
        if unit % a_lot == 0 {
            of_lot = spread.lots.map(|spread| spread * normal(&mut random));
        }
        let truth: [f64; 2] =
            std::array::from_fn(|i| MEAN[i] + of_lot[i] + spread.units[i] * normal(&mut random));
        // Logs of units differ in length.
        let length = 0.5 + 1.5 * random.random::<f64>();
        let [bias, slope] = spread.errors.map(|error| error * length);
        let (first, second) = (normal(&mut random), normal(&mut random));
        let off =
            [bias * first, slope * (CORRELATION * first + (1.0 - CORRELATION * CORRELATION).sqrt() * second)];
        let between = CORRELATION * bias * slope;
        drawn.truth.push(truth);
        drawn.estimates.push(Estimate {
            names: names(),
            values: vec![truth[0] + off[0], truth[1] + off[1]],
            covariance: vec![vec![bias * bias, between], vec![between, slope * slope]],
        });
        drawn.lots.push(format!("lot {}", unit / a_lot));
    }
    drawn
}

impl Drawn {
    fn members(&self) -> Vec<Member<'_>> {
        let lots = self.lots.iter().map(|lot| Some(lot.as_str()));
        self.estimates.iter().zip(lots).map(|(estimate, lot)| Member { lot, estimate }).collect()
    }
}

/// With equal errors and equal lots, analysis of variance has a closed form (Searle, Casella and McCulloch 1992, ch. 4).
#[test]
fn balanced_lots_match_analysis_of_variance() {
    let (lots, a_lot, error) = (12, 8, 0.4_f64);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let values: Vec<Vec<f64>> = (0..lots)
        .map(|_| {
            let lot = 1.5 * normal(&mut random);
            (0..a_lot).map(|_| 7.0 + lot + (1.0 + error * error).sqrt() * normal(&mut random)).collect()
        })
        .collect();
    let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let means: Vec<f64> = values.iter().map(|lot| mean_of(lot)).collect();
    let mean = mean_of(&means);
    let within: f64 = values
        .iter()
        .zip(&means)
        .flat_map(|(lot, mean)| lot.iter().map(move |value| (value - mean).powi(2)))
        .sum::<f64>()
        / (lots * (a_lot - 1)) as f64;
    let between =
        means.iter().map(|lot| (lot - mean).powi(2)).sum::<f64>() * a_lot as f64 / (lots - 1) as f64;

    let estimates: Vec<Estimate> = values
        .iter()
        .flatten()
        .map(|value| Estimate {
            names: vec!["bias".to_owned()],
            values: vec![*value],
            covariance: vec![vec![error * error]],
        })
        .collect();
    let names_of_lots: Vec<String> = (0..lots).map(|lot| lot.to_string()).collect();
    let members: Vec<Member<'_>> = estimates
        .iter()
        .enumerate()
        .map(|(index, estimate)| Member { lot: Some(&names_of_lots[index / a_lot]), estimate })
        .collect();
    let population = Population::of(&members, &["bias".to_owned()]).unwrap();
    let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-3;
    assert!(close(population.mean[0], mean), "{} {mean}", population.mean[0]);
    let units = within - error * error;
    assert!(close(population.between_units[0][0], units), "{} {units}", population.between_units[0][0]);
    let of_lots = (between - within) / a_lot as f64;
    assert!(close(population.between_lots[0][0], of_lots), "{} {of_lots}", population.between_lots[0][0]);
    let of_mean = between / (lots * a_lot) as f64;
    assert!(
        close(population.mean_covariance[0][0], of_mean),
        "{} {of_mean}",
        population.mean_covariance[0][0]
    );
}

/// 90 % intervals hold in about that many fleets: the 99.9 % range of the binomial is 45 to 60 of 60, and 5 to 10 of 10.
#[test]
fn mean_and_scatter_intervals_have_stated_coverage() {
    let (fleets, fewest) = if is_thorough() { (60, 45) } else { (10, 5) };
    let (mut mean, mut units, mut lots) = (0, 0, 0);
    for seed in 0..fleets {
        let drawn = draw(120, 10, SPREAD, seed);
        let population = Population::of(&drawn.members(), &names()).unwrap();
        let error = population.mean_covariance[0][0].sqrt();
        mean += u64::from((population.mean[0] - MEAN[0]).abs() < 1.645 * error);
        let [low, high] = population.scatter[0].units_interval;
        units += u64::from(low < SPREAD.units[0] && SPREAD.units[0] < high);
        let [low, high] = population.scatter[0].lots_interval;
        lots += u64::from(low < SPREAD.lots[0] && SPREAD.lots[0] < high);
    }
    println!(
        "of {fleets} fleets the interval of the mean holds in {mean}, of units in {units}, of lots in {lots}"
    );
    for held in [mean, units, lots] {
        assert!((fewest..=fleets).contains(&held), "{mean} {units} {lots}");
    }
}

/// An estimate combined with the population is nearer to the truth than that of the log alone, and its intervals hold.
#[test]
fn shrunk_estimate_is_closer_with_stated_coverage() {
    let (mut held, mut n, mut alone, mut together) = ([0_u32; 2], 0, [0.0; 2], [0.0; 2]);
    let (fleets, within) = if is_thorough() { (20, 339..=381) } else { (3, 44..=60) };
    for seed in 0..fleets {
        let drawn = draw(220, 11, SPREAD, 100 + seed);
        // One unit of each lot is new to the population.
        let is_new = |index: usize| index % 11 == 10;
        let members: Vec<Member<'_>> = drawn
            .members()
            .into_iter()
            .enumerate()
            .filter(|(index, _)| !is_new(*index))
            .map(|(_, m)| m)
            .collect();
        let population = Population::of(&members, &names()).unwrap();
        for index in (0..drawn.truth.len()).filter(|index| is_new(*index)) {
            let shrunk = population.shrunk(&drawn.estimates[index], Some(&drawn.lots[index]));
            n += 1;
            for i in 0..2 {
                let off = shrunk.values[i] - drawn.truth[index][i];
                held[i] += u32::from(off.abs() < 1.645 * shrunk.covariance[i][i].sqrt());
                together[i] += off * off;
                alone[i] += (drawn.estimates[index].values[i] - drawn.truth[index][i]).powi(2);
            }
        }
    }
    println!(
        "{n} units: intervals of 90 % hold in {held:?}; squared error alone {alone:?}, with the population {together:?}"
    );
    // 99.9 % range of the binomial for 400 or 60 units.
    assert!(held.iter().all(|held| within.contains(held)), "{held:?}");
    assert!(together[0] < 0.95 * alone[0] && together[1] < 0.5 * alone[1], "{alone:?} {together:?}");
}

#[test]
fn lot_test_has_stated_false_positive_rate() {
    let without = Spread { lots: [0.0; 2], ..SPREAD };
    let (alike, most, apart, fewest) = if is_thorough() { (60, 9, 20, 14) } else { (10, 4, 5, 3) };
    let false_alarms = (0..alike)
        .filter(|seed| {
            let drawn = draw(100, 10, without, 200 + seed);
            Population::of(&drawn.members(), &names()).unwrap().scatter[0].lots_alike.unwrap() < 0.05
        })
        .count();
    // 5 % of 60 are 3; the 99.9 % range of the binomial ends at 9, and for 10 at 4.
    assert!(false_alarms <= most, "{false_alarms} of {alike}");
    let found = (0..apart)
        .filter(|seed| {
            let drawn = draw(100, 10, SPREAD, 300 + seed);
            Population::of(&drawn.members(), &names()).unwrap().scatter[0].lots_alike.unwrap() < 0.05
        })
        .count();
    println!(
        "lots apart in {false_alarms} of {alike} fleets whose lots are alike, and in {found} of {apart} whose lots are not"
    );
    assert!(found >= fewest, "{found} of {apart}");
}

/// With 0, 1 and 5 % of the units 8 standard deviations off in one coefficient, at most a tenth of those reported as odd may be false
/// positives.
#[test]
fn odd_units_are_found_at_stated_false_discovery_rate() {
    const RATE: f64 = 0.1;
    let fleets = if is_thorough() { 20 } else { 3 };
    for share in [0.0, 0.01, 0.05] {
        let (mut called, mut wrong, mut planted, mut fleets_with_a_wrong_one) = (0, 0, 0, 0);
        for seed in 0..fleets {
            let mut drawn = draw(300, 30, SPREAD, 400 + seed);
            let odd = (share * 300.0) as usize;
            let is_odd =
                |index: usize| index % 37 == 5 && index / 37 < odd || index >= 300 - odd.saturating_sub(8);
            for index in (0..300).filter(|index| is_odd(*index)) {
                let estimate = &mut drawn.estimates[index];
                let i = index % 2;
                // Standard deviation of unit and log error.
                let deviation =
                    (SPREAD.units[i].powi(2) + SPREAD.lots[i].powi(2) + estimate.covariance[i][i]).sqrt();
                estimate.values[i] += 8.0 * deviation;
                planted += 1;
            }
            let assessment = assess(&drawn.members(), &names()).unwrap();
            let p_values: Vec<f64> = assessment.distances.iter().map(|distance| distance.p_value).collect();
            let found = discoveries(&p_values, RATE);
            let wrong_here = (0..300).filter(|index| found[*index] && !is_odd(*index)).count();
            wrong += wrong_here;
            fleets_with_a_wrong_one += u32::from(wrong_here > 0);
            called += found.iter().filter(|found| **found).count();
            for index in (0..300).filter(|index| found[*index] && is_odd(*index)) {
                assert_eq!(assessment.distances[index].most, names()[index % 2], "by what it is odd");
            }
        }
        println!(
            "{share}: {planted} planted, {called} called odd, {wrong} of them sound; in {fleets_with_a_wrong_one} of {fleets} fleets one at least"
        );
        if share == 0.0 {
            // Every report is a false positive, so the rate is that of fleets with any report.
            let most = if is_thorough() { 6 } else { 2 };
            assert!(fleets_with_a_wrong_one <= most, "{fleets_with_a_wrong_one} of {fleets}");
        } else {
            assert!((wrong as f64) < 2.0 * RATE * f64::from(called as u32), "{wrong} of {called}");
            assert!(called - wrong >= planted * 9 / 10, "{called} {wrong} {planted}");
        }
    }
}

/// A log at constant temperature does not identify a slope: it counts for the bias, and its slope comes from the population.
#[test]
fn unidentifiable_coefficients_come_from_the_population() {
    let mut drawn = draw(60, 60, SPREAD, 9);
    let whole = Population::of(&drawn.members(), &names()).unwrap();
    for estimate in drawn.estimates.iter_mut().skip(50) {
        estimate.names.truncate(1);
        estimate.values.truncate(1);
        estimate.covariance = vec![vec![estimate.covariance[0][0]]];
    }
    let population = Population::of(&drawn.members(), &names()).unwrap();
    assert!(
        (population.mean[0] - whole.mean[0]).abs() < 0.2 && (population.mean[1] - whole.mean[1]).abs() < 0.05
    );
    let shrunk = population.shrunk(&drawn.estimates[55], None);
    assert_eq!(shrunk.names, names());
    let expected = population.mean[1];
    assert!((shrunk.values[1] - expected).abs() < 3.0 * population.scatter[1].units, "{shrunk:?}");
    assert!(shrunk.covariance[1][1].sqrt() > 0.9 * population.scatter[1].units);
    assert_eq!(drawn.estimates[55].place("temp_c"), None);

    // The order of lots and of their units changes only the last bits.
    let mut turned = drawn.members();
    turned.reverse();
    let other = Population::of(&turned, &names()).unwrap();
    assert!((other.mean[0] - population.mean[0]).abs() < 1e-6);
    assert_eq!(
        Population::of(&drawn.members(), &names()).unwrap(),
        population,
        "the same members, the same bits"
    );
}
