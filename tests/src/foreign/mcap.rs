//! MCAP with messages of ROS 2, without chunks and index (the MCAP specification, and OMG's CDR).

use super::flight::{Flight, Publisher, in_order};

/// Plain CDR, little-endian: each number on a multiple of its size from the end of the encapsulation.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    fn put(&mut self, bytes: &[u8]) {
        while !(self.0.len() - 4).is_multiple_of(bytes.len()) {
            self.0.push(0);
        }
        self.0.extend(bytes);
    }

    fn header(&mut self, us: u64, frame: &str) {
        self.put(&((us / 1_000_000) as i32).to_le_bytes());
        self.put(&((us % 1_000_000 * 1000) as u32).to_le_bytes());
        self.put(&(frame.len() as u32 + 1).to_le_bytes());
        self.0.extend(frame.as_bytes());
        self.0.push(0);
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        numbers.into_iter().for_each(|number| self.put(&number.to_le_bytes()));
    }
}

struct Log(Vec<u8>);

impl Log {
    fn record(&mut self, opcode: u8, parts: &[&[u8]]) {
        self.0.push(opcode);
        self.0.extend((parts.iter().map(|part| part.len()).sum::<usize>() as u64).to_le_bytes());
        parts.iter().for_each(|part| self.0.extend(*part));
    }

    fn message(&mut self, channel: u16, us: u64, data: &[u8]) {
        let stamp = (us * 1000).to_le_bytes();
        self.record(0x05, &[&channel.to_le_bytes(), &0_u32.to_le_bytes(), &stamp, &stamp, data]);
    }
}

fn text(text: &str) -> Vec<u8> {
    let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
    bytes.extend(text.as_bytes());
    bytes
}

fn imu(flight: &Flight, sample: usize, frame: &str) -> Vec<u8> {
    let mut imu = Cdr::new();
    imu.header(flight.stamps_us[sample], frame);
    let wide = |values: [f32; 3]| values.map(f64::from);
    imu.numbers([0.0, 0.0, 0.0, 1.0]);
    imu.numbers([-1.0; 9]);
    imu.numbers(wide(flight.rate[sample]));
    imu.numbers([0.0; 9]);
    imu.numbers(wide(flight.acceleration[sample]));
    imu.numbers([0.0; 9]);
    imu.0
}

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Log of several sensors.
pub fn mcap_of(publishers: &[Publisher<'_>]) -> Vec<u8> {
    let mut log = Log(MAGIC.to_vec());
    log.record(0x01, &[&text("ros2"), &text("by hand")]);
    let [definition, _] = super::ros::ros2();
    let schema = 1_u16.to_le_bytes();
    log.record(0x03, &[&schema, &text("sensor_msgs/msg/Imu"), &text("ros2msg"), &text(&definition)]);
    let mut channels: Vec<u16> = Vec::new();
    for publisher in publishers {
        // ROS 2 has one channel for all publishers of a topic.
        if !channels.contains(&publisher.connection) {
            let (channel, none) = (publisher.connection.to_le_bytes(), 0_u32.to_le_bytes());
            log.record(0x04, &[&channel, &schema, &text(publisher.topic), &text("cdr"), &none]);
            channels.push(publisher.connection);
        }
    }
    for (publisher, sample) in in_order(publishers) {
        let us = publisher.flight.stamps_us[sample];
        log.message(publisher.connection, us, &imu(publisher.flight, sample, publisher.frame));
    }
    log.record(0x0f, &[&0_u32.to_le_bytes()]);
    log.record(0x02, &[&[0; 20]]);
    log.0.extend(MAGIC);
    log.0
}

/// Log of a flight, with a second, slower inertial topic that must not be chosen.
pub fn mcap(flight: &Flight) -> Vec<u8> {
    let mut log = Log(MAGIC.to_vec());
    log.record(0x01, &[&text("ros2"), &text("by hand")]);
    let names = [(1_u16, "sensor_msgs/msg/Imu"), (2, "sensor_msgs/msg/Temperature")];
    for ((id, name), definition) in names.into_iter().zip(super::ros::ros2()) {
        log.record(0x03, &[&id.to_le_bytes(), &text(name), &text("ros2msg"), &text(&definition)]);
    }
    for (id, schema, topic) in
        [(1_u16, 1_u16, "/imu/data_raw"), (2, 2, "/imu/temperature"), (3, 1, "/imu/slow")]
    {
        let none = 0_u32.to_le_bytes();
        log.record(0x04, &[&id.to_le_bytes(), &schema.to_le_bytes(), &text(topic), &text("cdr"), &none]);
    }
    for sample in 0..flight.len() {
        let us = flight.stamps_us[sample];
        let imu = imu(flight, sample, "imu_link");
        log.message(1, us, &imu);
        if sample % 10 == 0 {
            log.message(3, us, &imu);
        }
        let mut temperature = Cdr::new();
        temperature.header(us, "imu_link");
        temperature.numbers([f64::from(flight.temperature[sample]), 0.0]);
        log.message(2, us, &temperature.0);
    }
    log.record(0x0f, &[&0_u32.to_le_bytes()]);
    log.record(0x02, &[&[0; 20]]);
    log.0.extend(MAGIC);
    log.0
}
