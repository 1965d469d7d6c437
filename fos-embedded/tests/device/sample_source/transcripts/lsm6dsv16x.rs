//! Traffic on the I2C bus of an LSM6DSV16X. Register values are from its data sheet.

use super::{
    Faults, NoAnswer, Polls, RawSample, Read, SourceError, Step, Wait, Write, bytes, lsm6dsv16x, sample,
};

/// Register and value, in the order of writing.
const CONFIGURATION: [(u8, u8); 13] = [
    (0x01, 0x00), // FUNC_CFG_ACCESS: main bank
    (0x12, 0x44), // CTRL3: BDU, IF_INC
    (0x13, 0x08), // CTRL4: no data before the filters have settled
    (0x15, 0x02), // CTRL6: ±500 dps
    (0x17, 0x01), // CTRL8: ±4 g
    (0x18, 0x00), // CTRL9: no user offset, no filter
    (0x62, 0x02), // HAODR_CFG: the set with 200 Hz
    (0x50, 0x40), // FUNCTIONS_ENABLE: timestamps
    (0x08, 0x00), // FIFO_CTRL2
    (0x09, 0x77), // FIFO_CTRL3: both batched at their rate
    (0x10, 0x17), // CTRL1: high accuracy, 200 Hz
    (0x11, 0x17), // CTRL2: high accuracy, 200 Hz
    (0x0a, 0x66), // FIFO_CTRL4: timestamps 1:1, temperature 15 Hz, continuous
];

fn set_up() -> Vec<Step> {
    let mut steps = vec![Read(0x0f, vec![0x70]), Write(0x01, vec![0x04]), Wait(50_000)];
    steps.extend(CONFIGURATION.map(|(register, value)| Write(register, vec![value])));
    steps.extend(CONFIGURATION.map(|(register, value)| Read(register, vec![value])));
    steps
}

/// Check of the registers FIFO_CTRL1 to CTRL10.
fn watch() -> Step {
    let mut registers = [0; 19];
    registers[0x0f - 0x07] = 0x70;
    for (register, value) in CONFIGURATION {
        if let Some(place) = registers.get_mut(usize::from(register).wrapping_sub(0x07)) {
            *place = value;
        }
    }
    Read(0x07, registers.to_vec())
}

fn level(words: u8) -> Step {
    Read(0x1b, vec![words, 0])
}

fn word(tag: u8, counter: i16, data: &[i16]) -> Vec<u8> {
    [vec![tag << 3 | (counter as u8 & 3) << 1 | 1], bytes(data)].concat()
}

fn accel(n: i16) -> Vec<u8> {
    word(2, n, &sample(n).accel)
}

fn gyro(n: i16) -> Vec<u8> {
    word(1, n, &sample(n).gyro)
}

fn temperature(n: i16) -> Vec<u8> {
    word(3, n, &[-256, 0, 0])
}

/// Timestamp word; the clock wraps after tick 2.
fn stamp(n: i16) -> Vec<u8> {
    let stamp = (f64::from(n) * 230.4) as u32;
    let [a, b, c, d] = stamp.wrapping_sub(500).to_le_bytes();
    word(4, n, &[i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d]), 0])
}

fn all(n: i16) -> Vec<u8> {
    [gyro(n), accel(n), stamp(n)].concat()
}

fn burst(words: Vec<u8>) -> [Step; 3] {
    [watch(), level((words.len() / 7) as u8), Read(0x78, words)]
}

/// Runs the set-up and a first poll with tick 0, then `steps`.
fn polls(polls: usize, steps: Vec<Step>) -> (Polls, super::Counts) {
    let first = burst([temperature(0), all(0)].concat()).to_vec();
    let (mut result, counts) = lsm6dsv16x(polls + 2, &[set_up(), first, steps].concat());
    assert_eq!(result.drain(..2).collect::<Polls>(), [Ok(vec![]), Ok(vec![sample(0)])]);
    (result, counts)
}

