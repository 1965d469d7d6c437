//! Messages of ROS that hold an inertial sensor's samples: `sensor_msgs/Imu`, `Temperature`, `MagneticField`.
//!
//! ROS 1 writes its fields one after the other; ROS 2 writes CDR, in which each field lies on a multiple of its size.
//! Both are read by one [`Fields`].

use std::path::Path;

use super::super::error::RecordingError;
use super::super::provenance::Provenance;
use super::super::stream::Stream;
use super::opened::Opened;
use super::{Format, ReadAs, choice};
use crate::column::{AXES, MAGNETOMETERS};

/// A message that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Imu,
    Temperature,
    MagneticField,
}

impl Kind {
    /// By the name of its type, in ROS 1 or 2.
    pub(super) fn of(name: &str) -> Option<Self> {
        match name {
            "sensor_msgs/msg/Imu" | "sensor_msgs/Imu" => Some(Self::Imu),
            "sensor_msgs/msg/Temperature" | "sensor_msgs/Temperature" => Some(Self::Temperature),
            "sensor_msgs/msg/MagneticField" | "sensor_msgs/MagneticField" => Some(Self::MagneticField),
            _ => None,
        }
    }

    fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Imu => &AXES,
            Self::Temperature => &["temp_c"],
            Self::MagneticField => &MAGNETOMETERS,
        }
    }
}

/// How a message is written.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    Ros1,
    #[cfg_attr(not(feature = "mcap"), expect(dead_code, reason = "bags have none"))]
    Cdr,
}

/// The fields of a message, one after the other.
struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    is_aligned: bool,
    is_big_endian: bool,
}

impl<'a> Fields<'a> {
    fn of(message: &'a [u8], encoding: Encoding) -> Option<Self> {
        if encoding == Encoding::Ros1 {
            return Some(Self { bytes: message, at: 0, is_aligned: false, is_big_endian: false });
        }
        // the encapsulation: plain CDR, and how it is ordered
        let [0, order @ (0 | 1), _, _] = *message.get(..4)? else { return None };
        Some(Self { bytes: message.get(4..)?, at: 0, is_aligned: true, is_big_endian: order == 0 })
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        if self.is_aligned {
            self.at = self.at.checked_next_multiple_of(N)?;
        }
        let end = self.at.checked_add(N)?;
        let mut bytes: [u8; N] = self.bytes.get(self.at..end)?.try_into().ok()?;
        self.at = end;
        if self.is_big_endian {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    fn pass<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Some(values)
    }

    /// Stamp and frame of the header, which every one of these messages begins with.
    fn header(&mut self, encoding: Encoding) -> Option<(i64, &'a [u8])> {
        if encoding == Encoding::Ros1 {
            let _sequence = self.u32()?;
        }
        let seconds = self.u32()?;
        let nanoseconds = self.u32()?;
        // signed in ROS 2, and then not above i32::MAX
        let stamp_ns = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
        let length = usize::try_from(self.u32()?).ok()?;
        let end = self.at.checked_add(length)?;
        let frame = self.bytes.get(self.at..end)?;
        self.at = end;
        Some((stamp_ns, frame.strip_suffix(b"\0").unwrap_or(frame)))
    }
}

/// What a topic gave.
#[derive(Debug)]
struct Topic {
    name: String,
    kind: Kind,
    frame: Option<String>,
    stamps_ns: Vec<i64>,
    values: Vec<Vec<f64>>,
    unreadable: u64,
}

/// What was read of a log.
#[derive(Debug, Default)]
pub(super) struct Topics {
    topics: Vec<Topic>,
    wanted: Option<String>,
}

impl Topics {
    /// `wanted`: the inertial topic to take.
    pub(super) fn new(wanted: Option<&str>) -> Self {
        Self { topics: Vec::new(), wanted: wanted.map(str::to_owned) }
    }

    /// Whether messages of a topic are of use.
    pub(super) fn wants(&self, topic: &str, kind: Kind) -> bool {
        kind != Kind::Imu || self.wanted.as_ref().is_none_or(|wanted| wanted == topic)
    }

    /// The number of a topic, for [`take`](Self::take).
    pub(super) fn add(&mut self, name: &str, kind: Kind) -> usize {
        let found = self.topics.iter().position(|topic| topic.name == name && topic.kind == kind);
        found.unwrap_or_else(|| {
            self.topics.push(Topic {
                name: name.to_owned(),
                kind,
                frame: None,
                stamps_ns: Vec::new(),
                values: vec![Vec::new(); kind.columns().len()],
                unreadable: 0,
            });
            self.topics.len() - 1
        })
    }

