//! PX4 ULog, version 1: a header, definitions, data (PX4's document "ULog File Format").

use super::Flight;

/// Logging rate of the raw topics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rate {
    /// Every sample, in `sensor_accel` and `sensor_gyro`.
    Full,
    /// Once a second, with `sensor_combined` at the full rate, the default of PX4.
    Decimated,
    /// Every sample, in batches of ten.
    Fifo,
    /// In batches, from a version of PX4 that logs the samples in the sensor's axes, for a sensor rotated by 90°
    /// about z: its field `rotation` is 2.
    FifoOfTurned,
}

struct Log(Vec<u8>);

impl Log {
    fn message(&mut self, kind: u8, payload: &[u8]) {
        let length = u16::try_from(payload.len()).expect("a short message");
        self.0.extend(length.to_le_bytes());
        self.0.push(kind);
        self.0.extend(payload);
    }

    fn subscribe(&mut self, id: u16, instance: u8, name: &str) {
        let mut payload = vec![instance];
        payload.extend(id.to_le_bytes());
        payload.extend(name.as_bytes());
        self.message(b'A', &payload);
    }

    fn data(&mut self, id: u16, fields: &[&[u8]]) {
        let mut payload = id.to_le_bytes().to_vec();
        fields.iter().for_each(|field| payload.extend(*field));
        self.message(b'D', &payload);
    }
}

/// A log with separate subscriptions for every instance of a sensor: topic, instance, `device_id` and the samples. One
/// subscription may have samples of several devices.
pub fn ulog_of(sensors: &[(&str, u8, u32, &Flight)]) -> Vec<u8> {
    let mut log = Log(b"ULog\x01\x12\x35\x01".to_vec());
    log.0.extend(0_u64.to_le_bytes());
    log.message(b'B', &[0; 40]);
    for topic in ["sensor_accel", "sensor_gyro"] {
        let fields = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;";
        log.message(b'F', format!("{topic}:{fields}").as_bytes());
    }
    let mut subscribed: Vec<(&str, u8)> = Vec::new();
    let mut messages = Vec::new();
    for (topic, instance, device, flight) in sensors {
        let known = subscribed.iter().position(|known| *known == (*topic, *instance));
        let id = known.unwrap_or_else(|| {
            log.subscribe(subscribed.len() as u16, *instance, topic);
            subscribed.push((topic, *instance));
            subscribed.len() - 1
        });
        messages.extend(
            (0..flight.len()).map(|sample| (flight.stamps_us[sample], id, *topic, *device, *flight, sample)),
        );
    }
    messages.sort_by_key(|message| (message.0, message.1));
    for (us, id, topic, device, flight, sample) in messages {
        let values = if topic == "sensor_accel" { flight.acceleration[sample] } else { flight.rate[sample] };
        let values: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let (stamp, temperature) = (us.to_le_bytes(), flight.temperature[sample].to_le_bytes());
        // a simulator states no time of the sample
        log.data(id as u16, &[&stamp, &[0; 8], &device.to_le_bytes(), &values, &temperature]);
    }
    log.0
}

/// Log of a flight.
pub fn ulog(flight: &Flight, rate: Rate) -> Vec<u8> {
    let mut log = Log(b"ULog\x01\x12\x35\x01".to_vec());
    log.0.extend(flight.stamps_us[0].to_le_bytes());
    // Flag bits: none set, nothing appended.
    log.message(b'B', &[0; 40]);
    let fifo = |name: &str| {
        let rotation = if rate == Rate::FifoOfTurned { "uint8_t rotation;" } else { "" };
        format!(
            "{name}:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float dt;float scale;uint8_t samples;uint8_t[3] _padding0;int16_t[32] x;int16_t[32] y;int16_t[32] z;{rotation}"
        )
    };
    for format in [fifo("sensor_accel_fifo"), fifo("sensor_gyro_fifo")] {
        log.message(b'F', format.as_bytes());
    }
    for format in [
        "sensor_accel:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;uint32_t error_count;uint8_t[3] clip_counter;uint8_t samples;",
        "sensor_gyro:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;uint32_t error_count;uint8_t[3] clip_counter;uint8_t samples;",
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;uint8_t accelerometer_clipping;",
    ] {
        log.message(b'F', format.as_bytes());
    }
    for (id, instance, name) in [
        (0, 0, "sensor_accel"),
        (1, 0, "sensor_gyro"),
        (2, 0, "sensor_accel_fifo"),
        (3, 0, "sensor_gyro_fifo"),
        (4, 0, "sensor_combined"),
        (5, 1, "sensor_gyro"),
    ] {
        log.subscribe(id, instance, name);
    }
    for sample in 0..flight.len() {
        let us = flight.stamps_us[sample];
        let is_logged =
            rate == Rate::Full || us / 1_000_000 != flight.stamps_us[sample.saturating_sub(1)] / 1_000_000;
        // PX4's time of publication is later.
        let published = (us + 137).to_le_bytes();
        let stamp = us.to_le_bytes();
        let device = |instance: u8| (2_818_058 + u32::from(instance)).to_le_bytes();
        let temperature = flight.temperature[sample].to_le_bytes();
        let triad =
            |values: [f32; 3]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
        let (force, turn) = (triad(flight.acceleration[sample]), triad(flight.rate[sample]));
        if is_logged {
            for (id, instance, values) in [(0, 0, &force), (1, 0, &turn), (5, 1, &turn)] {
                log.data(id, &[&published, &stamp, &device(instance), values, &temperature, &[0; 7], &[1]]);
            }
        }
        match rate {
            Rate::Full => {}
            Rate::Decimated => {
                // The accelerometer is half a millisecond earlier.
                let relative = (-500_i32).to_le_bytes();
                let dt = 5000_u32.to_le_bytes();
                log.data(4, &[&stamp, &turn, &dt, &relative, &force, &dt, &[0]]);
            }
            Rate::Fifo | Rate::FifoOfTurned if sample % 10 == 9 => {
                let first = sample - 9;
                let dt_us = (us - flight.stamps_us[first]) as f32 / 9.0;
                for (id, values, scale) in
                    [(2, &flight.acceleration, 16.0 * 9.80665 / 32768.0), (3, &flight.rate, 35.0 / 32768.0)]
                {
                    let scale: f32 = scale;
                    // In the axes of the sensor: its x is the board's y, its y the board's −x.
                    let of_sensor = |[x, y, z]: [f32; 3]| match rate {
                        Rate::FifoOfTurned => [y, -x, z],
                        _ => [x, y, z],
                    };
                    let axes: Vec<u8> = (0..3)
                        .flat_map(|axis| {
                            let counts = values[first..=sample].iter();
                            let counts = counts.map(move |value| of_sensor(*value)[axis] / scale);
                            let counts = counts.map(|count| count.round() as i16).chain([0; 22]);
                            counts.flat_map(i16::to_le_bytes)
                        })
                        .collect();
                    let rotation: &[u8] = if rate == Rate::FifoOfTurned { &[2] } else { &[] };
                    let fields: [&[u8]; 9] = [
                        &published,
                        &stamp,
                        &device(0),
                        &dt_us.to_le_bytes(),
                        &scale.to_le_bytes(),
                        &[10],
                        &[0; 3],
                        &axes,
                        rotation,
                    ];
                    log.data(id, &fields);
                }
            }
            Rate::Fifo | Rate::FifoOfTurned => {}
        }
    }
    log.0
}
