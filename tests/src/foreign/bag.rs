//! Bags of ROS 1, version 2.0 (the ROS wiki's "Bags/Format/2.0").

use super::flight::{Flight, Publisher, in_order};

/// Storage of the messages in a bag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chunks {
    /// In chunks of a hundred samples.
    Some,
    /// Without chunks, as in a recovered bag.
    None,
}

fn record(to: &mut Vec<u8>, fields: &[(&str, &[u8])], data: &[u8]) {
    let mut header = Vec::new();
    for (name, value) in fields {
        header.extend((name.len() as u32 + 1 + value.len() as u32).to_le_bytes());
        header.extend(name.as_bytes());
        header.push(b'=');
        header.extend(*value);
    }
    for part in [&header[..], data] {
        to.extend((part.len() as u32).to_le_bytes());
        to.extend(part);
    }
}

fn connection(to: &mut Vec<u8>, id: u32, topic: &str, kind: &str, definition: &str) {
    let mut described = Vec::new();
    for field in [
        format!("topic={topic}"),
        format!("type={kind}"),
        "md5sum=*".into(),
        format!("message_definition={definition}"),
    ] {
        described.extend((field.len() as u32).to_le_bytes());
        described.extend(field.as_bytes());
    }
    record(to, &[("op", &[7]), ("conn", &id.to_le_bytes()), ("topic", topic.as_bytes())], &described);
}

fn header(us: u64, sequence: u32, frame: &str) -> Vec<u8> {
    let mut header = sequence.to_le_bytes().to_vec();
    header.extend(((us / 1_000_000) as u32).to_le_bytes());
    header.extend(((us % 1_000_000 * 1000) as u32).to_le_bytes());
    header.extend((frame.len() as u32).to_le_bytes());
    header.extend(frame.as_bytes());
    header
}

/// A message of one sample.
fn imu(flight: &Flight, sample: usize, frame: &str) -> Vec<u8> {
    let mut imu = header(flight.stamps_us[sample], sample as u32, frame);
    let mut numbers = |values: &[f64]| values.iter().for_each(|value| imu.extend(value.to_le_bytes()));
    numbers(&[0.0, 0.0, 0.0, 1.0]);
    numbers(&[0.0; 9]);
    numbers(&flight.rate[sample].map(f64::from));
    numbers(&[0.0; 9]);
    numbers(&flight.acceleration[sample].map(f64::from));
    numbers(&[0.0; 9]);
    imu
}

/// Bag of several sensors, without chunks.
pub fn bag_of(publishers: &[Publisher<'_>]) -> Vec<u8> {
    let mut bag = b"#ROSBAG V2.0\n".to_vec();
    let [definition, _] = super::ros::ros1();
    for publisher in publishers {
        let connected = u32::from(publisher.connection);
        connection(&mut bag, connected, publisher.topic, "sensor_msgs/Imu", &definition);
    }
    for (publisher, sample) in in_order(publishers) {
        let us = publisher.flight.stamps_us[sample];
        let mut time = ((us / 1_000_000) as u32).to_le_bytes().to_vec();
        time.extend(((us % 1_000_000 * 1000) as u32).to_le_bytes());
        let connected = u32::from(publisher.connection).to_le_bytes();
        let message = imu(publisher.flight, sample, publisher.frame);
        record(&mut bag, &[("op", &[2]), ("conn", &connected), ("time", &time)], &message);
    }
    bag
}

/// Bag of a flight.
pub fn bag(flight: &Flight, chunks: Chunks) -> Vec<u8> {
    let mut bag = b"#ROSBAG V2.0\n".to_vec();
    // Without an index, because the reader scans the whole file.
    let mut begin = Vec::new();
    let counts = [("conn_count", 2_u32.to_le_bytes()), ("chunk_count", 0_u32.to_le_bytes())];
    let fields: Vec<(&str, &[u8])> = [("op", &[3][..]), ("index_pos", &[0; 8][..])]
        .into_iter()
        .chain(counts.iter().map(|(name, value)| (*name, &value[..])))
        .collect();
    record(&mut begin, &fields, &[b' '; 100]);
    bag.extend(begin);
    let mut chunk = Vec::new();
    let [of_imu, temperature] = super::ros::ros1();
    connection(&mut chunk, 0, "/imu", "sensor_msgs/Imu", &of_imu);
    connection(&mut chunk, 1, "/temperature", "sensor_msgs/Temperature", &temperature);
    for sample in 0..flight.len() {
        let us = flight.stamps_us[sample];
        let imu = imu(flight, sample, "imu");
        let mut warmth = header(us, sample as u32, "imu");
        warmth.extend(f64::from(flight.temperature[sample]).to_le_bytes());
        warmth.extend(0.0_f64.to_le_bytes());
        let mut time = ((us / 1_000_000) as u32).to_le_bytes().to_vec();
        time.extend(((us % 1_000_000 * 1000) as u32).to_le_bytes());
        for (id, data) in [(0_u32, &imu), (1, &warmth)] {
            record(&mut chunk, &[("op", &[2]), ("conn", &id.to_le_bytes()), ("time", &time)], data);
        }
        if chunks == Chunks::Some && (sample % 100 == 99 || sample + 1 == flight.len()) {
            let size = (chunk.len() as u32).to_le_bytes();
            record(&mut bag, &[("op", &[5]), ("compression", b"none"), ("size", &size)], &chunk);
            chunk.clear();
        }
    }
    bag.extend(chunk);
    bag
}