    /// Reads a message of a topic.
    pub(super) fn take(&mut self, topic: usize, message: &[u8], encoding: Encoding) {
        let topic = &mut self.topics[topic];
        if topic.take(message, encoding).is_none() {
            topic.unreadable += 1;
        }
    }

    /// The sensors, and what was assumed.
    ///
    /// # Errors
    ///
    /// There is no inertial topic.
    pub(super) fn finish(
        self,
        path: &Path,
        format: Format,
        damage: Option<String>,
    ) -> Result<Opened, RecordingError> {
        let mut imus: Vec<&Topic> = self.topics.iter().filter(|topic| topic.kind == Kind::Imu).collect();
        imus.sort_by_key(|topic| std::cmp::Reverse(topic.stamps_ns.len()));
        let Some(taken) = imus.first().filter(|topic| topic.stamps_ns.len() > 1) else {
            let problem = match (&self.wanted, &damage) {
                (Some(wanted), _) => format!("there is no topic {wanted} of sensor_msgs/Imu"),
                (None, Some(damage)) => format!("there is no topic of sensor_msgs/Imu before {damage}"),
                (None, None) => "there is no topic of sensor_msgs/Imu".to_owned(),
            };
            let help = "record the driver's topic of the inertial sensor, as /imu/data_raw";
            return Err(choice::no_sensors(path, format, problem, help));
        };
        let name = taken.name.clone();
        let others: Vec<String> = imus.iter().skip(1).map(|topic| topic.name.clone()).collect();
        let others = choice::others_too(&others);
        let frame = taken.frame.as_ref().map_or_else(String::new, |frame| format!(", frame {frame}"));
        let unreadable = match taken.unreadable {
            0 => String::new(),
            n => format!("; {n} of its messages cannot be read"),
        };
        let damage =
            damage.map_or_else(String::new, |damage| format!("; {damage}: what was read before is here"));
        let slow: Vec<&str> = self
            .topics
            .iter()
            .filter(|topic| topic.kind != Kind::Imu && topic.stamps_ns.len() > 1)
            .map(|topic| topic.name.as_str())
            .collect();
        let slow = if slow.is_empty() { String::new() } else { format!(", with {}", slow.join(", ")) };
        let assumed = format!(
            "{name}{others}{slow}{frame}; m/s² with gravity, rad/s; by the stamps in the headers{unreadable}{damage}"
        );
        // of each other kind the one with most messages
        let mut streams: Vec<Stream> = Vec::new();
        let mut topics = self.topics;
        topics.sort_by_key(|topic| std::cmp::Reverse(topic.stamps_ns.len()));
        for kind in [Kind::Imu, Kind::Temperature, Kind::MagneticField] {
            let found = topics.iter().position(|topic| topic.kind == kind && topic.stamps_ns.len() > 1);
            streams.extend(found.map(|at| topics.swap_remove(at).stream()));
            topics.sort_by_key(|topic| std::cmp::Reverse(topic.stamps_ns.len()));
        }
        Ok(Opened::Streams(streams, ReadAs { format, assumed, provenance: Some(Provenance::default()) }))
    }
}

impl Topic {
    fn take(&mut self, message: &[u8], encoding: Encoding) -> Option<()> {
        let mut fields = Fields::of(message, encoding)?;
        let (stamp_ns, frame) = fields.header(encoding)?;
        let values: &[f64] = match self.kind {
            Kind::Imu => {
                let _orientation: [f64; 4] = fields.pass()?;
                let _covariance: [f64; 9] = fields.pass()?;
                let rate: [f64; 3] = fields.pass()?;
                let _covariance: [f64; 9] = fields.pass()?;
                let acceleration: [f64; 3] = fields.pass()?;
                &[acceleration[0], acceleration[1], acceleration[2], rate[0], rate[1], rate[2]]
            }
            Kind::Temperature => &[fields.f64()?],
            // T
            Kind::MagneticField => &fields.pass::<3>()?.map(|tesla| tesla * 1e6),
        };
        if self.frame.is_none() {
            self.frame = Some(String::from_utf8_lossy(frame).into_owned()).filter(|frame| !frame.is_empty());
        }
        self.stamps_ns.push(stamp_ns);
        self.values.iter_mut().zip(values).for_each(|(column, value)| column.push(*value));
        Some(())
    }

    fn stream(self) -> Stream {
        let columns = self.kind.columns().iter().zip(self.values);
        let columns = columns.map(|(name, values)| ((*name).to_owned(), values)).collect();
        Stream { name: self.name, stamps_ns: self.stamps_ns, columns }
    }
}
