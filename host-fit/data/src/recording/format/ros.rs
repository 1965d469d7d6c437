//! Messages of ROS that hold an inertial sensor's samples: `sensor_msgs/Imu`, `Temperature`, `MagneticField`.
//!
//! ROS 1 packs its fields; ROS 2 writes CDR, in which each field is aligned to its size. Both are read by one
//! [`Fields`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::super::column_words::words;
use super::super::error::RecordingError;
use super::super::provenance::Provenance;
use super::super::stream::Stream;
use super::opened::Opened;
use super::{Format, ReadAs, choice};
use crate::column::{AXES, MAGNETOMETERS};

/// Type of a message that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Imu,
    Temperature,
    MagneticField,
}

impl Kind {
    /// Kind by the name of a type in ROS 1 or 2.
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

/// Serialisation of a message.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    Ros1,
    #[cfg_attr(not(feature = "mcap"), expect(dead_code, reason = "bags have none"))]
    Cdr,
}

/// Sequential reader of the fields of a message.
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
        // the encapsulation: plain CDR, and its byte order
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

    /// Timestamp and frame of the header, which begins each of these messages.
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

/// Samples of one device on a topic: the messages of one connection in one frame.
#[derive(Debug)]
struct Topic {
    name: String,
    kind: Kind,
    connection: u32,
    frame: Option<String>,
    stamps_ns: Vec<i64>,
    values: Vec<Vec<f64>>,
}

/// A connection of a publisher to a topic; ROS 2 has one for all publishers of a topic.
#[derive(Debug)]
struct Connection {
    name: String,
    kind: Kind,
    number: u32,
    /// Topic of the last message.
    last: Option<usize>,
    unreadable: u64,
}

/// Content of a log read so far.
#[derive(Debug, Default)]
pub(super) struct Topics {
    connections: Vec<Connection>,
    topics: Vec<Topic>,
    /// Name of the requested topic, and of the device on it.
    wanted: Option<(String, Option<String>)>,
    /// Request as written by the user.
    asked: Option<String>,
    /// Every inertial topic, requested or not.
    inertial: BTreeSet<String>,
}

impl Topics {
    /// `asked`: requested inertial topic, with the device after an `@` if a topic has several.
    pub(super) fn new(asked: Option<&str>) -> Self {
        let wanted = asked.map(|asked| match asked.split_once('@') {
            Some((topic, device)) => (topic.to_owned(), Some(device.to_owned())),
            None => (asked.to_owned(), None),
        });
        Self { wanted, asked: asked.map(str::to_owned), ..Self::default() }
    }

    /// Returns true if messages of a topic are needed.
    pub(super) fn wants(&mut self, topic: &str, kind: Kind) -> bool {
        if kind == Kind::Imu {
            self.inertial.insert(topic.to_owned());
        }
        kind != Kind::Imu || self.wanted.as_ref().is_none_or(|(wanted, _)| wanted == topic)
    }

    /// Registers a connection to a topic and returns its index for [`take`](Self::take). Equal numbers share an index.
    pub(super) fn add(&mut self, name: &str, kind: Kind, number: u32) -> usize {
        let is = |known: &Connection| known.name == name && known.kind == kind && known.number == number;
        self.connections.iter().position(is).unwrap_or_else(|| {
            self.connections.push(Connection {
                name: name.to_owned(),
                kind,
                number,
                last: None,
                unreadable: 0,
            });
            self.connections.len() - 1
        })
    }

