//! The flight that every format holds.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A device at rest: accelerations, rates and temperature with common timestamps.
#[derive(Debug, Clone)]
pub struct Flight {
    /// Timestamps, µs since boot.
    pub stamps_us: Vec<u64>,
    /// Specific force, m/s².
    pub acceleration: Vec<[f32; 3]>,
    /// Angular rate, rad/s.
    pub rate: Vec<[f32; 3]>,
    /// Temperature, °C.
    pub temperature: Vec<f32>,
}

/// A sensor that publishes to a ROS topic.
#[derive(Debug, Clone, Copy)]
pub struct Publisher<'a> {
    /// Name of the topic.
    pub topic: &'a str,
    /// Number of its connection in a bag, or of its channel in MCAP.
    pub connection: u16,
    /// Frame in the headers.
    pub frame: &'a str,
    /// Samples.
    pub flight: &'a Flight,
}

/// Sample index and publisher of all messages, in the order of their timestamps.
pub(super) fn in_order<'a>(publishers: &[Publisher<'a>]) -> Vec<(Publisher<'a>, usize)> {
    let mut all: Vec<(Publisher<'a>, usize)> = publishers
        .iter()
        .flat_map(|publisher| (0..publisher.flight.len()).map(|sample| (*publisher, sample)))
        .collect();
    all.sort_by_key(|(publisher, sample)| publisher.flight.stamps_us[*sample]);
    all
}

impl Flight {
    /// The same samples from another device: later by `later_us`, with another bias of the gyro, rad/s.
    #[must_use]
    pub fn of_another(&self, later_us: u64, bias: f32) -> Self {
        let mut other = self.clone();
        other.stamps_us.iter_mut().for_each(|us| *us += later_us);
        other.rate.iter_mut().flatten().for_each(|rate| *rate += bias);
        other
    }

    /// A flight of `samples` samples, `period_us` apart, of a part whose error follows its temperature.
    pub fn new(samples: usize, period_us: u64, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut flight = Self {
            stamps_us: Vec::new(),
            acceleration: Vec::new(),
            rate: Vec::new(),
            temperature: Vec::new(),
        };
        let start_us: u64 = random.random_range(1_000_000..50_000_000);
        for sample in 0..samples as u64 {
            let mut noise = |size: f32| {
                let unit: f32 = StandardNormal.sample(&mut random);
                size * unit
            };
            let age_s = sample as f32 * period_us as f32 * 1e-6;
            // A temperature sensor with two samples per second.
            let warmth = 12.0 * (1.0 - (-(age_s * 2.0).floor() / 600.0).exp());
            flight.stamps_us.push(start_us + sample * period_us);
            flight.acceleration.push([noise(0.02) + 0.004 * warmth, noise(0.02), 9.81 + noise(0.02)]);
            flight.rate.push([noise(0.002), noise(0.002) + 2e-4 * warmth, noise(0.002)]);
            flight.temperature.push(25.0 + warmth);
        }
        flight
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.stamps_us.len()
    }

    /// There are no samples.
    pub fn is_empty(&self) -> bool {
        self.stamps_us.is_empty()
    }

    /// Columns of the log format that readers must return for every format with all data.
    pub fn columns(&self) -> Vec<(&'static str, Vec<f64>)> {
        let axis =
            |values: &[[f32; 3]], axis: usize| values.iter().map(|value| f64::from(value[axis])).collect();
        vec![
            ("ax_mps2", axis(&self.acceleration, 0)),
            ("ay_mps2", axis(&self.acceleration, 1)),
            ("az_mps2", axis(&self.acceleration, 2)),
            ("gx_rads", axis(&self.rate, 0)),
            ("gy_rads", axis(&self.rate, 1)),
            ("gz_rads", axis(&self.rate, 2)),
            ("temp_c", self.temperature.iter().map(|value| f64::from(*value)).collect()),
        ]
    }

    /// Timestamps, s.
    pub fn time_s(&self) -> Vec<f64> {
        self.stamps_us.iter().map(|us| *us as f64 / 1e6).collect()
    }

    /// The flight as CSV in the log format.
    pub fn csv(&self) -> String {
        let columns = self.columns();
        let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        let mut text = format!("t_s,{}\n", names.join(","));
        for (row, time_s) in self.time_s().iter().enumerate() {
            text.push_str(&time_s.to_string());
            for (_, values) in &columns {
                text.push_str(&format!(",{}", values[row]));
            }
            text.push('\n');
        }
        text
    }
}
