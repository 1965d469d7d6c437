//! Resampling of streams sample by sample, compared with a twin that has whole streams; and every guarantee of
//! `fos_core::align`.

mod twin;

use fos_core::Real;
use fos_core::align::{Aligner, Counts, Joined, Refused, SET_BACK_AFTER, SLOW_DEPTH, Stream};
use proptest::prelude::*;
use twin::{bits, same};

const MS: i64 = 1_000_000;

/// One follower every 10 ms, one thermometer every second.
type Plain = Aligner<f32, 1, 1, 16>;

fn plain() -> Plain {
    Aligner::new([10 * MS], [1000 * MS])
}

fn rows<R: Real, const F: usize, const S: usize, const D: usize>(
    aligner: &mut Aligner<R, F, S, D>,
) -> Vec<Joined<R, F, S>> {
    std::iter::from_fn(|| aligner.pop()).collect()
}

#[test]
fn row_at_a_sample_has_its_exact_bits() {
    let mut aligner = plain();
    let odd = [f32::MIN_POSITIVE / 4.0, -0.0, 0.1];
    // the neighbours are too far apart for interpolation
    for (stamp, values) in [(0, [1.0; 3]), (500 * MS, odd), (900 * MS, [f32::MAX; 3])] {
        aligner.push_follower(0, stamp, values).unwrap();
    }
    aligner.push_lead(500 * MS, [0.0; 3]).unwrap();
    let [row] = rows(&mut aligner)[..] else { panic!("one row") };
    assert_eq!(row.followers[0].values.map(f32::to_bits), odd.map(f32::to_bits));
    assert_eq!(row.followers[0].weight, Some(0));
}

#[test]
fn interpolates_over_at_most_one_and_a_half_periods() {
    for (apart, found) in [(15 * MS, true), (15 * MS + 1, false)] {
        let mut aligner = plain();
        aligner.push_follower(0, 0, [0.0; 3]).unwrap();
        aligner.push_follower(0, apart, [1.0; 3]).unwrap();
        aligner.push_lead(5 * MS, [0.0; 3]).unwrap();
        let [row] = rows(&mut aligner)[..] else { panic!("one row") };
        assert_eq!(row.followers[0].weight.is_some(), found);
        assert_eq!(row.followers[0].values[0].is_nan(), !found);
        assert_eq!(aligner.counts(Stream::Follower(0)).missing, u32::from(!found));
    }
    // with a longer period they are neighbours again
    let mut aligner = plain();
    aligner.set_follower_period(0, 20 * MS);
    aligner.push_follower(0, 0, [0.0; 3]).unwrap();
    aligner.push_follower(0, 20 * MS, [1.0; 3]).unwrap();
    aligner.push_lead(5 * MS, [0.0; 3]).unwrap();
    assert_eq!(rows(&mut aligner)[0].followers[0].values, [0.25; 3]);
}

#[test]
fn non_finite_samples_are_missing() {
    let mut aligner = plain();
    for (n, value) in [1.0, f32::NAN, 3.0, f32::INFINITY, 5.0].into_iter().enumerate() {
        let taken = aligner.push_follower(0, n as i64 * 10 * MS, [0.0, value, 0.0]);
        assert_eq!(taken.is_ok(), value.is_finite());
    }
    assert_eq!(aligner.push_slow(0, 0, f32::NAN), Err(Refused::NotFinite));
    aligner.push_lead(0, [1.0; 3]).unwrap();
    assert_eq!(aligner.push_lead(5 * MS, [1.0, f32::NAN, 1.0]), Err(Refused::NotFinite));
    aligner.push_lead(40 * MS, [1.0; 3]).unwrap();
    let rows = rows(&mut aligner);
    assert_eq!(rows.iter().map(|row| row.followers[0].weight).collect::<Vec<_>>(), [Some(0), None, Some(0)]);
    assert!(rows[1].lead.iter().all(|value| value.is_nan()), "the row is there");
    assert!(rows.iter().all(|row| row.slow[0].age.is_none()));
    assert_eq!(aligner.counts(Stream::Lead).not_finite, 1);
    assert_eq!(
        aligner.counts(Stream::Follower(0)),
        Counts { not_finite: 2, missing: 1, ..Counts::default() }
    );
    assert_eq!(aligner.counts(Stream::Slow(0)), Counts { not_finite: 1, missing: 3, ..Counts::default() });
}

