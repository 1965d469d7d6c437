//! A short calibration made long: what a unit's own minutes leave of its error, alone and beside its population.
//!
//! ```text
//! cargo run --release -p host-fit --example minutes [UNITS [SEED [SVG]]]
//! ```
//!
//! Units of a simulated part: bias and slope of a gyro's temperature drawn, lots apart, white noise, flicker and random walk of a phone-class part,
//! the room warming by 4 K and back in half an hour; once calibrated from power-on, while the die warms by 3 K, and once when it is warm. A fifth of the units is measured for half an hour each and makes the population; the others are
//! calibrated in their first minutes, alone and with it. What is left is measured against the truth at 10 to 45 °C: root mean square, with the
//! 90 % interval of that over the units. With a third argument the table is drawn there, too.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::statistics::median_of;
use fos_figures::{Axis, Figure, Ink, Panel, Series, Shape, write_svg};
use fos_fit::noise::NoiseLevels;
use fos_fleet::{AxisEstimate, BIAS, Estimate, Member, Population, estimate};
use fos_simulate::{Simulation, simulate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Minutes of a calibration; the last is that of the units that make the population.
const MINUTES: [f64; 5] = [1.0, 3.0, 6.0, 12.0, 30.0];

/// By how much the die warms after power-on, K: from power-on, and when it is warm already.
const WARMING_K: [f64; 2] = [3.0, 0.05];

const RATE_HZ: f64 = 100.0;

/// Standard deviations: bias between units and between lots, rad/s; the same of the slope, rad/s/K. 0.25 dps and 0.012 dps/K between units.
const BIASES: [f64; 2] = [4.4e-3, 1.5e-3];
const SLOPES: [f64; 2] = [2.1e-4, 0.7e-4];

const A_LOT: usize = 50;

struct Unit {
    lot: String,
    truth: [f64; 2],
    /// After each of the [`MINUTES`]: by itself, and with the noise of the part.
    alone: Vec<AxisEstimate>,
    with_noise: Vec<AxisEstimate>,
}

fn main() {
    let argument = |place: usize, otherwise: u64| -> u64 {
        std::env::args().nth(place).map_or(Ok(otherwise), |text| text.parse()).expect("a number")
    };
    let (n, seed) = (argument(1, 500) as usize, argument(2, 1));
    // every fifth, of all lots
    let (learnt, others): (Vec<usize>, Vec<usize>) = (0..n).partition(|index| index % 5 == 0);
    let learnt: Vec<Unit> =
        learnt.into_par_iter().map(|unit| measured(unit, seed, WARMING_K[0], None)).collect();
    let long = || learnt.iter().filter_map(|unit| unit.alone.last());
    let names = vec![BIAS.to_owned(), "temp_c".to_owned()];
    let members: Vec<Member<'_>> = learnt
        .iter()
        .zip(long())
        .map(|(unit, long)| Member { lot: Some(&unit.lot), estimate: &long.coefficients })
        .collect();
    let population = Population::of(&members, &names).expect("a population");
    let median =
        |level: fn(&NoiseLevels) -> f64| median_of(long().map(|long| level(&long.noise))).expect("units");
    let noise = NoiseLevels {
        white: median(|noise| noise.white),
        flicker: median(|noise| noise.flicker),
        walk: median(|noise| noise.walk),
        gauss_markov: None,
    };
    println!(
        "{n} units in lots of {A_LOT}, {} of them measured for {} min each: the population",
        members.len(),
        MINUTES[4]
    );
    for (name, scatter) in population.names.iter().zip(&population.scatter) {
        let [low, high] = scatter.units_interval;
        println!(
            "  {name}: between units {:.2e} ({low:.2e} to {high:.2e}), between lots {:.2e}, error of a log {:.2e}",
            scatter.units, scatter.lots, scatter.measurement
        );
    }
    let mut panels = Vec::new();
    for (warming_k, of) in WARMING_K.into_iter().zip(["from power-on", "warm already"]) {
        println!("\n{of}:");
        let others: Vec<Unit> =
            others.par_iter().map(|unit| measured(*unit, seed, warming_k, Some(&noise))).collect();
        panels.push(panel(of, compare(&others, &population)));
    }
    if let Some(path) = std::env::args().nth(3) {
        let title = "What minutes of calibration leave of the error at 10 to 45 °C".to_owned();
        write_svg(&Figure { title, panels }, path.as_ref()).expect("a picture");
    }
}

/// Minutes of calibration; remaining error and its interval, mdps.
type Left = Vec<(f64, f64, f64, f64)>;

fn panel(title: &str, [alone, with]: [Left; 2]) -> Panel {
    let series = |label: &str, ink, left| Series::new(label, ink, Shape::Bars(left));
    let series = [
        series("a unit's own log", Ink::Measured, alone),
        series("with the population", Ink::Predicted, with),
    ];
    let y = Axis::log("Root mean square over units, with its 90 % interval (mdps)");
    Panel::new(Axis::log("Minutes of calibration (min)"), y, series).titled(title)
}

/// Prints a line for each length of calibration. Returns the remaining errors alone, and with the population.
fn compare(others: &[Unit], population: &Population) -> [Left; 2] {
    let mut left_behind = [Left::new(), Left::new()];
    println!(
        "\n| minutes | left alone, mdps | with the population | intervals of 90 % that hold, of bias and slope: alone | with the population |"
    );
    println!("|---|---|---|---|---|");
    for (place, minutes) in MINUTES.iter().enumerate() {
        let alone: Vec<Estimate> = others.iter().map(|unit| unit.alone[place].coefficients.clone()).collect();
        let shrunk = |unit: &Unit| population.shrunk(&unit.with_noise[place].coefficients, Some(&unit.lot));
        let with: Vec<Estimate> = others.iter().map(shrunk).collect();
        let left_of = |estimates: &[Estimate]| -> Vec<f64> {
            estimates.iter().zip(others).map(|(estimate, unit)| left(estimate, unit)).collect()
        };
        let left = [&alone, &with].map(|estimates| root_mean(&left_of(estimates)));
        for (kept, [mean, low, high]) in left_behind.iter_mut().zip(left) {
            kept.push((*minutes, mean, low, high));
        }
        let [alone_left, with_left] =
            left.map(|[mean, low, high]| format!("{mean:.1} ({low:.1} to {high:.1})"));
        println!(
            "| {minutes} | {alone_left} | {with_left} | {} | {} |",
            held(&alone, others),
            held(&with, others)
        );
    }
    left_behind
}

/// Shares of units whose 90 % intervals of bias and slope contain the true value.
fn held(estimates: &[Estimate], units: &[Unit]) -> String {
    let shares = [0, 1].map(|i| {
        let holds = |(estimate, unit): &(&Estimate, &Unit)| {
            (estimate.values[i] - unit.truth[i]).abs() < 1.645 * estimate.covariance[i][i].sqrt()
        };
        let held = estimates.iter().zip(units).filter(holds).count();
        format!("{:.0} %", 100.0 * held as f64 / units.len() as f64)
    });
    shares.join(", ")
}

/// Bias of every simulated unit, rad/s: 0.5 dps.
const BIAS_OF_ALL: f64 = 0.5 * std::f64::consts::PI / 180.0;

fn measured(index: usize, seed: u64, warming_k: f64, noise: Option<&NoiseLevels>) -> Unit {
    let lot = index / A_LOT;
    let draws = |stream: u64| -> [f64; 2] {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        [StandardNormal.sample(&mut random), StandardNormal.sample(&mut random)]
    };
    let (own, of_lot) = (draws(2 * index as u64), draws(2 * lot as u64 + 1));
    let [bias, slope] = [0, 1].map(|i| {
        let [units, lots] = [BIASES, SLOPES][i];
        units * own[i] + lots * of_lot[i]
    });
    let simulation = Simulation {
        duration_s: 60.0 * MINUTES[4],
        rate_hz: RATE_HZ,
        seed: seed.wrapping_mul(1_000_003).wrapping_add(index as u64),
        temperature: 0.0,
        motion: false,
    };
    let mut columns = simulate(&simulation).columns;
    let mut column = |name: &str| {
        let found = columns.iter_mut().find(|(found, _)| found == name);
        std::mem::take(&mut found.expect("a column").1)
    };
    let (time, mut gx) = (column("t_s"), column("gx_rads"));
    let room = |t_s: f64| 2.0 - 2.0 * (std::f64::consts::TAU * t_s / 1800.0).cos();
    let temperature: Vec<f64> =
        time.iter().map(|t_s| 24.0 + warming_k * (1.0 - (-t_s / 150.0).exp()) + room(*t_s)).collect();
    gx.iter_mut().zip(&temperature).for_each(|(gx, t)| *gx += bias + slope * (t - 25.0));
    let columns =
        vec![("t_s".to_owned(), time), ("gx_rads".to_owned(), gx), ("temp_c".to_owned(), temperature)];
    let options = LoadOptions::default();
    let whole = Recording::from_columns(Source::made_by("a simulation"), columns, &options).expect("a log");
    let after = |noise: Option<&NoiseLevels>| -> Vec<AxisEstimate> {
        let after = |minutes: &f64| {
            let rows = (minutes * 60.0 * whole.rate.true_hz) as usize;
            estimate(&whole.first_rows(rows), "gx_rads", &["temp_c".to_owned()], noise).expect("an estimate")
        };
        MINUTES.iter().map(after).collect()
    };
    let with_noise = if noise.is_some() { after(noise) } else { Vec::new() };
    Unit { lot: format!("lot {lot}"), truth: [BIAS_OF_ALL + bias, slope], alone: after(None), with_noise }
}

/// Mean square of what the estimate leaves at 10 to 45 °C, (mdps)².
fn left(estimate: &Estimate, unit: &Unit) -> f64 {
    let mdps = 180.0 / std::f64::consts::PI * 1e3;
    let [bias, slope] = [0, 1].map(|i| (estimate.values[i] - unit.truth[i]) * mdps);
    let temperatures = (10..=45).map(|t| f64::from(t) - 25.0);
    temperatures.clone().map(|t| (bias + slope * t).powi(2)).sum::<f64>() / temperatures.count() as f64
}

/// Root mean square, and the ends of its 90 % interval.
fn root_mean(squares: &[f64]) -> [f64; 3] {
    let n = squares.len() as f64;
    let mean = squares.iter().sum::<f64>() / n;
    let error = (squares.iter().map(|square| (square - mean).powi(2)).sum::<f64>() / n / n).sqrt();
    [mean, mean - 1.645 * error, mean + 1.645 * error].map(|square| square.max(0.0).sqrt())
}
