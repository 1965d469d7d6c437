//! Logs of wearable devices, by their published layouts: pages of text (GENEActiv), blocks of 512 bytes (Axivity).

use std::fmt::Write as _;

use super::Flight;

const G: f64 = 9.80665;

/// Splits the samples of a flight into blocks of at most `most`, none of which contains a gap.
fn blocks(flight: &Flight, most: usize) -> Vec<std::ops::Range<usize>> {
    let period_us = flight.stamps_us[1] - flight.stamps_us[0];
    let mut blocks: Vec<std::ops::Range<usize>> = Vec::new();
    for sample in 0..flight.len() {
        let goes_on = sample > 0 && flight.stamps_us[sample] - flight.stamps_us[sample - 1] == period_us;
        match blocks.last_mut().filter(|block| goes_on && block.len() < most) {
            Some(block) => block.end += 1,
            None => blocks.push(sample..sample + 1),
        }
    }
    blocks
}

fn clock(us: u64) -> (u64, u64, u64, u64) {
    (us / 3_600_000_000, us / 60_000_000 % 60, us / 1_000_000 % 60, us % 1_000_000)
}

/// Log of a GENEActiv at 200 Hz: accelerometers only, in steps of 4 mg.
pub fn geneactiv(flight: &Flight) -> Vec<u8> {
    const GAIN: [f64; 3] = [25_344.0, 25_870.0, 25_470.0];
    const OFFSET: [f64; 3] = [1104.0, 454.0, -1433.0];
    let mut text = "Device Identity\r\nDevice Unique Serial Code:012345\r\nDevice Type:GENEActiv\r\nDevice Model:1.1\r\n\r\nConfiguration Info\r\nMeasurement Frequency:200 Hz\r\n\r\nCalibration Data\r\n".to_owned();
    for (axis, (gain, offset)) in ["x", "y", "z"].iter().zip(GAIN.iter().zip(OFFSET)) {
        let _ = write!(text, "{axis} gain:{gain}\r\n{axis} offset:{offset}\r\n");
    }
    text.push_str("Volts:300\r\nLux:800\r\n\r\nMemory Status\r\nNumber of Pages:7\r\n\r\n");
    for (number, block) in blocks(flight, 300).into_iter().enumerate() {
        let (hour, minute, second, us) = clock(flight.stamps_us[block.start]);
        let _ = write!(
            text,
            "Recorded Data\r\nDevice Unique Serial Code:012345\r\nSequence Number:{number}\r\nPage Time:2024-02-29 {hour:02}:{minute:02}:{second:02}:{:03}\r\nUnassigned:\r\nTemperature:{:.1}\r\nBattery voltage:4.1\r\nDevice Status:Recording\r\nMeasurement Frequency:200.0\r\n",
            us / 1000,
            flight.temperature[block.start]
        );
        for sample in block {
            for axis in 0..3 {
                let g = f64::from(flight.acceleration[sample][axis]) / G;
                let raw = ((g * GAIN[axis] + OFFSET[axis]) / 100.0).round() as i64;
                let _ = write!(text, "{:03X}", raw & 0xfff);
            }
            text.push_str("03C");
        }
        text.push_str("\r\n");
    }
    text.into_bytes()
}

/// Storage format of an Axivity device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axivity {
    /// AX3, 10 bits an axis.
    Packed,
    /// AX3, 16 bits an axis.
    Unpacked,
    /// AX6, with gyro.
    WithGyro,
}

/// Log of an Axivity device at 200 Hz.
pub fn axivity(flight: &Flight, layout: Axivity) -> Vec<u8> {
    let (most, axes, scales) = match layout {
        Axivity::Packed => (120, 0x30, 0),
        Axivity::Unpacked => (80, 0x32, 0),
        // 1/2048 g and 250 °/s
        Axivity::WithGyro => (40, 0x62, 3_u16 << 13 | 5 << 10),
    };
    let counts_per_g = if layout == Axivity::WithGyro { 2048.0 } else { 256.0 };
    let mut log = vec![0xff; 1024];
    log[..4].copy_from_slice(b"MD\xfc\x03");
    // an annotation without text
    log[64..512].fill(b' ');
    log[4] = if layout == Axivity::WithGyro { 0x64 } else { 0x17 };
    for (number, block) in blocks(flight, most).into_iter().enumerate() {
        let (hour, minute, second, us) = clock(flight.stamps_us[block.start]);
        let fraction = us as f64 / 1e6;
        let bits = (fraction * 32_768.0).round().min(32_767.0);
        let offset = -(bits / 32_768.0 * 200.0).floor() as i16;
        let packed =
            24_u32 << 26 | 2 << 22 | 29 << 17 | (hour as u32) << 12 | (minute as u32) << 6 | second as u32;
        let celsius = f64::from(flight.temperature[block.start]);
        let temperature = ((celsius + 50.0) * 256.0 / 75.0).round() as u16;
        let mut bytes = Vec::with_capacity(512);
        bytes.extend(b"AX\xfc\x01");
        bytes.extend((0x8000 | bits as u16).to_le_bytes());
        bytes.extend(7_u32.to_le_bytes());
        bytes.extend((number as u32).to_le_bytes());
        bytes.extend(packed.to_le_bytes());
        bytes.extend((scales | 100).to_le_bytes());
        bytes.extend(temperature.to_le_bytes());
        bytes.extend([0, 200, 11, axes]);
        bytes.extend(offset.to_le_bytes());
        bytes.extend((block.len() as u16).to_le_bytes());
        for sample in block {
            let counts =
                flight.acceleration[sample].map(|a| (f64::from(a) / G * counts_per_g).round() as i32);
            let rates =
                flight.rate[sample].map(|w| (f64::from(w).to_degrees() / 250.0 * 32_768.0).round() as i16);
            match layout {
                Axivity::Packed => {
                    // the smallest exponent with which all three fit in ten bits
                    let exponent =
                        (0..4).find(|e| counts.iter().all(|c| (-512..512).contains(&(c >> e)))).unwrap_or(3);
                    let [x, y, z] = counts.map(|count| (count >> exponent) as u32 & 0x3ff);
                    bytes.extend((exponent << 30 | z << 20 | y << 10 | x).to_le_bytes());
                }
                Axivity::Unpacked => {
                    counts.iter().for_each(|count| bytes.extend((*count as i16).to_le_bytes()))
                }
                Axivity::WithGyro => {
                    rates.iter().for_each(|rate| bytes.extend(rate.to_le_bytes()));
                    counts.iter().for_each(|count| bytes.extend((*count as i16).to_le_bytes()));
                }
            }
        }
        bytes.resize(510, 0);
        let sum = bytes
            .chunks_exact(2)
            .fold(0_u16, |sum, two| sum.wrapping_add(u16::from_le_bytes([two[0], two[1]])));
        bytes.extend(0_u16.wrapping_sub(sum).to_le_bytes());
        log.extend(bytes);
    }
    log
}