    /// Reads a message of a connection.
    pub(super) fn take(&mut self, connection: usize, message: &[u8], encoding: Encoding) {
        let of = &mut self.connections[connection];
        let Some(Message { stamp_ns, frame, values }) = Message::of(of.kind, message, encoding) else {
            of.unreadable += 1;
            return;
        };
        let is_in_frame = |topic: &Topic| topic.frame.as_deref().unwrap_or_default().as_bytes() == frame;
        let last = of.last.filter(|last| is_in_frame(&self.topics[*last]));
        let known = last.or_else(|| {
            let is_of = |topic: &Topic| {
                topic.connection == of.number
                    && topic.kind == of.kind
                    && topic.name == of.name
                    && is_in_frame(topic)
            };
            self.topics.iter().position(is_of)
        });
        // a damaged file may have any number of frames
        let at = known.unwrap_or(self.topics.len());
        if at == MAX_DEVICES {
            of.unreadable += 1;
            return;
        }
        if at == self.topics.len() {
            self.topics.push(Topic {
                name: of.name.clone(),
                kind: of.kind,
                connection: of.number,
                frame: Some(String::from_utf8_lossy(frame).into_owned()).filter(|frame| !frame.is_empty()),
                stamps_ns: Vec::new(),
                values: vec![Vec::new(); of.kind.columns().len()],
            });
        }
        of.last = Some(at);
        let topic = &mut self.topics[at];
        topic.stamps_ns.push(stamp_ns);
        topic.values.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }

    /// Streams of the sensors, and the assumptions made. Several devices on the topic to read are refused unless one is
    /// chosen; with `strict` also damage and unreadable messages.
    pub(super) fn finish(
        mut self,
        path: &Path,
        format: Format,
        damage: Option<String>,
        strict: bool,
    ) -> Result<Opened, RecordingError> {
        self.join_restarts();
        let few = self.exclude_sparse_devices();
        let devices: Vec<(String, &Topic)> = self
            .topics
            .iter()
            .filter(|topic| topic.kind == Kind::Imu && topic.stamps_ns.len() > 1)
            .map(|topic| (self.label(topic), topic))
            .collect();
        let best = best_topic(devices.iter().map(|(_, topic)| *topic));
        let of_best: Vec<&(String, &Topic)> =
            devices.iter().filter(|(_, topic)| best.is_some_and(|best| topic.name == best)).collect();
        let who = self.wanted.as_ref().and_then(|(_, who)| who.as_ref());
        let taken = match (who, &of_best[..]) {
            (None, [one]) => Some(one),
            (Some(_), found) => found.iter().find(|(label, _)| Some(label) == self.asked.as_ref()),
            (None, []) => None,
            (None, several) => {
                let labels: Vec<String> = several
                    .iter()
                    .map(|(label, topic)| format!("{label} with {} messages", topic.stamps_ns.len()))
                    .collect();
                let problem = format!(
                    "topic {} has messages of {} devices at the same time or in different frames: {}",
                    several[0].1.name,
                    several.len(),
                    labels.join(", ")
                );
                let help = format!("choose one of them as the topic, as in {}", several[0].0);
                return Err(choice::no_sensors(path, format, problem, &help));
            }
        };
        let Some((label, taken)) = taken else {
            let there: Vec<String> = match devices.is_empty() {
                true => self.inertial.iter().cloned().collect(),
                false => devices.iter().map(|(label, _)| label.clone()).collect(),
            };
            let there =
                if there.is_empty() { String::new() } else { format!("; there are {}", there.join(", ")) };
            let problem = match (&self.asked, &damage) {
                (Some(asked), _) => format!("there is no topic {asked} of sensor_msgs/Imu{there}"),
                (None, Some(damage)) => format!("there is no topic of sensor_msgs/Imu before {damage}"),
                (None, None) => "there is no topic of sensor_msgs/Imu".to_owned(),
            };
            let help = "record the driver's topic of the inertial sensor, as /imu/data_raw";
            return Err(choice::no_sensors(path, format, problem, help));
        };
        let of_taken = |connection: &&Connection| connection.name == taken.name;
        let unreadable: u64 = self.connections.iter().filter(of_taken).map(|of| of.unreadable).sum();
        let few = few.get(&taken.name).copied().unwrap_or(0);
        let few = if few > 0 { format!("; {few} messages of other frames excluded") } else { String::new() };
        choice::refuse_damage(path, format, strict, damage.as_deref(), unreadable)?;
        let others: BTreeSet<&str> = devices
            .iter()
            .map(|(_, topic)| topic.name.as_str())
            .chain(self.inertial.iter().map(String::as_str))
            .filter(|name| *name != taken.name)
            .collect();
        let others = others.into_iter().map(str::to_owned);
        let beside = devices.iter().filter(|(other, topic)| topic.name == taken.name && other != label);
        let others: Vec<String> = others.chain(beside.map(|(other, _)| other.clone())).collect();
        let others = choice::others_too(&others);
        let frame = taken.frame.as_ref().map_or_else(String::new, |frame| format!(", frame {frame}"));
        let unreadable = match unreadable {
            0 => String::new(),
            n => format!("; {n} of its messages cannot be read"),
        };
        let damage =
            damage.map_or_else(String::new, |damage| format!("; {damage}: what was read before is here"));
        let mut wanted = vec![self.position(taken)];
        let (mut with, mut without) = (Vec::new(), Vec::new());
        for kind in [Kind::Temperature, Kind::MagneticField] {
            let found: Vec<&Topic> =
                self.topics.iter().filter(|topic| topic.kind == kind && topic.stamps_ns.len() > 1).collect();
            match companion(taken, &found) {
                Some(topic) => {
                    wanted.push(self.position(topic));
                    with.push(topic.name.clone());
                }
                None => without.extend(found.iter().map(|topic| self.label(topic))),
            }
        }
        let with = if with.is_empty() { String::new() } else { format!(", with {}", with.join(", ")) };
        let without = match without.is_empty() {
            true => String::new(),
            false => {
                format!("; not read, device not identified: {}", without.join(", "))
            }
        };
        let assumed = format!(
            "{label}{others}{with}{frame}; m/s² with gravity, rad/s; by the stamps in the headers; as the driver gives it, which may have corrected it{without}{few}{unreadable}{damage}"
        );
        let mut topics: Vec<Option<Topic>> = self.topics.into_iter().map(Some).collect();
        let streams = wanted.into_iter().filter_map(|at| Some(topics[at].take()?.stream())).collect();
        Ok(Opened::Streams(streams, ReadAs { format, assumed, provenance: Some(Provenance::default()) }))
    }

