//! PX4 ULog: inertial topics at their full rate, else the integrated one.
//!
//! Topics and their fields are those of PX4's message definitions (`msg/SensorAccel.msg`, `SensorGyro.msg`,
//! `SensorAccelFifo.msg`, `SensorGyroFifo.msg`, `SensorCombined.msg`, `SensorMag.msg`, `SystemPower.msg`,
//! `Cpuload.msg`).

mod messages;

use std::io::BufRead;
use std::path::Path;

use px4_ulog::stream_parser::LogParser;
use px4_ulog::stream_parser::model::{DataMessage, FlattenedFieldType, FlattenedFormat};

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::provenance::{Frame, Provenance, SensorProvenance, Values};
use super::super::stream::Stream;
use super::opened::Opened;
use super::rotation::{self, Matrix};
use super::{Format, ReadAs, choice};
use crate::catch_panic::catch_panic;
use crate::column::{ACCELEROMETERS, GYROS, MAGNETOMETERS};
use crate::file::FileError;
use crate::interrupt;
use crate::statistics::median_of;
use messages::{Formats, Messages};

/// Longest period of a topic at full rate, ns: 20 samples a second. PX4 logs the raw ones once a second by default.
const SLOWEST_NS: f64 = 50e6;

/// Longest period of a raw topic in a log without any at full rate, ns: 8 samples a second. PX4's profile for thermal
/// calibration logs ten.
const SLOWEST_RAW_NS: f64 = 125e6;

