//! Traffic on the SPI bus of a BMI323. Register values are from its data sheet.

use super::{Faults, Polls, RawSample, Read, SourceError, Step, Wait, Write, bmi323, bytes, sample};

/// A read, whose data follow a dummy byte.
fn read(register: u8, data: Vec<u8>) -> Step {
    Read(register, [vec![0xa5], data].concat())
}

fn id(id: u8) -> Vec<Step> {
    let id = read(0x00, vec![id, 0]);
    vec![Write(0x7e, vec![0xaf, 0xde]), Wait(2000), id.clone(), Wait(250), id]
}

/// `acc_conf` and `gyr_conf`: high performance, ±4 g, ±500 dps, 200 Hz; `fifo_watermark` and `fifo_conf`: all four.
fn watch() -> [Step; 4] {
    [
        read(0x20, vec![0x19, 0x70]),
        read(0x21, vec![0x29, 0x70]),
        read(0x35, vec![0, 0]),
        read(0x36, vec![0x00, 0x0f]),
    ]
}

fn set_up() -> Vec<Step> {
    let mut steps = id(0x43);
    steps.extend([
        read(0x01, vec![0, 0]),
        read(0x02, vec![1, 0]),
        Write(0x35, vec![0, 0]),
        Write(0x36, vec![0x00, 0x0f]),
        Write(0x20, vec![0x19, 0x70]),
        Write(0x21, vec![0x29, 0x70]),
        Write(0x37, vec![1, 0]),
    ]);
    steps.extend(watch());
    steps
}

/// Timestamp; the clock wraps after tick 2.
fn stamp(n: i16) -> i16 {
    (i32::from(n) * 128 - 300) as u16 as i16
}

fn words(n: i16, sample: &RawSample) -> Vec<u8> {
    let temperature = sample.temperature.unwrap_or(i16::MIN);
    bytes(&[&sample.accel[..], &sample.gyro, &[temperature, stamp(n)]].concat())
}

fn frame(n: i16) -> Vec<u8> {
    words(n, &sample(n))
}

fn level(frames: u16) -> Step {
    read(0x15, (frames * 8).to_le_bytes().to_vec())
}

fn burst(frames: Vec<u8>) -> Vec<Step> {
    let mut steps = watch().to_vec();
    steps.push(level((frames.len() / 16) as u16));
    steps.extend(frames.chunks(128).map(|chunk| read(0x16, chunk.to_vec())));
    steps
}

/// Runs the set-up and a first poll with tick 0, then `steps`.
fn polls(polls: usize, steps: Vec<Step>) -> (Polls, super::Counts) {
    let (mut result, counts) = bmi323(polls + 2, &[set_up(), burst(frame(0)), steps].concat());
    assert_eq!(result.drain(..2).collect::<Polls>(), [Ok(vec![]), Ok(vec![sample(0)])]);
    (result, counts)
}

#[test]
fn every_eight_words_make_a_sample() {
    let (result, counts) = polls(1, burst((1..=10).flat_map(frame).collect()));
    assert_eq!(result, [Ok((1..=10).map(sample).collect())]);
    assert_eq!(counts.samples, 11);
}

#[test]
fn no_samples_before_the_sensor_is_ready() {
    let mut no_accel = frame(-2);
    no_accel[..2].copy_from_slice(&[0x01, 0x7f]);
    let mut no_gyro = frame(-1);
    no_gyro[6..8].copy_from_slice(&[0x02, 0x7f]);
    let frames = [no_accel, no_gyro, frame(0)].concat();
    let (result, counts) = bmi323(2, &[set_up(), burst(frames)].concat());
    assert_eq!(result, [Ok(vec![]), Ok(vec![sample(0)])]);
    assert_eq!(counts.damaged, 0);
}

#[test]
fn at_most_8_frames_per_transfer_and_32_samples_per_poll() {
    let frames: Vec<u8> = (1..=41).flat_map(frame).collect();
    let mut steps = watch().to_vec();
    steps.push(level(41));
    let (now, later) = frames.split_at(32 * 16);
    steps.extend(now.chunks(128).map(|chunk| read(0x16, chunk.to_vec())));
    steps.extend(burst(later.to_vec()));
    let (result, _) = polls(2, steps);
    assert_eq!(result, [Ok((1..=32).map(sample).collect()), Ok((33..=41).map(sample).collect())]);
}

#[test]
fn fewer_frames_than_announced_are_missing() {
    let frames = [frame(1), frame(2), [0x00, 0x80].repeat(8)].concat();
    let (result, counts) = polls(2, [burst(frames), burst(frame(4))].concat());
    let faults = Faults::BUS | Faults::GAP;
    let after = RawSample { skipped: 1, faults, ..sample(4) };
    assert_eq!(result, [Ok(vec![sample(1), sample(2)]), Ok(vec![after])]);
    assert_eq!((counts.damaged, counts.gaps, counts.skipped), (1, 1, 1));
}

#[test]
fn frame_that_is_cut_short_is_dropped() {
    let mut cut = frame(2);
    cut[9..].fill(0xff);
    let (result, counts) = polls(1, burst([frame(1), cut, vec![0xff; 16], vec![0; 16], frame(3)].concat()));
    let after = RawSample { skipped: 1, faults: Faults::BUS | Faults::GAP, ..sample(3) };
    assert_eq!(result, [Ok(vec![sample(1), after])]);
    assert_eq!((counts.damaged, counts.gaps), (3, 1));
}

#[test]
fn duplicate_frame_is_one_sample() {
    let (result, counts) = polls(1, burst([frame(1), frame(1), frame(2)].concat()));
    let after = RawSample { faults: Faults::BUS, ..sample(2) };
    assert_eq!(result, [Ok(vec![sample(1), after])]);
    assert_eq!((counts.damaged, counts.gaps), (1, 0));
}

#[test]
fn overrun_gap_is_counted_by_the_sensor_clock() {
    let frames: Vec<u8> = (21..=52).flat_map(frame).collect();
    let mut steps = watch().to_vec();
    steps.push(level(128));
    steps.extend(frames.chunks(128).map(|chunk| read(0x16, chunk.to_vec())));
    let (result, counts) = polls(1, steps);
    let Ok(samples) = &result[0] else { panic!("{result:?}") };
    let faults = Faults::OVERRUN | Faults::GAP;
    assert_eq!(samples[0], RawSample { skipped: 20, faults, ..sample(21) });
    assert_eq!(samples[1..], (22..=52).map(sample).collect::<Vec<_>>());
    assert_eq!(counts.overruns, 1);
}

#[test]
fn another_part_is_an_error() {
    let (result, counts) = bmi323(2, &[id(0x24), set_up()].concat());
    assert_eq!(result, [Err(SourceError::WrongPart(0x24)), Ok(vec![])]);
    assert_eq!(counts.wrong_part, 1);
}

#[test]
fn flags_invalid_temperatures() {
    let cold = |n| RawSample { temperature: None, faults: Faults::TEMPERATURE, ..sample(n) };
    let frames = [frame(1), words(2, &cold(2)), frame(3)].concat();
    let (result, counts) = polls(1, burst(frames));
    assert_eq!(result, [Ok(vec![sample(1), cold(2), sample(3)])]);
    assert_eq!(counts.temperature, 1);
}
