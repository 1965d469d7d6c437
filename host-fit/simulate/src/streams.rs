//! A log as sensors with separate clocks: the accelerometer at half of the gyro's rate and on another clock, the
//! thermometer once a second, and jitter on all timestamps.
//!
//! A sample of the accelerometer is the mean of two, stamped in their middle: a part that runs at half of the rate
//! filters to half of the band, and the density of its noise is unchanged. The true specific force, if known, comes
//! with it, everything else with the gyro.

use super::random::{Stream as Purpose, normal, random};
use super::regressors::NamedSeries;
use fos_data::column::{ACCELEROMETERS, Column};
use fos_data::recording::Stream;

/// Nominal rate of the gyro, Hz; that of the accelerometer is half of it.
pub(super) const RATE_HZ: f64 = 208.0;

/// Standard deviation of a timestamp, s; limited to twice this value.
const JITTER_S: f64 = 1e-3;

/// Relative excess of the accelerometer's clock rate: two crystals of 100 ppm each.
const FASTER: f64 = 200e-6;

/// Streams of log number `log` of a case.
pub(super) fn split(columns: &[NamedSeries], (seed, log): (u64, u64)) -> Vec<Stream> {
    let random = &mut random(seed, Purpose::Disturbance(100 + log));
    let Some((_, time_s)) = columns.iter().find(|(name, _)| name == "t_s") else { return Vec::new() };
    let mut stamped = |times: &[f64], rate: f64| -> Vec<i64> {
        let mut jitter = |time: &f64| rate * time + JITTER_S * normal(random).clamp(-2.0, 2.0);
        times.iter().map(|time| (jitter(time) * 1e9).round() as i64).collect()
    };
    let is_force = |name: &str| {
        ACCELEROMETERS.iter().any(|axis| *axis == name || Column::named(axis).reference() == name)
    };

    let usual_s = 1.5 / RATE_HZ;
    let pairs: Vec<usize> =
        (1..time_s.len()).step_by(2).filter(|&row| time_s[row] - time_s[row - 1] < usual_s).collect();
    let mean = |values: &[f64]| -> Vec<f64> {
        pairs.iter().map(|&row| 0.5 * (values[row - 1] + values[row])).collect()
    };
    let mut seconds: Vec<usize> = Vec::new();
    for (row, time) in time_s.iter().enumerate() {
        if *time >= seconds.len() as f64 {
            seconds.push(row);
        }
    }
    let picked = |values: &[f64]| -> Vec<f64> { seconds.iter().map(|&row| values[row]).collect() };
    let of = |chosen: &dyn Fn(&str) -> bool, made: &dyn Fn(&[f64]) -> Vec<f64>| -> Vec<NamedSeries> {
        let chosen = columns.iter().filter(|(name, _)| chosen(name));
        chosen.map(|(name, values)| (name.clone(), made(values))).collect()
    };
    let is_warm = |name: &str| name == "temp_c";
    let mut streams = vec![
        Stream {
            name: "gyro".to_owned(),
            stamps_ns: stamped(time_s, 1.0),
            columns: of(&|name| name != "t_s" && !is_force(name) && !is_warm(name), &<[f64]>::to_vec),
        },
        Stream {
            name: "accelerometer".to_owned(),
            stamps_ns: stamped(&mean(time_s), 1.0 + FASTER),
            columns: of(&is_force, &mean),
        },
        Stream {
            name: "thermometer".to_owned(),
            stamps_ns: stamped(&picked(time_s), 1.0),
            columns: of(&is_warm, &picked),
        },
    ];
    streams.retain(|stream| !stream.columns.is_empty());
    streams
}

#[cfg(test)]
mod tests {
    use crate::{Axis, CasePlan, Disturbance, Durations, Setup, simulate_case};
    use fos_data::recording::{Clocks, HowJoined};

    #[test]
    fn split_streams_join_to_the_same_rows() {
        let mut plan = CasePlan::new(3, "bmi270", Setup::Bench, Axis::Ax);
        plan.durations = Durations { reference_s: 60.0, log_s: 120.0, evaluation_s: 60.0 };
        plan.disturbance = Disturbance::Streams;
        let case = simulate_case(&plan).expect("a case");
        let [_, field, _] = case.recordings().expect("logs");
        // the rows of the truth are those of the gyro
        assert_eq!(field.n_rows(), case.truth.log.error.len());
        assert!((field.rate.true_hz / 208.0 - 1.0).abs() < 0.02, "{}", field.rate.true_hz);
        let of = |name: &str| &case.log.iter().find(|(column, _)| column == name).expect(name).1;
        assert_eq!(*field.channel("gx_rads").expect("a gyro").values, *of("gx_rads"));
        let alignment = field.alignment.as_ref().expect("streams");
        assert_eq!(alignment.lead, "gyro");
        let HowJoined::Interpolated { noise_kept, clocks } = alignment.others[0].how else {
            panic!("{alignment}")
        };
        assert_eq!(clocks, Some(Clocks::NoMotion), "it lies on a bench");
        // weights in pairs that lie half a period apart, anywhere
        assert!((0.6..0.75).contains(&noise_kept), "{noise_kept}");
        // half a second on average for a thermometer read once a second
        assert!(alignment.others[1..].iter().all(|other| matches!(
            other.how, HowJoined::Held { mean_age_s } if (0.4..0.6).contains(&mean_age_s)
        )));
        // the means of two, interpolated between two of them
        let (force, seen) = (of("ax_mps2"), &field.channel("ax_mps2").expect("an accelerometer").values);
        let variance = |values: &[f64]| fos_data::statistics::variance(&[values]);
        let known: Vec<f64> = seen.iter().copied().filter(|value| value.is_finite()).collect();
        assert!(seen.len() - known.len() < 4);
        let kept = variance(&known) / variance(force);
        assert!(kept < 0.5 * noise_kept * 1.05, "{kept}");
    }
}