    /// Excludes devices with so few messages that they result from damage, and counts their messages by topic.
    fn exclude_sparse_devices(&mut self) -> BTreeMap<String, usize> {
        let mut most: BTreeMap<(String, u8), usize> = BTreeMap::new();
        for topic in &self.topics {
            let most = most.entry((topic.name.clone(), topic.kind as u8)).or_default();
            *most = topic.stamps_ns.len().max(*most);
        }
        let mut few = BTreeMap::new();
        self.topics.retain(|topic| {
            let most = most[&(topic.name.clone(), topic.kind as u8)];
            let is_device = topic.stamps_ns.len() * choice::SELDOM as usize >= most;
            if !is_device {
                *few.entry(topic.name.clone()).or_default() += topic.stamps_ns.len();
            }
            is_device
        });
        few
    }

    fn position(&self, topic: &Topic) -> usize {
        self.topics.iter().position(|other| std::ptr::eq(other, topic)).unwrap_or(0)
    }

    /// Joins the messages of a restarted publisher: same topic and frame, consecutive in time.
    fn join_restarts(&mut self) {
        self.topics.sort_by(|a, b| {
            let key = |topic: &Topic| (topic.stamps_ns.iter().min().copied(), topic.connection);
            (&a.name, &a.frame, key(a)).cmp(&(&b.name, &b.frame, key(b)))
        });
        let mut joined: Vec<Topic> = Vec::new();
        for topic in std::mem::take(&mut self.topics) {
            let ends_before = |last: &Topic| last.stamps_ns.iter().max() < topic.stamps_ns.iter().min();
            match joined.last_mut() {
                Some(last)
                    if (last.kind, &last.name, &last.frame) == (topic.kind, &topic.name, &topic.frame)
                        && ends_before(last) =>
                {
                    last.stamps_ns.extend(topic.stamps_ns);
                    last.values.iter_mut().zip(topic.values).for_each(|(all, more)| all.extend(more));
                }
                _ => joined.push(topic),
            }
        }
        self.topics = joined;
    }