#[test]
fn values_with_overflowing_difference_are_missing() {
    let mut aligner = plain();
    aligner.push_follower(0, 0, [f32::MAX; 3]).unwrap();
    aligner.push_follower(0, 10 * MS, [-f32::MAX; 3]).unwrap();
    aligner.push_lead(5 * MS, [0.0; 3]).unwrap();
    assert_eq!(rows(&mut aligner)[0].followers[0].weight, None);
}

#[test]
fn rejects_and_counts_non_increasing_timestamps() {
    let mut aligner = plain();
    for stream in [Stream::Lead, Stream::Follower(0), Stream::Slow(0)] {
        let mut push = |stamp| match stream {
            Stream::Lead => aligner.push_lead(stamp, [0.0; 3]),
            Stream::Follower(index) => aligner.push_follower(index, stamp, [0.0; 3]),
            Stream::Slow(index) => aligner.push_slow(index, stamp, 0.0),
        };
        assert_eq!([5, 5, 4, 6].map(&mut push).map(|taken| taken.is_ok()), [true, false, false, true]);
        assert_eq!(aligner.counts(stream).refused, 2);
    }
    assert_eq!(aligner.push_follower(1, 0, [0.0; 3]), Err(Refused::NoSuchStream));
    assert_eq!(aligner.push_slow(1, 0, 0.0), Err(Refused::NoSuchStream));
    assert_eq!(aligner.counts(Stream::Follower(1)), Counts::default());
}

#[test]
fn dead_follower_delays_by_at_most_the_depth() {
    let mut aligner = plain();
    let mut out = Vec::new();
    for n in 0..200_i64 {
        if n < 100 {
            aligner.push_follower(0, n * 10 * MS, [n as f32; 3]).unwrap();
        }
        aligner.push_lead(n * 10 * MS, [n as f32; 3]).unwrap();
        out.extend(rows(&mut aligner));
        assert!(n - (out.len() as i64 - 1) < 16, "{n}: {}", out.len());
    }
    out.extend(std::iter::from_fn(|| aligner.flush()));
    assert_eq!(
        out.iter().map(|row| row.stamp).collect::<Vec<_>>(),
        (0..200).map(|n| n * 10 * MS).collect::<Vec<_>>()
    );
    assert!(out[..100].iter().all(|row| row.followers[0].weight == Some(0)));
    assert!(out[100..].iter().all(|row| row.followers[0].weight.is_none()));
    assert_eq!(aligner.counts(Stream::Follower(0)).missing, 100);
    // the follower recovers
    aligner.push_follower(0, 2000 * MS, [7.0; 3]).unwrap();
    aligner.push_lead(2000 * MS, [0.0; 3]).unwrap();
    assert_eq!(rows(&mut aligner)[0].followers[0].values, [7.0; 3]);
}

#[test]
fn counts_samples_dropped_by_full_queues() {
    let mut aligner = plain();
    for n in 0..40 {
        aligner.push_follower(0, n, [0.0; 3]).unwrap();
        aligner.push_slow(0, n, 0.0).unwrap();
        aligner.push_lead(100 * MS + n, [0.0; 3]).unwrap(); // and never popped
    }
    assert_eq!(aligner.counts(Stream::Lead).dropped, 24);
    assert_eq!(aligner.counts(Stream::Follower(0)).dropped, 24);
    assert_eq!(aligner.counts(Stream::Slow(0)).dropped, 40 - SLOW_DEPTH as u32);
}

#[test]
fn holds_slow_values_for_three_periods() {
    let mut aligner = plain();
    aligner.push_slow(0, 0, 25.0).unwrap();
    aligner.push_slow(0, 7000 * MS, 26.0).unwrap();
    let mut held = Vec::new();
    for stamp in [-1, 0, 3000 * MS, 3000 * MS + 1, 7000 * MS] {
        aligner.push_lead(stamp, [0.0; 3]).unwrap();
        held.extend(aligner.flush().map(|row| (row.slow[0].age, bits(row.slow[0].value))));
    }
    let value = |value: f32| bits(value);
    let missing = (None, u64::MAX);
    assert_eq!(
        held,
        [missing, (Some(0), value(25.0)), (Some(3000 * MS), value(25.0)), missing, (Some(0), value(26.0))]
    );
    aligner.set_slow_period(0, 1);
    aligner.push_lead(7000 * MS + 4, [0.0; 3]).unwrap();
    assert_eq!(aligner.flush().unwrap().slow[0].age, None);
}

