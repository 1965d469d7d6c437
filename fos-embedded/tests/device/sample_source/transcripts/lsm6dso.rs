//! Traffic on the I2C bus of an LSM6DSO. Register values are from its data sheet; the words in its FIFO are those of the
//! LSM6DSV16X, with a parity.

use super::{Faults, RawSample, Read, SourceError, Step, Wait, Write, bytes, lsm6dso, sample};

/// Register and value, in the order of writing.
const CONFIGURATION: [(u8, u8); 13] = [
    (0x01, 0x00), // FUNC_CFG_ACCESS: main bank
    (0x12, 0x44), // CTRL3_C: BDU, IF_INC
    (0x13, 0x08), // CTRL4_C: no data before the filters have settled
    (0x15, 0x00), // CTRL6_C: high performance of the accelerometer
    (0x16, 0x00), // CTRL7_G: high performance of the gyro
    (0x17, 0x00), // CTRL8_XL: no filter
    (0x18, 0xe2), // CTRL9_XL: no I3C
    (0x19, 0x20), // CTRL10_C: timestamps
    (0x08, 0x00), // FIFO_CTRL2
    (0x09, 0x55), // FIFO_CTRL3: both batched at 208 Hz
    (0x10, 0x58), // CTRL1_XL: 208 Hz, ±4 g
    (0x11, 0x54), // CTRL2_G: 208 Hz, ±500 dps
    (0x0a, 0x66), // FIFO_CTRL4: timestamps 1:1, temperature 12.5 Hz, continuous
];

fn set_up() -> Vec<Step> {
    let mut steps =
        vec![Read(0x0f, vec![0x6c]), Write(0x01, vec![0x00]), Write(0x12, vec![0x05]), Wait(20_000)];
    steps.extend(CONFIGURATION.map(|(register, value)| Write(register, vec![value])));
    steps.extend(CONFIGURATION.map(|(register, value)| Read(register, vec![value])));
    steps
}

/// Registers FIFO_CTRL1 to CTRL10_C.
fn watch() -> Step {
    let mut registers = [0; 19];
    registers[0x0f - 0x07] = 0x6c;
    for (register, value) in CONFIGURATION {
        if let Some(place) = registers.get_mut(usize::from(register).wrapping_sub(0x07)) {
            *place = value;
        }
    }
    Read(0x07, registers.to_vec())
}

fn word(tag: u8, counter: i16, data: &[i16]) -> Vec<u8> {
    let tag = tag << 3 | (counter as u8 & 3) << 1;
    [vec![tag | (tag.count_ones() % 2) as u8], bytes(data)].concat()
}

fn all(n: i16) -> Vec<u8> {
    // 192 counts per sample
    let stamp = [(n as u16).wrapping_mul(192) as i16, 0, 0];
    [word(1, n, &sample(n).gyro), word(2, n, &sample(n).accel), word(4, n, &stamp)].concat()
}

fn burst(words: Vec<u8>) -> [Step; 3] {
    [watch(), Read(0x3a, vec![(words.len() / 7) as u8, 0]), Read(0x78, words)]
}

#[test]
fn set_up_and_samples() {
    let temperature = word(3, 0, &[-256, 0, 0]);
    let first = [temperature, all(0), all(1)].concat();
    let (result, counts) = lsm6dso(2, &[set_up(), burst(first).to_vec()].concat());
    assert_eq!(result, [Ok(vec![]), Ok(vec![sample(0), sample(1)])]);
    assert_eq!((counts.samples, counts.damaged, counts.gaps), (2, 0, 0));
}

#[test]
fn level_has_ten_bits_and_overruns_are_flagged() {
    let words = [word(3, 1, &[-256, 0, 0]), (1..=32).flat_map(all).collect()].concat();
    let mut steps = [set_up(), vec![watch(), Read(0x3a, vec![0xff, 0x49])]].concat();
    let (now, later) = words.split_at(96 * 7);
    steps.extend(now.chunks(32 * 7).map(|chunk| Read(0x78, chunk.to_vec())));
    // the temperature takes a word, so one more transfer is needed for 32 samples
    steps.push(Read(0x78, [later.to_vec(), word(1, 33, &[0; 3]), word(2, 33, &[0; 3])].concat()));
    let (result, counts) = lsm6dso(2, &steps);
    let mut samples: Vec<RawSample> = (1..=32).map(sample).collect();
    samples[0].faults = Faults::OVERRUN;
    assert_eq!(result, [Ok(vec![]), Ok(samples)]);
    assert_eq!(counts.overruns, 1);
}

#[test]
fn does_not_write_to_another_part() {
    let (result, counts) = lsm6dso(2, &[vec![Read(0x0f, vec![0x70])], set_up()].concat());
    assert_eq!(result, [Err(SourceError::WrongPart(0x70)), Ok(vec![])]);
    assert_eq!(counts.wrong_part, 1);
}