    /// Name of a topic, with the device on it if it has several: the frame, or a number if frames are equal.
    fn label(&self, topic: &Topic) -> String {
        let on_topic: Vec<&Topic> = self
            .topics
            .iter()
            .filter(|other| other.name == topic.name && other.kind == topic.kind && other.stamps_ns.len() > 1)
            .collect();
        let same_frame = on_topic.iter().filter(|other| other.frame == topic.frame).count();
        match &topic.frame {
            _ if on_topic.len() < 2 => topic.name.clone(),
            Some(frame) if same_frame == 1 => format!("{}@{frame}", topic.name),
            _ => {
                let number = on_topic.iter().position(|other| std::ptr::eq(*other, topic)).unwrap_or(0) + 1;
                format!("{}@{number}", topic.name)
            }
        }
    }
}

/// Maximum number of devices on all topics together; a log has a few.
const MAX_DEVICES: usize = 1000;

/// Share of the messages of the fullest topic from which a topic has every sample; a recorder subscribes to one slightly
/// later than to another.
const FULL: f64 = 0.9;

/// Topic with the most messages. Of several with about as many, the one whose name contains "raw", not "filtered", then
/// by the alphabet: the order in the file has no influence.
fn best_topic<'a>(topics: impl Iterator<Item = &'a Topic>) -> Option<&'a str> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for topic in topics {
        *counts.entry(&topic.name).or_default() += topic.stamps_ns.len();
    }
    let most = counts.values().max().copied()? as f64;
    let full = counts.into_iter().filter(|(_, count)| *count as f64 >= FULL * most);
    let rank = |name: &str| {
        let words = words(name);
        let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
        let is_processed =
            has(&["filtered", "filter", "filt", "corrected", "calibrated", "fused", "unbiased"]);
        if is_processed { 2 } else { u8::from(!has(&["raw", "uncalibrated", "unfiltered"])) }
    };
    full.map(|(name, _)| name).min_by_key(|name| (rank(name), *name))
}

/// Topic of another kind that belongs to the same device: by its frame, then by the length of the common path. `None` if
/// several are equally near.
fn companion<'a>(imu: &Topic, found: &[&'a Topic]) -> Option<&'a Topic> {
    let nearness = |topic: &Topic| {
        let shared = imu.name.split('/').zip(topic.name.split('/')).take_while(|(a, b)| a == b).count();
        (imu.frame.is_some() && imu.frame == topic.frame, shared)
    };
    let best = found.iter().map(|topic| nearness(topic)).max()?;
    let mut nearest = found.iter().filter(|topic| nearness(topic) == best);
    nearest.next().copied().filter(|_| nearest.next().is_none())
}

/// The parsed part of a message.
struct Message<'a> {
    stamp_ns: i64,
    frame: &'a [u8],
    values: Vec<f64>,
}

impl<'a> Message<'a> {
    fn of(kind: Kind, message: &'a [u8], encoding: Encoding) -> Option<Self> {
        let mut fields = Fields::of(message, encoding)?;
        let (stamp_ns, frame) = fields.header(encoding)?;
        let values = match kind {
            Kind::Imu => {
                let _orientation: [f64; 4] = fields.pass()?;
                let _covariance: [f64; 9] = fields.pass()?;
                let rate: [f64; 3] = fields.pass()?;
                let _covariance: [f64; 9] = fields.pass()?;
                let acceleration: [f64; 3] = fields.pass()?;
                acceleration.into_iter().chain(rate).collect()
            }
            Kind::Temperature => vec![fields.f64()?],
            // tesla
            Kind::MagneticField => fields.pass::<3>()?.map(|tesla| tesla * 1e6).to_vec(),
        };
        Some(Self { stamp_ns, frame, values })
    }
}

impl Topic {
    fn stream(self) -> Stream {
        let columns = self.kind.columns().iter().zip(self.values);
        let columns = columns.map(|(name, values)| ((*name).to_owned(), values)).collect();
        Stream { name: self.name, stamps_ns: self.stamps_ns, columns }
    }
}