/// Pushes all streams every 10 ms from `start` on; returns the rows.
fn push_all(aligner: &mut Plain, start: i64, count: i64) -> Vec<Joined<f32, 1, 1>> {
    let mut out = Vec::new();
    for n in 0..count {
        let stamp = start.wrapping_add(n * 10 * MS);
        let _ = aligner.push_slow(0, stamp, 1.0);
        let _ = aligner.push_lead(stamp, [n as f32; 3]);
        let _ = aligner.push_follower(0, stamp, [n as f32; 3]);
        out.extend(rows(aligner));
    }
    out
}

#[test]
fn recovers_from_clock_jumps() {
    let whole = |row: &Joined<f32, 1, 1>| row.followers[0].weight.is_some() && row.slow[0].age.is_some();
    for jump in
        [-3_600_000 * MS, 3_600_000 * MS, i64::MIN / 2, i64::MAX / 2, i64::MIN, i64::MAX - 10_000 * MS]
    {
        let mut aligner = plain();
        assert_eq!(push_all(&mut aligner, 0, 50).iter().filter(|row| whole(row)).count(), 50);
        let after = push_all(&mut aligner, jump, 50);
        let lost = if jump < 0 { usize::from(SET_BACK_AFTER) - 1 } else { 0 };
        assert_eq!(after.len(), 50 - lost, "{jump}");
        assert!(after.iter().all(whole), "{jump}");
        assert_eq!(aligner.counts(Stream::Lead).refused as usize, lost);
        assert_eq!(aligner.counts(Stream::Follower(0)).set_back, u32::from(jump < 0));
    }
}

#[test]
fn recovers_from_a_wild_timestamp_in_any_stream() {
    for wild in [Stream::Lead, Stream::Follower(0), Stream::Slow(0)] {
        let mut aligner = plain();
        push_all(&mut aligner, 0, 20);
        let _ = match wild {
            Stream::Lead => aligner.push_lead(i64::MAX, [0.0; 3]),
            Stream::Follower(index) => aligner.push_follower(index, i64::MAX, [0.0; 3]),
            Stream::Slow(index) => aligner.push_slow(index, i64::MAX, 0.0),
        };
        let after = push_all(&mut aligner, 200 * MS, 100);
        assert!(after.len() >= 90, "{wild:?}: {}", after.len());
        let last = &after[after.len() - 80..];
        let whole = |row: &Joined<f32, 1, 1>| row.followers[0].weight.is_some() && row.slow[0].age.is_some();
        assert!(last.iter().all(whole), "{wild:?}");
    }
}

type Samples = Vec<(i64, [f64; 3])>;

/// Samples with increasing timestamps and jitter, some lost, some not finite.
fn stream(most: usize) -> impl Strategy<Value = (i64, Samples)> {
    let sample = (-40_i64..=40, 0_u8..12, prop::array::uniform3(-10.0_f64..10.0));
    (8_i64..200, -500_i64..500, prop::collection::vec(sample, 0..=most)).prop_map(
        |(period, from, samples)| {
            let mut stamp = from;
            let samples = samples.into_iter().filter_map(|(jitter, fault, mut values)| {
                stamp += (period + period * jitter / 100).max(1);
                if fault == 1 {
                    values[1] = f64::NAN;
                }
                (fault != 0).then_some((stamp, values))
            });
            (period, samples.collect())
        },
    )
}