#[test]
fn words_of_one_instant_make_a_sample_in_any_order() {
    let words = [
        vec![accel(1), gyro(1), stamp(1)],
        vec![stamp(2), gyro(2), accel(2)],
        // the last word comes with the next poll
        vec![accel(3), stamp(3)],
    ];
    let mut steps = burst(words.concat().concat()).to_vec();
    steps.extend(burst([gyro(3), all(4), all(5), all(6), all(7)].concat()));
    let (result, counts) = polls(2, steps);
    let samples = |ticks: core::ops::RangeInclusive<i16>| Ok(ticks.map(sample).collect());
    assert_eq!(result, [samples(1..=2), samples(3..=7)]);
    assert_eq!(counts.samples, 8);
}

#[test]
fn no_samples_before_the_filters_have_settled() {
    let unsettled = |tag, n| word(tag, n, &[0x7ffd, 0x7fff, 0x7ffe]);
    let words = [
        // the gyro starts later
        vec![unsettled(2, -3), stamp(-3)],
        vec![unsettled(1, -2), unsettled(2, -2), stamp(-2)],
        vec![unsettled(1, -1), accel(-1), stamp(-1)],
        vec![temperature(0), all(0)],
    ];
    let steps = [set_up(), burst(words.concat().concat()).to_vec()].concat();
    let (result, counts) = lsm6dsv16x(2, &steps);
    assert_eq!(result, [Ok(vec![]), Ok(vec![sample(0)])]);
    assert_eq!(counts.damaged, 0);
}

#[test]
fn at_most_32_words_per_transfer_and_32_samples_per_poll() {
    let words: Vec<u8> = (1..=41).flat_map(all).collect();
    let mut steps = vec![watch(), level(123)];
    let (now, later) = words.split_at(96 * 7);
    steps.extend(now.chunks(32 * 7).map(|chunk| Read(0x78, chunk.to_vec())));
    steps.extend(burst(later.to_vec()));
    let (result, _) = polls(2, steps);
    assert_eq!(result, [Ok((1..=32).map(sample).collect()), Ok((33..=41).map(sample).collect())]);
}

#[test]
fn repeats_unanswered_transfers_after_1_and_2_ms() {
    let mut steps = vec![NoAnswer(0x07, 19), Wait(1000), watch(), NoAnswer(0x1b, 2), Wait(2000)];
    steps.extend(burst(all(1)));
    let (result, counts) = polls(1, steps);
    assert_eq!(result, [Ok(vec![RawSample { faults: Faults::BUS, ..sample(1) }])]);
    assert_eq!(counts.bus, 2);
}

#[test]
fn sets_up_again_with_increasing_delays() {
    let fail = [NoAnswer(0x07, 19), Wait(1000), NoAnswer(0x07, 19), Wait(2000), NoAnswer(0x07, 19)];
    let no_id = NoAnswer(0x0f, 1);
    let mut steps = fail.to_vec();
    steps.extend([no_id.clone(), no_id.clone()]);
    steps.extend(set_up());
    steps.extend(burst([temperature(9), all(9)].concat()));
    let (result, counts) = polls(9, steps);
    let nack = || Err(SourceError::Bus("NoAcknowledge(Address)".into()));
    let resting = |polls| Err(SourceError::Resting(polls));
    let faults = Faults::BUS | Faults::RESET | Faults::GAP;
    // 450 ms after the previous sample by the application's clock
    let sample = RawSample { skipped: 89, faults, ..sample(9) };
    let expected: Polls = vec![
        nack(),
        nack(),
        resting(1),
        nack(),
        resting(3),
        resting(2),
        resting(1),
        Ok(vec![]),
        Ok(vec![sample]),
    ];
    assert_eq!(result, expected);
    assert_eq!((counts.bus, counts.resets), (5, 1));
}

#[test]
fn fewer_words_than_announced_damage_a_sample() {
    let words = [all(1), gyro(2), accel(2), vec![0; 7], all(3)];
    let (result, counts) = polls(1, burst(words.concat()).to_vec());
    let faults = Faults::BUS | Faults::GAP;
    assert_eq!(result, [Ok(vec![sample(1), RawSample { skipped: 1, faults, ..sample(3) }])]);
    assert_eq!((counts.damaged, counts.gaps, counts.skipped), (2, 1, 1));
}

#[test]
fn word_that_is_cut_short_is_dropped_with_its_sample() {
    let mut cut = accel(2);
    cut[5..].fill(0xff);
    let words = [all(1), gyro(2), cut, vec![0xff; 7], all(3)];
    let (result, counts) = polls(1, burst(words.concat()).to_vec());
    let faults = Faults::BUS | Faults::GAP;
    assert_eq!(result, [Ok(vec![sample(1), RawSample { skipped: 1, faults, ..sample(3) }])]);
    assert_eq!((counts.damaged, counts.gaps), (2, 1));
}

