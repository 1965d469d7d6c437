//! A log at rest, and the faults that can occur in it.

use std::ops::Range;

use fos_embedded::raw::RawSample;

use crate::models::{AT_REST, OFFSET, Random, SCALES, SPREAD};

/// One instant, as it reaches a corrector.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tick {
    /// Index of the instant in the clean log that it is compared with.
    pub(crate) index: usize,
    pub(crate) axes: [f32; 6],
    /// Temperature, °C.
    pub(crate) temperature: f32,
    /// Supply voltage measured by the application, V.
    pub(crate) supply: f32,
    /// Ticks without a sample before this one.
    pub(crate) skipped: u32,
    /// The corrector is reset to power-on before this tick.
    pub(crate) reset: bool,
    pub(crate) clock_us: u64,
    /// The device moves.
    pub(crate) moving: bool,
}

/// Period of the temperature, which varies by ±3 K around 25 °C, in ticks; more than the play of the backlash.
pub(crate) const SWING: usize = 400;

/// Supply voltage, V.
const SUPPLY: f32 = 3.3;

/// A clean log: six axes at rest with the noise of their model, and a periodic temperature.
pub(crate) fn clean(ticks: usize, seed: u64) -> Vec<Tick> {
    let mut random = Random(seed);
    let mut noise = move || random.next() + random.next() + random.next();
    (0..ticks)
        .map(|index| {
            let axes =
                core::array::from_fn(|axis| AT_REST[axis] + OFFSET[axis] + SPREAD[axis] * 0.9 * noise());
            let turn = (index % SWING) as f32 / SWING as f32;
            let temperature = 22.0 + 12.0 * (turn - 0.5).abs() + 0.02 * noise();
            Tick {
                index,
                axes,
                temperature,
                supply: SUPPLY,
                skipped: 0,
                reset: false,
                clock_us: (1 << 40) + index as u64 * 5000,
                moving: false,
            }
        })
        .collect()
}

/// A fault: its name, duration in ticks, target and effect.
pub(crate) struct Fault {
    pub(crate) name: &'static str,
    pub(crate) lasts: usize,
    pub(crate) on: On,
    happens: fn(&mut Vec<Tick>, Range<usize>),
}

/// Target of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum On {
    /// Every measured value.
    Values,
    /// The measured axes.
    Axes,
    /// Every measured value, with values that a code cannot represent.
    NotInCodes,
    Temperature,
    /// Missing samples.
    Gap,
    /// The application's clock relative to that of the sensor.
    Clock,
    Reset,
}

/// Measured values affected by a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Strikes {
    Axes,
    /// Temperature and supply.
    Quantities,
    All,
}

impl Fault {
    /// A fault of values affects axes and quantities separately, so that neither hides the other, and all at once.
    pub(crate) fn strikes(&self) -> &'static [Strikes] {
        match self.on {
            On::Values | On::NotInCodes => &[Strikes::Axes, Strikes::Quantities, Strikes::All],
            _ => &[Strikes::All],
        }
    }

    /// The log with the fault, from tick `from` on.
    pub(crate) fn into(&self, clean: &[Tick], from: usize, strikes: Strikes) -> Vec<Tick> {
        let mut ticks = clean.to_vec();
        (self.happens)(&mut ticks, from..from + self.lasts);
        for tick in &mut ticks {
            let clean = &clean[tick.index];
            match strikes {
                Strikes::Axes => (tick.temperature, tick.supply) = (clean.temperature, clean.supply),
                Strikes::Quantities => tick.axes = clean.axes,
                Strikes::All => {}
            }
        }
        ticks
    }
}

/// Sets every measured value to `value`.
fn all(ticks: &mut [Tick], range: Range<usize>, value: f32) {
    for tick in &mut ticks[range] {
        (tick.axes, tick.temperature, tick.supply) = ([value; 6], value, value);
    }
}

/// Adds standard deviations to the axes and K to the temperature, as a function of the ticks since the start.
fn off(ticks: &mut [Tick], range: Range<usize>, by: impl Fn(usize) -> (f32, f32)) {
    for (since, tick) in ticks[range].iter_mut().enumerate() {
        let (deviations, kelvin) = by(since);
        for (value, spread) in tick.axes.iter_mut().zip(SPREAD) {
            *value += deviations * spread;
        }
        tick.temperature += kelvin;
    }
}

fn temperature(ticks: &mut [Tick], range: Range<usize>, value: f32) {
    for tick in &mut ticks[range] {
        tick.temperature = value;
    }
}

/// Adds `more_us` to the application's clock for every tick of the range.
fn rate_off(ticks: &mut [Tick], range: Range<usize>, more_us: i64) {
    let long = range.len() as i64;
    for (since, tick) in (0..).zip(&mut ticks[range.start..]) {
        tick.clock_us = tick.clock_us.wrapping_add_signed(more_us * long.min(since));
    }
}

