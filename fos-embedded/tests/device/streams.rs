//! Streams with separate timestamps as samples for the hub: skipped ticks, passed-over samples, missing values.

use fos_core::align::Refused;
use fos_embedded::raw::Faults;
use fos_embedded::streams::{Periods, StampedSample, Streams};
use proptest::prelude::*;

const MS: i64 = 1_000_000;
const PERIOD: i64 = 5 * MS;
const PERIODS: Periods = Periods { gyro_ns: 5_000_000, accel_ns: 10_000_000, temperature_ns: 1_000_000_000 };

/// Samples from gyros with these timestamps, with accelerometers throughout.
fn steps(stamps: &[i64]) -> (Vec<StampedSample>, Streams<64>) {
    let mut streams = Streams::<64>::new(&PERIODS);
    let mut found = Vec::new();
    for stamp in stamps {
        let _ = streams.push_accel(*stamp, [0.0, 0.0, 9.8]);
        let _ = streams.push_gyro(*stamp, [0.1; 3]);
        found.extend(std::iter::from_fn(|| streams.next()));
    }
    found.extend(std::iter::from_fn(|| streams.flush()));
    (found, streams)
}

fn skipped(samples: &[StampedSample]) -> Vec<u32> {
    samples.iter().map(|stamped| stamped.sample.skipped).collect()
}

fn stamps(samples: &[StampedSample]) -> Vec<i64> {
    samples.iter().map(|stamped| stamped.stamp_ns).collect()
}

#[test]
fn skipped_ticks_follow_from_timestamps() {
    // nominal, 3 % slow, 3 % fast, jitter, gaps, and extreme timestamps
    for (stamps, expected) in [
        ([0, PERIOD, 2 * PERIOD, 3 * PERIOD], [0, 0, 0, 0]),
        ([7, 7 + 103 * PERIOD / 100, 7 + 206 * PERIOD / 100, 7 + 309 * PERIOD / 100], [0, 0, 0, 0]),
        ([0, 97 * PERIOD / 100, 194 * PERIOD / 100, 291 * PERIOD / 100], [0, 0, 0, 0]),
        ([0, 4 * PERIOD / 3, 2 * PERIOD, 3 * PERIOD], [0, 0, 0, 0]),
        ([0, 3 * PERIOD, 4 * PERIOD, 24 * PERIOD], [0, 2, 0, 19]),
        ([i64::MIN, i64::MIN + PERIOD, 0, i64::MAX], [0, 0, u32::MAX, u32::MAX]),
    ] {
        let (found, streams) = steps(&stamps);
        assert_eq!(skipped(&found), expected, "{stamps:?}");
        assert_eq!(streams.counts().passed_over, 0);
        assert!(found.iter().all(|stamped| stamped.sample.faults.is_empty()));
    }
}

#[test]
fn keeps_every_nth_sample_at_n_times_the_rate() {
    for n in 1..=8 {
        // jitter of up to 6 % of the faster period
        let jitter = |k: i64| (k * 7919 % 13 - 6) * PERIOD / n / 100;
        let fast: Vec<i64> = (0..400 * n).map(|k| k * PERIOD / n + jitter(k)).collect();
        let (found, streams) = steps(&fast);
        let expected: Vec<i64> = fast.iter().copied().step_by(n as usize).collect();
        assert_eq!(stamps(&found), expected, "{n} times");
        assert!(skipped(&found).iter().all(|skipped| *skipped == 0));
        assert_eq!(streams.counts().passed_over, 400 * (n as u32 - 1));
    }
    // another client requests a faster rate for a while
    let plain = (0..100).map(|k| k * PERIOD);
    let fast = (200..400).map(|k| k * PERIOD / 2);
    let all: Vec<i64> = plain.chain(fast).chain((200..300).map(|k| k * PERIOD)).collect();
    let (found, _) = steps(&all);
    assert_eq!(stamps(&found), (0..300).map(|k| k * PERIOD).collect::<Vec<_>>());
    // without a period, nothing is passed over
    let mut streams = Streams::<64>::new(&Periods { gyro_ns: 0, ..PERIODS });
    for stamp in [0, 1, 1_000 * MS] {
        streams.push_gyro(stamp, [0.0; 3]).unwrap();
    }
    let found: Vec<_> = std::iter::from_fn(|| streams.flush()).collect();
    assert_eq!(skipped(&found), [0, 0, 0]);
}