/// Fields read from a topic.
struct Topic {
    name: &'static str,
    /// Fields of a sample in every message, their channels, and the factor to their unit.
    samples: &'static [(&'static [&'static str], &'static [&'static str], f64)],
    /// A field that changes slowly, its channel, and the factor to its unit.
    slow: Option<(&'static str, &'static str, f64)>,
}

/// Topics that are read; their index is used throughout this file.
const TOPICS: [Topic; 8] = [
    Topic { name: "sensor_accel", samples: &[(&["x", "y", "z"], &ACCELEROMETERS, 1.0)], slow: TEMPERATURE },
    Topic { name: "sensor_gyro", samples: &[(&["x", "y", "z"], &GYROS, 1.0)], slow: TEMPERATURE },
    Topic { name: "sensor_accel_fifo", samples: &[(&[], &ACCELEROMETERS, 1.0)], slow: None },
    Topic { name: "sensor_gyro_fifo", samples: &[(&[], &GYROS, 1.0)], slow: None },
    Topic {
        name: "sensor_combined",
        samples: &[
            (&["gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"], &GYROS, 1.0),
            (
                &["accelerometer_m_s2[0]", "accelerometer_m_s2[1]", "accelerometer_m_s2[2]"],
                &ACCELEROMETERS,
                1.0,
            ),
        ],
        slow: None,
    },
    // gauss
    Topic { name: "sensor_mag", samples: &[(&["x", "y", "z"], &MAGNETOMETERS, 100.0)], slow: None },
    Topic { name: "system_power", samples: &[], slow: Some(("voltage5v_v", "supply_v", 1.0)) },
    // a fraction of 1
    Topic { name: "cpuload", samples: &[], slow: Some(("load", "load_pct", 100.0)) },
];
const ACCEL: usize = 0;
const GYRO: usize = 1;
const ACCEL_FIFO: usize = 2;
const GYRO_FIFO: usize = 3;
const COMBINED: usize = 4;
const MAG: usize = 5;
const POWER: usize = 6;
const LOAD: usize = 7;
const TEMPERATURE: Option<(&str, &str, f64)> = Some(("temperature", "temp_c", 1.0));

/// A log damaged after its definitions is read up to the damage.
pub(super) fn read(
    path: &Path,
    input: impl BufRead,
    options: &LoadOptions,
) -> Result<Opened, RecordingError> {
    let named = ["sensor_accel", "sensor_gyro"];
    // the instance, and after an @ the devices to read if it has several
    let (instance, asked) = options.topic.as_deref().map_or((None, ""), |topic| {
        topic.split_once('@').map_or((Some(topic), ""), |(instance, asked)| (Some(instance), asked))
    });
    let wanted = choice::instance(path, Format::Ulog, instance.filter(|name| !name.is_empty()), &named)?;
    let asked: Vec<&str> = asked.split(',').map(str::trim).filter(|id| !id.is_empty()).collect();
    let mut gathered = Gathered::new(wanted);
    let mut take = |message: &DataMessage| gathered.take(message);
    let mut parser = LogParser::default();
    parser.set_data_message_callback(&mut take);
    let mut messages = Messages::new(input);
    let mut formats = Formats::default();
    let mut damage = None;
    while damage.is_none() {
        interrupt::check();
        let Some(message) = messages.next().map_err(FileError::reading(path))? else { break };
        // a failed assertion of the library is damage of the file
        let parsed = catch_panic(|| {
            formats.look_at(message, parser.in_data())?;
            parser.consume_bytes(message).map_err(|error| error.description)
        });
        damage = match parsed {
            Ok(parsed) => parsed.err(),
            Err(_) => Some("it cannot be parsed".to_owned()),
        };
    }
    let (in_data, is_cut, at) = (parser.in_data(), messages.is_cut(), messages.at());
    drop(parser);
    if let Some(problem) = damage.as_ref().filter(|_| !in_data) {
        let problem = problem.clone();
        return Err(RecordingError::Damaged { path: path.to_owned(), format: "ULog", at: None, problem });
    }
    let is_damaged = damage.is_some() || is_cut;
    let problem = is_damaged.then(|| format!("it is damaged or cut short near byte {at}"));
    choice::refuse_damage(path, Format::Ulog, options.strict, problem.as_deref(), 0)?;
    gathered.choose_devices(path, &asked)?;
    let mut read = gathered.finish(path, wanted, &asked)?;
    if damage.is_some() || is_cut {
        let near = format!("; the file is damaged or cut short near byte {at}: what was read before is here");
        read.1.assumed.push_str(&near);
    }
    Ok(Opened::Streams(read.0, read.1))
}

#[derive(Default)]
struct Triad {
    stamps_ns: Vec<i64>,
    values: [Vec<f64>; 3],
}

#[derive(Default)]
struct Slow {
    stamps_ns: Vec<i64>,
    values: Vec<f64>,
}

/// Samples of one device on a topic.
struct Device {
    /// `device_id`; without one the number of the subscription distinguishes publishers.
    id: Result<u32, u16>,
    triads: [Triad; 2],
    slow: Slow,
    messages: u64,
}

/// Maximum number of devices on one topic: a damaged file may have any number.
const MAX_DEVICES: usize = 64;

impl Device {
    fn name(&self) -> String {
        match self.id {
            Ok(id) => id.to_string(),
            Err(subscription) => format!("s{subscription}"),
        }
    }

    /// Bus of the device, as packed by PX4: three bits of its kind and five of its number
    /// (`device::Device::DeviceStructure`).
    fn bus(id: u32) -> u8 {
        id as u8
    }
}

struct Gathered {
    /// The requested instance.
    wanted: u8,
    /// Layout of the fields, by the number of the subscription.
    layouts: Vec<Option<Layout>>,
    /// Two triads of each topic.
    triads: [[Triad; 2]; TOPICS.len()],
    slow: [Slow; TOPICS.len()],
    /// Number of messages of each instance of each topic.
    instances: [Vec<u64>; TOPICS.len()],
    device: [Option<u32>; TOPICS.len()],
    /// Mountings stated in the batches of each topic.
    rotations: [Vec<u8>; TOPICS.len()],
    /// Every device of the requested instance, until one is chosen.
    devices: [Vec<Device>; TOPICS.len()],
    /// Last device of every instance.
    of_instance: [Vec<Option<u32>>; TOPICS.len()],
    /// Other devices of the same instance, by name.
    beside: [Vec<String>; TOPICS.len()],
}

/// Layout of the fields of a subscription.
struct Layout {
    topic: Option<usize>,
    instance: u8,
    /// Times of sample and message; a simulator states 0 as the first.
    stamps: [Option<usize>; 2],
    /// i32, µs: timestamp of the accelerometer minus that of the message.
    second_stamp: Option<usize>,
    triads: [Option<[usize; 3]>; 2],
    slow: Option<usize>,
    fifo: Option<Fifo>,
    device: Option<usize>,
}

/// Layout of the fields of a batch.
struct Fifo {
    dt: usize,
    scale: usize,
    samples: usize,
    axes: [usize; 3],
    room: usize,
    /// u8, the sensor's mounting on the board: samples of a message with this field are in the sensor's axes, those of
    /// one without are in the board's, as rotated by the driver.
    rotation: Option<usize>,
}

impl Layout {
    fn of(message: &DataMessage) -> Self {
        let format = message.flattened_format;
        let name = format.message_name();
        let topic = TOPICS.iter().position(|topic| topic.name == name);
        let offset = |field: &str, kind: FlattenedFieldType| {
            format.get_field_offset(field, kind).ok().map(usize::from)
        };
        let float = |field: &str| offset(field, FlattenedFieldType::Float);
        let stamp = |field: &str| offset(field, FlattenedFieldType::UInt64);
        let triad = |fields: &[&str]| -> Option<[usize; 3]> {
            match fields {
                [x, y, z] => Some([float(x)?, float(y)?, float(z)?]),
                _ => None,
            }
        };
        let known = topic.map(|topic| &TOPICS[topic]);
        let triads = [0, 1].map(|at| known.and_then(|topic| triad(topic.samples.get(at)?.0)));
        Self {
            topic,
            instance: message.multi_id.value(),
            stamps: ["timestamp_sample", "timestamp"].map(stamp),
            second_stamp: offset("accelerometer_timestamp_relative", FlattenedFieldType::Int32),
            triads,
            slow: known.and_then(|topic| float(topic.slow?.0)),
            fifo: Fifo::of(format),
            device: offset("device_id", FlattenedFieldType::UInt32),
        }
    }
}

impl Fifo {
    fn of(format: &FlattenedFormat) -> Option<Self> {
        let offset = |field: &str, kind| format.get_field_offset(field, kind).ok().map(usize::from);
        let axis = |axis: &str| offset(&format!("{axis}[0]"), FlattenedFieldType::Int16);
        let room =
            (0..).take_while(|at| offset(&format!("x[{at}]"), FlattenedFieldType::Int16).is_some()).count();
        Some(Self {
            dt: offset("dt", FlattenedFieldType::Float)?,
            scale: offset("scale", FlattenedFieldType::Float)?,
            samples: offset("samples", FlattenedFieldType::UInt8)?,
            axes: [axis("x")?, axis("y")?, axis("z")?],
            room,
            rotation: offset("rotation", FlattenedFieldType::UInt8),
        })
    }
}

/// Bytes of a field; a message may be truncated before the end of its format.
fn field<const N: usize>(data: &[u8], offset: usize) -> Option<[u8; N]> {
    data.get(offset..offset.checked_add(N)?)?.try_into().ok()
}

fn float(data: &[u8], offset: usize) -> Option<f64> {
    field(data, offset).map(|bytes| f64::from(f32::from_le_bytes(bytes)))
}

impl Gathered {
    fn new(wanted: u8) -> Self {
        Self {
            wanted,
            layouts: Vec::new(),
            triads: Default::default(),
            slow: Default::default(),
            instances: Default::default(),
            device: [None; TOPICS.len()],
            rotations: Default::default(),
            devices: Default::default(),
            of_instance: Default::default(),
            beside: Default::default(),
        }
    }

    fn take(&mut self, message: &DataMessage) {
        let id = usize::from(message.msg_id);
        if self.layouts.len() <= id {
            self.layouts.resize_with(id + 1, || None);
        }
        let layout = &*self.layouts[id].get_or_insert_with(|| Layout::of(message));
        let Some(at) = layout.topic else { return };
        let topic = &TOPICS[at];
        let instances = &mut self.instances[at];
        let instance = usize::from(layout.instance);
        instances.resize(instances.len().max(instance + 1), 0);
        instances[instance] += 1;
        let data = message.data;
        let id = layout.device.and_then(|offset| field(data, offset)).map(u32::from_le_bytes);
        self.of_instance[at].resize(instances.len(), None);
        self.of_instance[at][instance] = id.or(self.of_instance[at][instance]);
        // other topics have one instance
        let is_sensor = at <= GYRO_FIFO;
        if layout.instance != if is_sensor { self.wanted } else { 0 } {
            return;
        }
        let time_us = |offset: usize| field(data, offset).map(u64::from_le_bytes).filter(|us| *us > 0);
        let stamp_us = layout.stamps.into_iter().flatten().find_map(time_us);
        let Some(stamp_ns) = stamp_us.and_then(ns_of_us) else { return };
        let id = id.ok_or(message.msg_id);
        let devices = &mut self.devices[at];
        let place = devices.iter().position(|device| device.id == id).unwrap_or(devices.len());
        if place == MAX_DEVICES {
            return;
        }
        if place == devices.len() {
            devices.push(Device { id, triads: Default::default(), slow: Slow::default(), messages: 0 });
        }
        let device = &mut devices[place];
        device.messages += 1;
        if let (Some(fifo), true) = (&layout.fifo, at == ACCEL_FIFO || at == GYRO_FIFO) {
            let rotation = fifo.rotation.and_then(|offset| data.get(offset).copied());
            if let Some(number) = rotation.filter(|number| !self.rotations[at].contains(number)) {
                self.rotations[at].push(number);
            }
            // with an unknown mounting the axes of the sensor are kept
            let matrix = rotation.filter(|number| *number != 0).and_then(rotation::of_px4);
            device.triads[0].take_batch(fifo, stamp_ns, data, matrix.as_ref());
            return;
        }
        for (which, offsets) in layout.triads.iter().enumerate() {
            let Some(offsets) = offsets else { continue };
            let factor = topic.samples[which].2;
            // the accelerometer of sensor_combined has a separate timestamp
            let relative = match layout.second_stamp.filter(|_| which == 1) {
                Some(offset) => field(data, offset).map_or(0, i32::from_le_bytes),
                None => 0,
            };
            if relative == i32::MAX {
                // PX4's mark for: no new sample
                continue;
            }
            let values = offsets.map(|offset| float(data, offset).map_or(f64::NAN, |value| value * factor));
            device.triads[which].push(stamp_ns.saturating_add(i64::from(relative) * 1000), values);
        }
        if let (Some(offset), Some((_, _, factor))) = (layout.slow, topic.slow)
            && let Some(value) = float(data, offset).filter(|value| value.is_finite())
        {
            device.slow.stamps_ns.push(stamp_ns);
            device.slow.values.push(value * factor);
        }
    }

    /// Reduces every topic to the samples of one device. An inertial topic of several devices is refused unless `asked`
    /// names one of them.
    fn choose_devices(&mut self, path: &Path, asked: &[&str]) -> Result<(), RecordingError> {
        let refused = |problem: String, help: &str| choice::no_sensors(path, Format::Ulog, problem, help);
        let known: Vec<String> = self.devices.iter().flatten().map(Device::name).collect();
        if let Some(unknown) = asked.iter().find(|id| !known.iter().any(|known| known == *id)) {
            let mut known = known;
            known.sort();
            known.dedup();
            let problem = format!("there is no device {unknown}; there are {}", known.join(", "));
            return Err(refused(problem, "name the device_id behind the instance, as in 0@2818058"));
        }
        for (at, topic) in TOPICS.iter().enumerate() {
            let mut devices = std::mem::take(&mut self.devices[at]);
            // most messages first; the order in the file has no influence
            devices.sort_by_key(|device| (std::cmp::Reverse(device.messages), device.name()));
            // a damaged message may name any device
            let most = devices.first().map_or(0, |device| device.messages);
            let few: Vec<Device> =
                devices.extract_if(.., |device| device.messages * choice::SELDOM < most).collect();
            // if two devices of the topic are named, the first is meant: the other is of another topic
            let is_of = |id: &&str| devices.iter().position(|device| device.name() == **id);
            let place = asked.iter().find_map(is_of);
            if at <= GYRO_FIFO && devices.len() > 1 && place.is_none() {
                let there: Vec<String> = devices
                    .iter()
                    .map(|device| format!("{}@{} ({} messages)", self.wanted, device.name(), device.messages))
                    .collect();
                let topic = topic.name;
                let problem = format!(
                    "{topic} {} has samples of {} devices, by device_id: {}",
                    self.wanted,
                    devices.len(),
                    there.join(", ")
                );
                let help = format!(
                    "choose one device of each topic, as in topic {}@{}",
                    self.wanted,
                    devices[0].name()
                );
                return Err(refused(problem, &help));
            }
            if devices.is_empty() {
                continue;
            }
            let Device { id, triads, slow, .. } = devices.remove(place.unwrap_or(0));
            self.beside[at] = devices.iter().chain(&few).map(Device::name).collect();
            (self.device[at], self.triads[at], self.slow[at]) = (id.ok(), triads, slow);
        }
        Ok(())
    }

    /// Describes accelerometer and gyro on different chips; refuses them if another instance may share a chip and
    /// `asked` does not name both.
    fn one_chip(&self, path: &Path, taken: &[usize], asked: &[&str]) -> Result<String, RecordingError> {
        let [acc, gyr] = *taken else { return Ok(String::new()) };
        let (Some(force), Some(rate)) = (self.device[acc], self.device[gyr]) else {
            return Ok(String::new());
        };
        let others = |at: usize| {
            let instances = self.of_instance[at].iter().enumerate();
            instances.filter(|(instance, _)| *instance != usize::from(self.wanted)).filter_map(|(_, id)| *id)
        };
        let has_twin = others(gyr).any(|id| id == force) || others(acc).any(|id| id == rate);
        let is_elsewhere = Device::bus(force) != Device::bus(rate);
        let is_named = [force, rate].iter().all(|id| asked.contains(&id.to_string().as_str()));
        if force == rate || !(has_twin || is_elsewhere) {
            return Ok(String::new());
        }
        let has_choice = others(gyr).chain(others(acc)).next().is_some();
        if is_named || !has_choice {
            return Ok("; accelerometer and gyro are of different chips, and the temperature is that of one"
                .to_owned());
        }
        let there: Vec<String> = [acc, gyr]
            .iter()
            .flat_map(|at| {
                let instances = self.of_instance[*at].iter().enumerate();
                instances.filter_map(|(n, id)| Some(format!("{} {n} is device {}", TOPICS[*at].name, (*id)?)))
            })
            .collect();
        let problem = format!(
            "accelerometer and gyro of instance {} are of different chips: {}",
            self.wanted,
            there.join(", ")
        );
        let help = format!(
            "choose another instance, or take both all the same by topic {}@{force},{rate}",
            self.wanted
        );
        Err(choice::no_sensors(path, Format::Ulog, problem, &help))
    }

    fn finish(
        mut self,
        path: &Path,
        wanted: u8,
        asked: &[&str],
    ) -> Result<(Vec<Stream>, ReadAs), RecordingError> {
        let mut streams = Vec::new();
        let mut descriptions = Vec::new();
        let mut provenance = Provenance::default();
        let mut chosen = Vec::new();
        let combined = if wanted == 0 { &self.triads[COMBINED][..] } else { &[] };
        let raw = [ACCEL_FIFO, ACCEL, GYRO_FIFO, GYRO].into_iter().map(|at| &self.triads[at][0]);
        let has_full_rate = raw.chain(combined).any(|triad| triad.is_within(SLOWEST_NS));
        let slowest_ns = if has_full_rate { SLOWEST_NS } else { SLOWEST_RAW_NS };
        for (choices, names) in [([ACCEL_FIFO, ACCEL], ACCELEROMETERS), ([GYRO_FIFO, GYRO], GYROS)] {
            // the batches are the sensor's own samples; the other topic is filtered in some versions
            let Some(at) = choices.into_iter().find(|at| self.triads[*at][0].is_within(slowest_ns)) else {
                continue;
            };
            chosen.push(at);
            let name = format!("{} {wanted}", TOPICS[at].name);
            let device = self.device[at].map_or_else(String::new, |id| format!(", device_id {id},"));
            let (frame, turned) = self.frame(at);
            let rate_hz = self.triads[at][0].rate_hz();
            descriptions.push(format!("{name}{device} at {rate_hz:.1} Hz{}, {turned}", self.others(at)));
            let of_sensor = SensorProvenance {
                instance: Some(wanted),
                device_id: self.device[at],
                values: Values::Raw,
                frame,
            };
            if names == GYROS {
                provenance.gyros = of_sensor;
            } else {
                provenance.accelerometers = of_sensor;
            }
            streams.push(std::mem::take(&mut self.triads[at][0]).stream(name, names));
        }
        let mut correction = "as the driver delivers them";
        let mut taken = "timestamp_sample";
        if streams.is_empty() && wanted == 0 {
            let combined = std::mem::take(&mut self.triads[COMBINED]);
            for (triad, names) in combined.into_iter().zip([GYROS, ACCELEROMETERS]) {
                if triad.is_within(SLOWEST_NS) {
                    let rate_hz = triad.rate_hz();
                    let name =
                        format!("sensor_combined {}", if names == GYROS { "gyro" } else { "accelerometer" });
                    descriptions.push(format!("{name} at {rate_hz:.1} Hz"));
                    streams.push(triad.stream(name, names));
                }
            }
            correction = "integrated from one sample to the next and already corrected by PX4 (calibration and temperature table); sensor_accel and sensor_gyro, which are not, are decimated in this log";
            taken = "timestamp";
            let by = "PX4 (calibration and temperature table)";
            provenance = Provenance::of_both(Values::Corrected(by.into()), Frame::Vehicle);
        }
        if streams.is_empty() {
            return Err(self.nothing(path, wanted));
        }
        // for a part with two dies that of the accelerometer
        let of_taken: Vec<u32> = chosen.iter().filter_map(|at| self.device[*at]).collect();
        let is_taken = |at: &usize| {
            of_taken.is_empty() || self.device[*at].is_none_or(|device| of_taken.contains(&device))
        };
        let (own, strange): (Vec<usize>, Vec<usize>) =
            [ACCEL, GYRO].into_iter().filter(|at| self.slow[*at].values.len() > 1).partition(is_taken);
        if let ([], [at, ..]) = (&own[..], &strange[..]) {
            descriptions.push(format!("temperature of {} excluded: it is another device", TOPICS[*at].name));
        }
        let temperature = own.first().copied();
        for at in temperature.into_iter().chain([POWER, LOAD]) {
            let slow = std::mem::take(&mut self.slow[at]);
            let Some((field, channel, _)) = TOPICS[at].slow.filter(|_| slow.values.len() > 1) else {
                continue;
            };
            let columns = vec![(channel.to_owned(), slow.values)];
            streams.push(Stream {
                name: format!("{}.{field}", TOPICS[at].name),
                stamps_ns: slow.stamps_ns,
                columns,
            });
        }
        let field = std::mem::take(&mut self.triads[MAG][0]);
        if field.stamps_ns.len() > 1 {
            streams.push(field.stream("sensor_mag 0".to_owned(), MAGNETOMETERS));
        }
        let chips = self.one_chip(path, &chosen, asked)?;
        let assumed = format!(
            "{}; m/s² with gravity, rad/s; {taken} in µs; {correction}{chips}",
            descriptions.join(", ")
        );
        Ok((streams, ReadAs { format: Format::Ulog, assumed, provenance: Some(provenance) }))
    }

    /// Axes of the samples of a topic, and the rotation applied to them.
    fn frame(&self, at: usize) -> (Frame, String) {
        let rotations = &self.rotations[at];
        match rotations.iter().find(|number| rotation::of_px4(**number).is_none()) {
            Some(number) => {
                let descriptions = format!("in the sensor's axes: its rotation {number} is not known");
                (Frame::Sensor, descriptions)
            }
            None if rotations.iter().any(|number| *number != 0) => {
                let numbers: Vec<String> = rotations.iter().map(u8::to_string).collect();
                (Frame::Board, format!("turned into the board's axes by its rotation {}", numbers.join(", ")))
            }
            None => (Frame::Board, "in the board's axes".to_owned()),
        }
    }

    /// Description of other readable devices and instances.
    fn others(&self, at: usize) -> String {
        let mut others = choice::other_instances(self.instances[at].len(), self.wanted);
        if !self.beside[at].is_empty() {
            others.push_str(&format!(" (not read: device {})", self.beside[at].join(", ")));
        }
        others
    }

    fn nothing(&self, path: &Path, wanted: u8) -> RecordingError {
        let found = [ACCEL, GYRO, ACCEL_FIFO, GYRO_FIFO, COMBINED].into_iter();
        let found: Vec<String> = found
            .flat_map(|at| {
                let counts = self.instances[at].iter().enumerate();
                counts.map(move |(n, count)| format!("{} {n} with {count} messages", TOPICS[at].name))
            })
            .collect();
        let found = if found.is_empty() { "no inertial topic".to_owned() } else { found.join(", ") };
        choice::no_sensors(
            path,
            Format::Ulog,
            format!("no inertial topic of instance {wanted} reaches 8 Hz; there is {found}"),
            "set SDLOG_PROFILE to 769 (default set, FIFO of gyro and accelerometer), or list sensor_accel and sensor_gyro in etc/logging/logger_topics.txt on the SD card",
        )
    }
}

/// Converts µs to ns; `None` beyond 292 years.
fn ns_of_us(us: u64) -> Option<i64> {
    i64::try_from(us).ok()?.checked_mul(1000)
}

impl Triad {
    fn push(&mut self, stamp_ns: i64, values: [f64; 3]) {
        self.stamps_ns.push(stamp_ns);
        self.values.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }

    /// Adds the samples of a batch: the last one has the message's timestamp, the others precede it at intervals of
    /// `dt`.
    fn take_batch(&mut self, fifo: &Fifo, stamp_ns: i64, data: &[u8], mounting: Option<&Matrix>) {
        let (Some(dt_us), Some(scale)) = (float(data, fifo.dt), float(data, fifo.scale)) else { return };
        let samples = data.get(fifo.samples).map_or(0, |n| usize::from(*n)).min(fifo.room);
        if !dt_us.is_finite() {
            return;
        }
        for sample in 0..samples {
            let before_ns = (samples - 1 - sample) as f64 * dt_us * 1000.0;
            let values = fifo.axes.map(|axis| {
                let count = field(data, axis + 2 * sample).map(i16::from_le_bytes);
                count.map_or(f64::NAN, |count| f64::from(count) * scale)
            });
            let values = mounting.map_or(values, |matrix| rotation::turned(matrix, values));
            self.push(stamp_ns.saturating_sub(before_ns.round() as i64), values);
        }
    }

    /// Median period of the samples, ns.
    fn period_ns(&self) -> Option<f64> {
        let steps = self.stamps_ns.windows(2).map(|pair| pair[1].wrapping_sub(pair[0]) as f64);
        median_of(steps.filter(|step| *step > 0.0))
    }

    fn is_within(&self, longest_ns: f64) -> bool {
        self.period_ns().is_some_and(|period_ns| period_ns <= longest_ns)
    }

    /// Rate, Hz; 0 if there is none.
    fn rate_hz(&self) -> f64 {
        self.period_ns().map_or(0.0, |period_ns| 1e9 / period_ns)
    }

    fn stream(self, name: String, names: [&str; 3]) -> Stream {
        let columns = names.into_iter().zip(self.values).map(|(name, values)| (name.to_owned(), values));
        Stream { name, stamps_ns: self.stamps_ns, columns: columns.collect() }
    }
}