fn missing(ticks: &mut Vec<Tick>, range: Range<usize>) {
    ticks[range.end].skipped = range.len() as u32;
    ticks.drain(range);
}

/// Height of a step and end of a drift, in standard deviations: within the fitted range, so that no single sample shows it.
const SMALL: f32 = 2.0;

/// Duration of slow faults, ticks: three rounds of the hub's monitoring of its six axes.
const LONG: usize = 3600;

/// Rotates the device about x by an angle in rad, as a function of the ticks since the start; the gyro measures it.
fn rotate(ticks: &mut [Tick], range: Range<usize>, angle: impl Fn(usize) -> f32) {
    for (since, tick) in ticks[range].iter_mut().enumerate() {
        let (sine, cosine) = angle(since).sin_cos();
        let [_, y, z, ..] = tick.axes;
        (tick.axes[1], tick.axes[2]) = (cosine * y - sine * z, sine * y + cosine * z);
        tick.axes[3] += (angle(since + 1) - angle(since)) / SCALES.period_s as f32;
    }
}

/// Duration of a rotation by hand, ticks.
const HAND: usize = 200;

pub(crate) const FAULTS: [Fault; 33] = [
    Fault { name: "NaN", lasts: 30, on: On::NotInCodes, happens: |ticks, range| all(ticks, range, f32::NAN) },
    Fault {
        name: "+inf",
        lasts: 30,
        on: On::NotInCodes,
        happens: |ticks, range| all(ticks, range, f32::INFINITY),
    },
    Fault {
        name: "−inf",
        lasts: 30,
        on: On::NotInCodes,
        happens: |ticks, range| all(ticks, range, f32::NEG_INFINITY),
    },
    Fault { name: "huge", lasts: 30, on: On::Values, happens: |ticks, range| all(ticks, range, f32::MAX) },
    Fault { name: "denormal", lasts: 30, on: On::Values, happens: |ticks, range| all(ticks, range, 1e-40) },
    Fault {
        name: "denormal, gyros alone",
        lasts: 30,
        on: On::Axes,
        happens: |ticks, range| ticks[range].iter_mut().for_each(|tick| tick.axes[3..].fill(1e-40)),
    },
    Fault {
        name: "stuck",
        lasts: 60,
        on: On::Values,
        happens: |ticks, range| {
            let held = ticks[range.start];
            for tick in &mut ticks[range] {
                (tick.axes, tick.temperature) = (held.axes, held.temperature);
            }
        },
    },
    Fault {
        name: "saturated",
        lasts: 30,
        on: On::Values,
        happens: |ticks, range| {
            let raw = RawSample { accel: [i16::MAX; 3], gyro: [i16::MIN; 3], ..RawSample::default() };
            for tick in &mut ticks[range] {
                // the thermometer at its last code too
                (tick.axes, tick.temperature) = (SCALES.measured(&raw), 153.0);
            }
        },
    },
    Fault {
        name: "spikes",
        lasts: 60,
        on: On::Values,
        happens: |ticks, range| {
            off(ticks, range, |since| if since % 7 == 0 { (60.0, 60.0) } else { (0.0, 0.0) });
        },
    },
    Fault {
        name: "step",
        lasts: LONG,
        on: On::Values,
        happens: |ticks, range| off(ticks, range, |_| (SMALL, 5.0)),
    },
    Fault {
        name: "drift",
        lasts: LONG,
        on: On::Values,
        happens: |ticks, range| {
            off(ticks, range, |since| {
                let share = since as f32 / LONG as f32;
                (share * SMALL, share * 40.0)
            });
        },
    },
    Fault {
        name: "swapped axes, accelerometers",
        // long enough to be still again, in another orientation
        lasts: LONG,
        on: On::Axes,
        happens: |ticks, range| ticks[range].iter_mut().for_each(|tick| tick.axes.swap(0, 2)),
    },
    Fault {
        name: "swapped axes, gyros at rest",
        lasts: LONG,
        on: On::Axes,
        happens: |ticks, range| ticks[range].iter_mut().for_each(|tick| tick.axes.swap(3, 5)),
    },
    Fault {
        name: "sign flip, accelerometers",
        // long enough to be still again, in another orientation
        lasts: LONG,
        on: On::Axes,
        happens: |ticks, range| {
            for tick in &mut ticks[range] {
                tick.axes[..3].iter_mut().for_each(|value| *value = -*value);
            }
        },
    },
    Fault {
        name: "sign flip, gyros at rest",
        lasts: LONG,
        on: On::Axes,
        happens: |ticks, range| {
            for tick in &mut ticks[range] {
                tick.axes[3..].iter_mut().for_each(|value| *value = -*value);
            }
        },
    },
    Fault {
        name: "knocks",
        // four knocks in three seconds; each rings at a fifth of the sampling rate
        lasts: 600,
        on: On::Axes,
        happens: |ticks, range| {
            off(ticks, range, |since| {
                let after = (since % 150) as f32;
                (500.0 * (-after / 10.0).exp() * (after * 1.26).sin(), 0.0)
            });
        },
    },
    Fault {
        name: "a motor, folded to a tenth of the rate",
        lasts: LONG,
        on: On::Axes,
        happens: |ticks, range| off(ticks, range, |since| (30.0 * (since as f32 * 0.63).sin(), 0.0)),
    },
    Fault {
        name: "handled and put back",
        lasts: LONG,
        on: On::Axes,
        happens: |ticks, range| {
            let back = range.len() - HAND;
            rotate(ticks, range, |since| {
                let out = since.min(back + HAND - since.min(back + HAND)).min(HAND) as f32 / HAND as f32;
                1.2 * out * out * (3.0 - 2.0 * out)
            });
        },
    },
    Fault {
        name: "turned about x, and at rest",
        // long enough to be still again, in another orientation, which does not change x
        lasts: LONG,
        on: On::Axes,
        happens: |ticks, range| {
            rotate(ticks, range, |since| 0.5 * (since.min(HAND) as f32 / HAND as f32));
        },
    },
    Fault {
        name: "wrong units: g, °/s, K",
        lasts: 60,
        on: On::Values,
        happens: |ticks, range| {
            for tick in &mut ticks[range] {
                tick.axes[..3].iter_mut().for_each(|value| *value /= 9.806_65);
                tick.axes[3..].iter_mut().for_each(|value| *value = value.to_degrees());
                tick.temperature += 273.15;
            }
        },
    },
    Fault {
        name: "duplicated samples",
        lasts: LONG,
        on: On::Values,
        happens: |ticks, range| {
            for pair in ticks[range].chunks_exact_mut(2) {
                (pair[1].axes, pair[1].temperature) = (pair[0].axes, pair[0].temperature);
            }
        },
    },
    Fault { name: "3 missing samples", lasts: 3, on: On::Gap, happens: missing },
    Fault { name: "300 missing samples", lasts: 300, on: On::Gap, happens: missing },
    Fault {
        name: "reordered samples",
        lasts: LONG,
        on: On::Values,
        happens: |ticks, range| {
            for pair in ticks[range].chunks_exact_mut(2) {
                let (first, second) = (pair[0], pair[1]);
                (pair[0].axes, pair[0].temperature) = (second.axes, second.temperature);
                (pair[1].axes, pair[1].temperature) = (first.axes, first.temperature);
            }
        },
    },
    Fault {
        name: "time going back by 3 s",
        lasts: 1,
        on: On::Clock,
        // from this tick on, in the middle of a window of the hub's rate measurement
        happens: |ticks, range| {
            ticks[range.start..].iter_mut().for_each(|tick| tick.clock_us -= 3_000_000);
        },
    },
    Fault {
        name: "time going back by 1 h",
        lasts: 1,
        on: On::Clock,
        happens: |ticks, range| {
            ticks[range.start..].iter_mut().for_each(|tick| tick.clock_us -= 3_600_000_000);
        },
    },
    Fault {
        name: "rate 5 % too high",
        lasts: 5000,
        on: On::Clock,
        happens: |ticks, range| rate_off(ticks, range, -250),
    },
    Fault {
        name: "rate 5 % too low",
        lasts: 5000,
        on: On::Clock,
        happens: |ticks, range| rate_off(ticks, range, 250),
    },
    Fault {
        name: "temperature invalid",
        lasts: 60,
        on: On::Temperature,
        happens: |ticks, range| temperature(ticks, range, f32::NAN),
    },
    Fault {
        name: "temperature frozen",
        lasts: LONG,
        on: On::Temperature,
        happens: |ticks, range| {
            let held = ticks[range.start].temperature;
            temperature(ticks, range, held);
        },
    },
    Fault {
        name: "temperature above its range",
        lasts: 60,
        on: On::Temperature,
        happens: |ticks, range| temperature(ticks, range, 84.0),
    },
    Fault {
        name: "temperature below its range",
        lasts: 60,
        on: On::Temperature,
        happens: |ticks, range| temperature(ticks, range, -40.0),
    },
    Fault {
        name: "reset in mid-stream",
        lasts: 1,
        on: On::Reset,
        happens: |ticks, range| ticks[range.start].reset = true,
    },
];