#[test]
fn clock_set_back_is_a_reset_after_a_gap() {
    let before = (100..110).map(|k| k * PERIOD);
    let after = (0..20).map(|k| k * PERIOD + 3);
    let (found, streams) = steps(&before.chain(after).collect::<Vec<_>>());
    let reset: Vec<_> = found.iter().filter(|stamped| !stamped.sample.faults.is_empty()).collect();
    let [reset] = reset[..] else { panic!("{reset:?}") };
    assert_eq!(reset.sample.faults, Faults::RESET);
    assert_eq!((reset.stamp_ns, reset.sample.skipped), (7 * PERIOD + 3, 7));
    assert_eq!(skipped(&found).iter().sum::<u32>(), 7, "and all the others follow one another");
    let gyro = streams.counts().gyro;
    assert_eq!((gyro.set_back, gyro.refused), (1, 7));
}

#[test]
fn missing_values_are_nan() {
    let mut streams = Streams::<64>::new(&PERIODS);
    streams.push_temperature(0, 20.0).unwrap();
    for n in 0..800 {
        let stamp = n * PERIOD;
        // one sample of the accelerometers is lost
        if n % 2 == 0 && n != 400 {
            streams.push_accel(stamp, [1.0, 2.0, 9.0]).unwrap();
        }
        let rate = if n == 200 { [0.1, f32::NAN, 0.1] } else { [0.1; 3] };
        assert_eq!(streams.push_gyro(stamp, rate), if n == 200 { Err(Refused::NotFinite) } else { Ok(()) });
        while let Some(StampedSample { stamp_ns, sample }) = streams.next() {
            let n = stamp_ns / PERIOD;
            let lost = [399, 400, 401].contains(&n);
            assert_eq!(sample.accel.iter().all(|value| value.is_nan()), lost, "{n}");
            assert_eq!(sample.accel == [1.0, 2.0, 9.0], !lost, "{n}");
            assert_eq!(sample.gyro.iter().all(|value| value.is_nan()), n == 200, "the row is there");
            assert_eq!(sample.temperature_c.is_nan(), stamp_ns > 3_000 * MS, "older than three periods");
            assert_eq!((sample.skipped, sample.faults), (0, Faults::empty()));
        }
    }
    let counts = streams.counts();
    assert_eq!((counts.gyro.not_finite, counts.accel.missing), (1, 3));
    assert_eq!(counts.temperature.missing, 198);
    assert_eq!(streams.push_accel(0, [0.0; 3]), Err(Refused::NotIncreasing));
    assert_eq!(streams.push_temperature(1, f32::NAN), Err(Refused::NotFinite));
    // with a longer period the thermometer is not late yet
    streams.set_periods(&Periods { temperature_ns: 2_000_000_000, ..PERIODS });
    streams.push_gyro(800 * PERIOD, [0.1; 3]).unwrap();
    let last = std::iter::from_fn(|| streams.flush()).last().expect("a sample");
    assert_eq!(last.sample.temperature_c, 20.0);
}

#[test]
fn dead_accelerometers_delay_by_at_most_the_depth() {
    let mut streams = Streams::<64>::new(&PERIODS);
    for n in 0..200_i64 {
        streams.push_gyro(n * PERIOD, [0.1; 3]).unwrap();
        let found: Vec<_> = std::iter::from_fn(|| streams.next()).collect();
        assert_eq!(found.len(), usize::from(n >= 63), "{n}");
        assert!(found.iter().all(|stamped| stamped.sample.accel[0].is_nan() && stamped.sample.skipped == 0));
    }
    assert_eq!(streams.counts().gyro.dropped, 0);
}

#[test]
#[cfg(target_pointer_width = "64")]
fn has_the_documented_size() {
    assert_eq!(size_of::<Streams<64>>(), 3504);
}

/// A push of any of the three streams.
#[derive(Debug, Clone, Copy)]
struct Push {
    stream: u8,
    stamp: i64,
    value: f32,
}

fn push(streams: &mut Streams<64>, push: Push) -> Result<(), Refused> {
    match push.stream {
        0 => streams.push_gyro(push.stamp, [push.value, 1.0, push.value]),
        1 => streams.push_accel(push.stamp, [0.0, push.value, 9.8]),
        _ => streams.push_temperature(push.stamp, push.value),
    }
}

