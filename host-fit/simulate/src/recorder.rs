//! Recording of a world: noise, rounding, clipping, timestamps, slow columns, faults of the data.

use super::axis::Axis;
use super::coloured::AxisNoise;
use super::disturbance::{Character, Motion};
use super::part::Part;
use super::random::{Random, Stream, normal, random};
use super::regressors::NamedSeries;
use super::world::World;
use fos_data::column::Column;

/// The device behind the logs.
#[derive(Debug, Clone)]
pub(super) struct Unit {
    pub(super) part: Part,
    pub(super) noise: [AxisNoise; 6],
    pub(super) bias: [f64; 6],
    /// Deviations of its noise from coloured normal noise.
    pub(super) character: Option<Character>,
}

impl Unit {
    fn with_character(&self, noise: Vec<f64>, random: &mut Random) -> Vec<f64> {
        match &self.character {
            Some(character) => character.apply(&noise, random),
            None => noise,
        }
    }
}

/// Optional columns of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Logged {
    pub(super) temp: bool,
    pub(super) supply: bool,
    pub(super) load: bool,
    pub(super) mag: bool,
}

impl Logged {
    pub(super) fn names(&self) -> Vec<&'static str> {
        let all = [
            (self.temp, &["temp_c"][..]),
            (self.supply, &["supply_v"]),
            (self.load, &["load_pct"]),
            (self.mag, &["mag_x_ut", "mag_y_ut", "mag_z_ut"]),
        ];
        all.into_iter().filter(|(there, _)| *there).flat_map(|(_, names)| names.iter().copied()).collect()
    }
}

/// Faults in the data of the target.
#[derive(Debug, Clone, Default)]
pub(super) struct Faults {
    /// Clipping limit ±, unit of the axis.
    pub(super) limit: Option<f64>,
    /// Quantisation step in LSB.
    pub(super) step: Option<f64>,
    /// Bias of the target, and half of the width of the dead zone about it, unit of the axis.
    pub(super) dead_zone: Option<[f64; 2]>,
    /// Lost samples, in order.
    pub(super) lost: Vec<usize>,
}

/// Target before clipping and rounding: truth, bias, noise and planted error.
pub(super) fn analog(
    unit: &Unit,
    world: &World,
    motion: &Motion,
    target: Axis,
    planted: &[f64],
    (seed, log): (u64, u64),
) -> Vec<f64> {
    let axis = target as usize;
    let random = &mut random(seed, Stream::Noise(log, axis as u64));
    let noise = unit.noise[axis].series(world.len(), random);
    let noise = unit.with_character(noise, random);
    let truth = world.truth(target);
    let seen = |n: usize| truth[n] + motion.at(axis, n) + unit.bias[axis] + noise[n] + planted[n];
    (0..world.len()).map(seen).collect()
}

/// Clips and rounds as the part does, including `faults`.
pub(super) fn convert(part: &Part, axis: Axis, faults: &Faults, value: f64) -> f64 {
    let full_scale = part.full_scale(axis);
    let limit = faults.limit.unwrap_or(full_scale);
    let step = part.lsb(axis) * faults.step.unwrap_or(1.0);
    let top = full_scale - part.lsb(axis);
    let value = match faults.dead_zone {
        Some([bias, half_width]) if (value - bias).abs() < half_width => bias,
        _ => value,
    };
    ((value.clamp(-limit, limit) / step).round() * step).clamp(-full_scale, top)
}

/// Columns of a log, given the analog values of the target.
pub(super) fn record(
    unit: &Unit,
    (world, motion): (&World, &Motion),
    (target, analog): (Axis, &[f64]),
    (logged, faults): (&Logged, &Faults),
    (seed, log): (u64, u64),
) -> Vec<NamedSeries> {
    let n = world.len();
    let period_s = world.period_s;
    let mut columns: Vec<NamedSeries> = Vec::new();
    let mut add = |name: &str, values: Vec<f64>| columns.push((name.to_owned(), values));
    let recorder = &mut random(seed, Stream::Recorder(log));
    let rounded = |value: f64, step: f64| (value / step).round() * step;
    let micro = |t: f64| (t * 1e6).round() / 1e6;
    // timestamps with a jitter of 0.3 % of a period, the first at zero
    add(
        "t_s",
        (0..n)
            .map(|k| {
                micro(k as f64 * period_s + if k == 0 { 0.0 } else { 0.003 * period_s * normal(recorder) })
            })
            .collect(),
    );
    for axis in Axis::ALL {
        if axis == target {
            add(axis.column(), analog.iter().map(|x| convert(&unit.part, axis, faults, *x)).collect());
            continue;
        }
        let index = axis as usize;
        let random = &mut random(seed, Stream::Noise(log, index as u64));
        let noise = unit.noise[index].plain_series(n, random);
        let noise = unit.with_character(noise, random);
        let fine = Faults::default();
        let truth = world.truth(axis);
        let seen = |k: usize| truth[k] + motion.at(index, k) + unit.bias[index] + noise[k];
        let value = |k: usize| convert(&unit.part, axis, &fine, seen(k));
        add(axis.column(), (0..n).map(value).collect());
    }
    let hold = (0.1 / period_s).round() as usize;
    let mut held = |values: &[f64], deviation: f64, step: f64| -> Vec<f64> {
        let mut last = 0.0;
        let read = |(k, value): (usize, &f64)| {
            if k % hold == 0 {
                last = rounded(value + deviation * normal(recorder), step);
            }
            last
        };
        values.iter().enumerate().map(read).collect()
    };
    let temp = held(&world.temp_c, 0.03, 1.0 / 512.0);
    let load: Vec<f64> = held(&world.load_pct, 0.6, 0.1).into_iter().map(|x| x.clamp(0.0, 100.0)).collect();
    if logged.temp {
        add("temp_c", temp);
    }
    let supply = world.supply_v.iter().map(|v| rounded(v + 4e-4 * normal(recorder), 1e-4)).collect();
    if logged.supply {
        add("supply_v", supply);
    }
    if logged.load {
        add("load_pct", load);
    }
    if logged.mag {
        for (name, field) in ["mag_x_ut", "mag_y_ut", "mag_z_ut"].iter().zip(&world.field_ut) {
            add(name, field.iter().map(|b| rounded(b + 0.35 * normal(recorder), 0.01)).collect());
        }
    }
    for axis in Axis::ALL.into_iter().filter(|axis| world.has_reference(*axis)) {
        add(
            &Column::named(axis.column()).reference(),
            world.truth(axis).iter().map(|x| rounded(*x, 1e-6)).collect(),
        );
    }
    if let Some(still) = &world.still {
        add("still", still.iter().map(|still| f64::from(u8::from(*still))).collect());
    }
    for (_, values) in &mut columns {
        drop_lost(values, &faults.lost);
    }
    columns
}

/// Removes the lost samples.
pub(super) fn drop_lost(values: &mut Vec<f64>, lost: &[usize]) {
    let mut lost = lost.iter().copied().peekable();
    let mut row = 0;
    values.retain(|_| {
        let gone = lost.next_if_eq(&row).is_some();
        row += 1;
        !gone
    });
}
