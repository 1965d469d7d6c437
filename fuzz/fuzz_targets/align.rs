//! Streams with any timestamps and values, in any order and batches: every lost row is counted, and as long as no
//! timestamp is refused and no queue was full, every row has the bits that a twin computes from whole streams.
#![no_main]

use fos_core::align::{Aligner, Held, Interpolated, Stream};
use fos_fuzz::align_twin::{bits, follower, same, slow};
use fos_fuzz::drawn::events;
use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;

const DEPTH: usize = 8;

type Row = (i64, [Interpolated<f32>; 2], Held<f32>);

/// An event; a timestamp is relative to the previous one of its stream.
enum Event {
    Lead(i64, [f32; 3]),
    Follower(usize, i64, [f32; 3]),
    Slow(i64, f32),
    Pop,
}

fn event(bytes: &mut Unstructured<'_>) -> Result<Event> {
    let kind = bytes.int_in_range(0..=15_u8)?;
    let wait = |bytes: &mut Unstructured<'_>| match bytes.arbitrary::<u8>()? {
        255 => bytes.arbitrary::<i64>(),
        few => Ok(i64::from(few)),
    };
    Ok(match kind {
        0..5 => Event::Lead(wait(bytes)?, bytes.arbitrary()?),
        5..12 => Event::Follower(usize::from(kind & 1), wait(bytes)?, bytes.arbitrary()?),
        12..14 => Event::Slow(wait(bytes)?, bytes.arbitrary()?),
        _ => Event::Pop,
    })
}

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Unstructured::new(bytes);
    let Ok(periods) = bytes.arbitrary::<[u16; 3]>() else { return };
    let periods = periods.map(i64::from);
    let mut aligner = Aligner::<f32, 2, 1, DEPTH>::new([periods[0], periods[1]], [periods[2]]);
    let (mut followers, mut held) = ([Vec::new(), Vec::new()], Vec::new());
    let (mut at, mut pushed, mut out) = ([0_i64; 4], 0, Vec::<Row>::new());
    // A row was emitted before all its data had arrived.
    let mut early = false;
    for event in events(&mut bytes, event) {
        match event {
            Event::Lead(wait, values) => {
                at[0] = at[0].wrapping_add(wait);
                pushed += 1;
                let _ = aligner.push_lead(at[0], values);
                early |= pushed - out.len() >= DEPTH;
            }
            Event::Follower(index, wait, values) => {
                at[1 + index] = at[1 + index].wrapping_add(wait);
                followers[index].push((at[1 + index], values));
                let _ = aligner.push_follower(index, at[1 + index], values);
            }
            Event::Slow(wait, value) => {
                at[3] = at[3].wrapping_add(wait);
                held.push((at[3], value));
                early |= out.last().is_some_and(|(stamp, ..)| at[3] <= *stamp);
                let _ = aligner.push_slow(0, at[3], value);
            }
            Event::Pop => {
                let rows = std::iter::from_fn(|| aligner.pop());
                out.extend(rows.map(|row| (row.stamp, row.followers, row.slow[0])));
            }
        }
    }
    let rows = std::iter::from_fn(|| aligner.flush());
    out.extend(rows.map(|row| (row.stamp, row.followers, row.slow[0])));
    let streams = [Stream::Lead, Stream::Follower(0), Stream::Follower(1), Stream::Slow(0)];
    let counts = streams.map(|stream| aligner.counts(stream));
    assert_eq!(pushed, out.len() + (counts[0].refused + counts[0].dropped) as usize);
    for (_, found, held) in &out {
        for found in found {
            assert_eq!(found.weight.is_some(), found.values.iter().all(|value| value.is_finite()));
        }
        assert_eq!(held.age.is_some(), held.value.is_finite());
    }
    if early || counts.iter().any(|counts| counts.refused + counts.dropped + counts.set_back > 0) {
        return;
    }
    for (stamp, found, newest) in &out {
        for (index, found) in found.iter().enumerate() {
            let expected = follower(&followers[index], periods[index], *stamp);
            assert!(same(found, &expected), "{found:?}, not {expected:?}");
        }
        let expected = slow(&held, periods[2], *stamp);
        assert_eq!((newest.age, bits(newest.value)), (expected.age, bits(expected.value)));
    }
});