fn any_stamp() -> impl Strategy<Value = i64> {
    prop_oneof![
        any::<i64>(),
        (0..2000_i64).prop_map(|n| n * MS),
        prop_oneof![Just(i64::MIN), Just(i64::MAX), Just(i64::MIN + 1), Just(-1), Just(0)],
    ]
}

fn bits(found: &[StampedSample]) -> Vec<(i64, u32, [u32; 7], u16)> {
    let of = |stamped: &StampedSample| {
        let sample = &stamped.sample;
        let [ax, ay, az] = sample.accel;
        let [gx, gy, gz] = sample.gyro;
        let values = [ax, ay, az, gx, gy, gz, sample.temperature_c].map(f32::to_bits);
        (stamped.stamp_ns, sample.skipped, values, sample.faults.bits())
    };
    found.iter().map(of).collect()
}

proptest! {
    /// No timestamps, values, periods or order cause a panic, a hang or additional samples.
    #[test]
    fn accepts_any_input(
        pushes in prop::collection::vec((0..3_u8, any_stamp(), any::<f32>(), 0..8_u8), 0..400),
        periods in prop::collection::vec(prop_oneof![Just(0), Just(u64::MAX), any::<u64>(), 1..20_000_000_u64], 6),
    ) {
        let of = |k: usize| Periods { gyro_ns: periods[k], accel_ns: periods[k + 1], temperature_ns: periods[k + 2] };
        let mut streams = Streams::<64>::new(&of(0));
        let (mut gyros, mut given) = (0_usize, 0_usize);
        for (stream, stamp, value, then) in pushes {
            let taken = push(&mut streams, Push { stream, stamp, value });
            gyros += usize::from(stream == 0 && taken != Err(Refused::NotIncreasing));
            match then {
                0 => given += usize::from(streams.flush().is_some()),
                1 => streams.set_periods(&of(3)),
                2..6 => given += std::iter::from_fn(|| streams.next()).count(),
                _ => {}
            }
        }
        given += std::iter::from_fn(|| streams.flush()).count();
        let counts = streams.counts();
        prop_assert_eq!(gyros, given + counts.passed_over as usize + counts.gyro.dropped as usize);
    }

    /// For a regularly sampled sensor with lost samples and jitter, the ticks add up to the elapsed time. The samples have the
    /// same bits for any order between the streams.
    #[test]
    fn ticks_add_up_for_any_order_of_the_streams(
        samples in prop::collection::vec((any::<bool>(), -700_000..700_000_i64), 2..40),
        order in prop::collection::vec(1..3_u8, 200),
    ) {
        let gyros: Vec<Push> = samples
            .iter()
            .enumerate()
            .filter(|(_, (present, _))| *present)
            .map(|(k, (_, jitter))| Push { stream: 0, stamp: k as i64 * PERIOD + jitter, value: k as f32 })
            .collect();
        let accels: Vec<Push> = (0..25)
            .map(|k| Push { stream: 1, stamp: (2 * k - 1) * PERIOD + 77, value: k as f32 * 0.3 })
            .collect();
        let run = |order: &[u8]| {
            let mut streams = Streams::<64>::new(&PERIODS);
            streams.push_temperature(-PERIOD, 21.0).unwrap();
            let (mut gyros, mut accels, mut found) = (gyros.iter().peekable(), accels.iter().peekable(), Vec::new());
            let mut order = order.iter().cycle();
            while gyros.peek().is_some() || accels.peek().is_some() {
                let next = match order.next() {
                    Some(1) => gyros.next().or_else(|| accels.next()),
                    _ => accels.next().or_else(|| gyros.next()),
                };
                push(&mut streams, *next.expect("one of them")).expect("taken");
                found.extend(std::iter::from_fn(|| streams.next()));
            }
            found.extend(std::iter::from_fn(|| streams.flush()));
            found
        };
        let found = run(&order);
        prop_assert_eq!(bits(&found), bits(&run(&[1])), "one stream after the other");
        prop_assert_eq!(found.len(), gyros.len());
        let nearest = |stamp: i64| (stamp + PERIOD / 2).div_euclid(PERIOD);
        if let [first, .., last] = &gyros[..] {
            let ticks: u32 = found[1..].iter().map(|stamped| stamped.sample.skipped + 1).sum();
            prop_assert_eq!(i64::from(ticks), nearest(last.stamp) - nearest(first.stamp));
        }
    }
}