#[test]
fn overrun_gap_is_counted_by_the_sensor_clock() {
    // the overwriting stopped in the middle of tick 21
    let words = [accel(21), stamp(21), all(22)].concat();
    let steps = [watch(), Read(0x1b, vec![5, 0x48]), Read(0x78, words)];
    let (result, counts) = polls(1, steps.to_vec());
    let faults = Faults::OVERRUN | Faults::GAP;
    assert_eq!(result, [Ok(vec![RawSample { skipped: 21, faults, ..sample(22) }])]);
    assert_eq!((counts.overruns, counts.damaged), (1, 0));
}

#[test]
fn does_not_write_to_another_part() {
    let (result, counts) = lsm6dsv16x(2, &[vec![Read(0x0f, vec![0x6c])], set_up()].concat());
    assert_eq!(result, [Err(SourceError::WrongPart(0x6c)), Ok(vec![])]);
    assert_eq!(counts.wrong_part, 1);
}

#[test]
fn reports_registers_that_do_not_hold_their_value() {
    let mut steps = set_up();
    let place = steps.len() - 10;
    assert!(matches!(&steps[place], Read(0x15, _)));
    steps.truncate(place);
    steps.push(Read(0x15, vec![0x04]));
    let (result, counts) = lsm6dsv16x(1, &steps);
    assert_eq!(result, [Err(SourceError::VerifyFailed { register: 0x15, written: 0x02, read: 0x04 })]);
    assert_eq!(counts.verify_failed, 1);
}

#[test]
fn twenty_equal_samples_are_stuck() {
    let held = |n: i16| [word(1, n, &sample(0).gyro), word(2, n, &sample(0).accel), stamp(n)].concat();
    let words: Vec<u8> = (1..=20).flat_map(held).collect();
    let mut steps = vec![watch(), level(60)];
    steps.extend(words.chunks(32 * 7).map(|chunk| Read(0x78, chunk.to_vec())));
    steps.extend(set_up());
    let (result, counts) = polls(2, steps);
    let Ok(samples) = &result[0] else { panic!("{result:?}") };
    // counting tick 0, the twentieth is tick 19
    let stuck: Vec<bool> = samples.iter().map(|sample| sample.faults == Faults::STUCK).collect();
    assert_eq!(stuck, (1..=20).map(|n| n >= 19).collect::<Vec<_>>());
    assert_eq!((counts.stuck, counts.resets), (2, 1));
}

#[test]
fn temperature_is_valid_for_one_second() {
    let mut steps = Vec::new();
    for poll in 0..22 {
        let words: Vec<u8> = (1..=10).flat_map(|n| all(10 * poll + n)).collect();
        steps.extend(burst(words[..30 * 7].to_vec()));
    }
    let (result, counts) = polls(22, steps);
    let samples = result.into_iter().flat_map(|poll| poll.expect("samples"));
    let known: Vec<bool> = samples
        .map(|sample| {
            assert_eq!(sample.temperature.is_none(), sample.faults == Faults::TEMPERATURE);
            sample.temperature.is_some()
        })
        .collect();
    assert_eq!(known, (1..=220).map(|n| n < 200).collect::<Vec<_>>());
    assert_eq!(counts.temperature, 21);
}

#[test]
fn sets_up_a_reset_sensor_at_once() {
    let mut reset = [0; 19];
    (reset[0x0f - 0x07], reset[0x12 - 0x07]) = (0x70, 0x04);
    let check = Read(0x07, reset.to_vec());
    // two checks, because the first may be damaged
    let mut steps = vec![check.clone(), watch(), level(0)];
    steps.extend([check.clone(), check]);
    steps.extend(set_up());
    steps.extend(burst([temperature(30), all(30)].concat()));
    let (result, counts) = polls(3, steps);
    let faults = Faults::RESET | Faults::GAP;
    let sample = RawSample { skipped: 29, faults, ..sample(30) };
    assert_eq!(result, [Ok(vec![]), Ok(vec![]), Ok(vec![sample])]);
    assert_eq!(counts.resets, 1);
}
