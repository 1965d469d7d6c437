//! ArduPilot DataFlash: messages that begin with A3 95, with the layout of FMT messages.

use super::Flight;

fn message(log: &mut Vec<u8>, kind: u8, fields: &[&[u8]]) {
    log.extend([0xa3, 0x95, kind]);
    fields.iter().for_each(|field| log.extend(*field));
}

fn padded<const N: usize>(text: &str) -> [u8; N] {
    let mut bytes = [0; N];
    bytes[..text.len()].copy_from_slice(text.as_bytes());
    bytes
}

/// Log of a flight with these parameters, in messages IMU (all six axes and the temperature) or, if `raw`, ACC and GYR
/// with an IMU of every tenth sample. A second IMU has the same samples.
pub fn dataflash(flight: &Flight, parameters: &[(&str, f32)], raw: bool) -> Vec<u8> {
    dataflash_of([flight; 2], parameters, raw)
}

/// The same with the samples of two IMUs, which have the timestamps of the first.
pub fn dataflash_of(imus: [&Flight; 2], parameters: &[(&str, f32)], raw: bool) -> Vec<u8> {
    let [flight, _] = imus;
    let mut log = Vec::new();
    let formats: [(u8, u8, &str, &str, &str); 6] = [
        (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        (32, 35, "PARM", "QNff", "TimeUS,Name,Value,Default"),
        (162, 57, "IMU", "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
        (160, 32, "ACC", "QBQfff", "TimeUS,I,SampleUS,AccX,AccY,AccZ"),
        (161, 32, "GYR", "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ"),
        (10, 11, "ATT", "Qc", "TimeUS,Roll"),
    ];
    for (kind, length, name, format, labels) in formats {
        // Sum of the sizes of the format's letters.
        let length = match name {
            "PARM" => 3 + 8 + 16 + 4 + 4,
            "IMU" => 3 + 8 + 1 + 6 * 4 + 3 * 4 + 2 + 4,
            "ACC" | "GYR" => 3 + 8 + 1 + 8 + 12,
            "ATT" => 3 + 8 + 2,
            _ => length,
        };
        let fields: [&[u8]; 5] =
            [&[kind], &[length], &padded::<4>(name), &padded::<16>(format), &padded::<64>(labels)];
        message(&mut log, 128, &fields);
    }
    for (name, value) in parameters {
        let zero = 0.0_f32.to_le_bytes();
        message(&mut log, 32, &[&1000_u64.to_le_bytes(), &padded::<16>(name), &value.to_le_bytes(), &zero]);
    }
    for sample in 0..flight.len() {
        let stamp = flight.stamps_us[sample].to_le_bytes();
        let later = (flight.stamps_us[sample] + 700).to_le_bytes();
        let triad =
            |values: [f32; 3]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
        let (force, turn) = (triad(flight.acceleration[sample]), triad(flight.rate[sample]));
        if raw {
            message(&mut log, 160, &[&later, &[0], &stamp, &force]);
            message(&mut log, 161, &[&later, &[0], &stamp, &turn]);
        }
        if !raw || sample % 10 == 0 {
            for (instance, imu) in (0_u8..).zip(imus) {
                let (force, turn) = (triad(imu.acceleration[sample]), triad(imu.rate[sample]));
                let temperature = imu.temperature[sample].to_le_bytes();
                let fields: [&[u8]; 7] =
                    [&stamp, &[instance], &turn, &force, &[0; 8], &temperature, &[1, 1, 0, 0, 0, 0]];
                message(&mut log, 162, &fields);
            }
        }
        message(&mut log, 10, &[&stamp, &123_i16.to_le_bytes()]);
    }
    log
}

/// Log of a flight in the form of ArduPilot of 2014: timestamps in ms, and a separate message for the second IMU, whose
/// gyro has another bias.
pub fn dataflash_of_2014(flight: &Flight) -> Vec<u8> {
    let mut log = Vec::new();
    let formats: [(u8, u8, &str, &str, &str); 4] = [
        (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        (129, 3 + 16 + 4, "PARM", "Nf", "Name,Value"),
        (131, 3 + 4 + 6 * 4 + 4, "IMU", "Ifffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,Temp"),
        (135, 3 + 4 + 6 * 4, "IMU2", "Iffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    ];
    for (kind, length, name, format, labels) in formats {
        let fields: [&[u8]; 5] =
            [&[kind], &[length], &padded::<4>(name), &padded::<16>(format), &padded::<64>(labels)];
        message(&mut log, 128, &fields);
    }
    for sample in 0..flight.len() {
        let stamp = ((flight.stamps_us[sample] / 1000) as u32).to_le_bytes();
        let triad =
            |values: [f32; 3]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
        let (force, turn) = (triad(flight.acceleration[sample]), triad(flight.rate[sample]));
        let other = triad(flight.rate[sample].map(|rate| rate + 0.5));
        message(&mut log, 131, &[&stamp, &turn, &force, &0.0_f32.to_le_bytes()]);
        message(&mut log, 135, &[&stamp, &other, &force]);
    }
    log
}
