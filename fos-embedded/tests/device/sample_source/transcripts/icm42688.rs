//! Traffic on the SPI bus of an ICM-42688-P. Register values are from its data sheet.

use super::{Faults, Polls, RawSample, Read, SourceError, Step, Wait, Write, icm42688, sample};

/// Register and value, in the order of writing.
const CONFIGURATION: [(u8, u8); 9] = [
    (0x4c, 0x33), // INTF_CONFIG0: big endian, no I2C
    (0x4f, 0x47), // GYRO_CONFIG0: ±500 dps, 200 Hz
    (0x50, 0x47), // ACCEL_CONFIG0: ±4 g, 200 Hz
    (0x54, 0x29), // TMST_CONFIG: 16 µs
    (0x62, 0x00), // FSYNC_CONFIG
    (0x5f, 0x0f), // FIFO_CONFIG1: all four
    (0x4e, 0x0f), // PWR_MGMT0: both in low-noise mode
    (0x60, 0x00), // FIFO_CONFIG2
    (0x16, 0x40), // FIFO_CONFIG: stream
];

fn set_up() -> Vec<Step> {
    let mut steps = vec![Write(0x76, vec![0]), Read(0x75, vec![0x47]), Write(0x11, vec![0x01]), Wait(2000)];
    for (register, value) in CONFIGURATION {
        steps.push(Write(register, vec![value]));
        if register == 0x4e {
            steps.push(Wait(1000));
        }
    }
    steps.extend(CONFIGURATION.map(|(register, value)| Read(register, vec![value])));
    steps
}

/// Registers INTF_CONFIG0 to TMST_CONFIG.
fn watch() -> Step {
    Read(0x4c, vec![0x33, 0x91, 0x0f, 0x47, 0x47, 0x16, 0x11, 0x0d, 0x29])
}

/// Temperature, INT_STATUS and the number of bytes in the FIFO.
fn status(temperature: i16, flags: u8, bytes: u16) -> Step {
    let data = [0; 14];
    Read(0x1d, [&temperature.to_be_bytes()[..], &data, &[flags], &bytes.to_be_bytes()].concat())
}

fn packet_with(header: u8, n: i16, sample: &RawSample) -> Vec<u8> {
    let words = [sample.accel, sample.gyro].concat();
    let words = words.into_iter().flat_map(i16::to_be_bytes).collect();
    // 293 counts per sample; the clock wraps after tick 2
    let stamp = (i32::from(n) * 293 - 800) as u16;
    [vec![header], words, vec![0xfc], stamp.to_be_bytes().to_vec()].concat()
}

fn packet(n: i16) -> Vec<u8> {
    packet_with(0x68, n, &sample(n))
}

fn burst(packets: Vec<u8>) -> Vec<Step> {
    let mut steps = vec![watch(), status(-256, 0, packets.len() as u16)];
    steps.extend(packets.chunks(128).map(|chunk| Read(0x30, chunk.to_vec())));
    steps
}

/// Runs the set-up and a first poll with tick 0, then `steps`.
fn polls(polls: usize, steps: Vec<Step>) -> (Polls, super::Counts) {
    let (mut result, counts) = icm42688(polls + 2, &[set_up(), burst(packet(0)), steps].concat());
    assert_eq!(result.drain(..2).collect::<Polls>(), [Ok(vec![]), Ok(vec![sample(0)])]);
    (result, counts)
}

#[test]
fn every_packet_is_a_sample() {
    let (result, counts) = polls(1, burst((1..=10).flat_map(packet).collect()));
    assert_eq!(result, [Ok((1..=10).map(sample).collect())]);
    assert_eq!((counts.samples, counts.damaged), (11, 0));
}

#[test]
fn no_samples_before_the_sensors_have_started() {
    let none = [i16::MIN; 3];
    let first = packet_with(0x6b, -2, &RawSample { accel: none, gyro: none, ..sample(-2) });
    let second = packet_with(0x68, -1, &RawSample { gyro: none, ..sample(-1) });
    let steps = [set_up(), burst([first, second, packet(0)].concat())].concat();
    let (result, counts) = icm42688(2, &steps);
    assert_eq!(result, [Ok(vec![]), Ok(vec![sample(0)])]);
    assert_eq!(counts.damaged, 0);
}

#[test]
fn packets_that_are_none_are_dropped() {
    let empty = [&[0x80; 16][..], &[0xff; 16], &[0; 16]].concat();
    let mut cut = packet(2);
    cut[9..].fill(0xff);
    let (result, counts) = polls(1, burst([packet(1), empty, cut, packet(3)].concat()));
    let after = RawSample { skipped: 1, faults: Faults::BUS | Faults::GAP, ..sample(3) };
    assert_eq!(result, [Ok(vec![sample(1), after])]);
    assert_eq!((counts.damaged, counts.gaps), (4, 1));
}

#[test]
fn overruns_and_a_missing_temperature_are_flagged() {
    let steps = [watch(), status(i16::MIN, 0x0a, 16), Read(0x30, packet(9))];
    let (result, counts) = polls(1, steps.to_vec());
    let faults = Faults::OVERRUN | Faults::GAP | Faults::TEMPERATURE;
    assert_eq!(result, [Ok(vec![RawSample { skipped: 8, faults, temperature: None, ..sample(9) }])]);
    assert_eq!((counts.overruns, counts.temperature), (1, 1));
}

#[test]
fn another_part_is_not_set_up() {
    let other = vec![Write(0x76, vec![0]), Read(0x75, vec![0xe9])];
    let (result, counts) = icm42688(2, &[other, set_up()].concat());
    assert_eq!(result, [Err(SourceError::WrongPart(0xe9)), Ok(vec![])]);
    assert_eq!(counts.wrong_part, 1);
}