/// Pushes all samples, with the streams in the order `order`, and compares every row with the twin.
fn any_order<R: Real>(
    lead: &[(i64, [f64; 3])],
    followers: &[(i64, Samples); 2],
    slow: &(i64, Samples),
    order: &[u8],
) -> Result<(), TestCaseError> {
    let real = |samples: &[(i64, [f64; 3])]| -> Vec<(i64, [R; 3])> {
        samples.iter().map(|(stamp, values)| (*stamp, values.map(R::from_f64))).collect()
    };
    let (lead, [first, second]) = (real(lead), followers.each_ref().map(|(_, samples)| real(samples)));
    let held: Vec<(i64, R)> = real(&slow.1).into_iter().map(|(stamp, values)| (stamp, values[1])).collect();
    let mut aligner = Aligner::<R, 2, 1, 64>::new([followers[0].0, followers[1].0], [slow.0]);
    // slow channels are not waited for
    for (stamp, value) in &held {
        let _ = aligner.push_slow(0, *stamp, *value);
    }
    let mut queues = [lead.iter(), first.iter(), second.iter()];
    let mut out = Vec::new();
    // samples left over by the drawn order come at the end
    for stream in
        order.iter().map(|choice| usize::from(choice % 3)).chain([0, 1, 2].into_iter().flat_map(|s| [s; 64]))
    {
        let Some((stamp, values)) = queues[stream].next() else { continue };
        let _ = match stream {
            0 => aligner.push_lead(*stamp, *values),
            _ => aligner.push_follower(stream - 1, *stamp, *values),
        };
        out.extend(rows(&mut aligner));
    }
    out.extend(std::iter::from_fn(|| aligner.flush()));
    prop_assert_eq!(out.len(), lead.len());
    for (row, (stamp, _)) in out.iter().zip(&lead) {
        prop_assert_eq!(row.stamp, *stamp);
        for (index, samples) in [&first, &second].into_iter().enumerate() {
            let expected = twin::follower(samples, followers[index].0, *stamp);
            prop_assert!(
                same(&row.followers[index], &expected),
                "{:?}, not {:?}",
                row.followers[index],
                expected
            );
        }
        let expected = twin::slow(&held, slow.0, *stamp);
        prop_assert_eq!((row.slow[0].age, bits(row.slow[0].value)), (expected.age, bits(expected.value)));
    }
    for stream in [Stream::Lead, Stream::Follower(0), Stream::Follower(1), Stream::Slow(0)] {
        let counts = aligner.counts(stream);
        prop_assert_eq!((counts.refused, counts.dropped, counts.set_back), (0, 0, 0));
    }
    Ok(())
}

proptest! {
    #![proptest_config(fos_testkit::models::cases(256))]

    #[test]
    fn any_order_and_any_batches_give_the_same_bits(
        (_, lead) in stream(60),
        first in stream(60),
        second in stream(60),
        slow in stream(SLOW_DEPTH),
        order in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let followers = [first, second];
        any_order::<f32>(&lead, &followers, &slow, &order)?;
        any_order::<f64>(&lead, &followers, &slow, &order)?;
    }

    /// Any timestamps and values: no panic, every row of the lead is returned once or counted, and values with a weight are
    /// finite.
    #[test]
    fn every_lost_sample_is_counted_for_any_input(
        events in prop::collection::vec(
            (0_u8..8, any::<i64>(), any::<i8>(), any::<[f32; 3]>(), any::<i64>()), 0..400,
        ),
    ) {
        let mut aligner = Aligner::<f32, 2, 2, 4>::new([1, i64::MAX], [-5, 1 << 40]);
        let (mut stamp, mut pushed, mut out) = (0_i64, 0_u32, 0_u32);
        for (kind, far, near, values, period) in events {
            stamp = if kind == 7 { far } else { stamp.wrapping_add(i64::from(near)) };
            let index = usize::from(kind & 1);
            let _ = match kind {
                0 | 1 => {
                    pushed += 1;
                    aligner.push_lead(stamp, values)
                }
                2 | 3 => aligner.push_follower(index, stamp, values),
                4 | 5 => aligner.push_slow(index, stamp, values[0]),
                _ => {
                    aligner.set_follower_period(index, period);
                    aligner.set_slow_period(index, period);
                    Ok(())
                }
            };
            if near % 3 != 0 {
                while let Some(row) = aligner.pop() {
                    out += 1;
                    for follower in row.followers {
                        prop_assert_eq!(follower.weight.is_some(), follower.values.iter().all(|v| v.is_finite()));
                        prop_assert!(follower.weight.is_none_or(|weight| weight <= 1 << 24));
                    }
                    for slow in row.slow {
                        prop_assert_eq!(slow.age.is_some(), slow.value.is_finite());
                        prop_assert!(slow.age.is_none_or(|age| age >= 0));
                    }
                }
            }
        }
        while aligner.flush().is_some() {
            out += 1;
        }
        let counts = aligner.counts(Stream::Lead);
        prop_assert_eq!(pushed, out + counts.refused + counts.dropped);
    }
}
