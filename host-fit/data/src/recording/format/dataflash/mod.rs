//! ArduPilot's DataFlash logs: a stream of messages whose layouts are in the log itself, in messages named FMT.
//!
//! Inertial messages, their fields and units are those of `AP_InertialSensor/LogStructure.h`; the corrections of a
//! sample before logging, undone here, are those of `AP_InertialSensor_Backend.cpp` (`correction`).

mod correction;
mod messages;

use std::io::BufRead;
use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::provenance::{Frame, Provenance, SensorProvenance, Values};
use super::super::stream::Stream;
use super::opened::Opened;
use super::{Format, ReadAs, choice};
use crate::column::Triad;
use correction::{Correction, Parameters, Undone, device_ids};
use messages::{Messages, Reader};

/// Messages of one kind with their timestamps, a column for each of their fields.
struct Samples<const FIELDS: usize> {
    stamps_ns: Vec<i64>,
    values: [Vec<f64>; FIELDS],
}

/// Data gathered from the log.
#[derive(Default)]
struct Gathered {
    acc: Samples<3>,
    gyr: Samples<3>,
    /// Three accelerations, three rates, and the temperature.
    imu: Samples<7>,
    /// Number of IMU messages of each instance.
    instances: Vec<u64>,
    /// Each instance has its own message, such as `IMU2`, in logs up to 2020.
    has_numbered_messages: bool,
    parameters: Parameters,
    volts: Samples<1>,
}

pub(super) fn read(
    path: &Path,
    input: impl BufRead,
    options: &LoadOptions,
) -> Result<Opened, RecordingError> {
    let mut wanted = choice::instance(path, Format::Dataflash, options.topic.as_deref(), &["IMU"])?;
    // the second and third IMU have messages of these names in logs whose IMU message states no instance
    let numbered = match options.topic.as_deref().map(str::trim) {
        Some("IMU2") => 1,
        Some("IMU3") => 2,
        _ => wanted,
    };
    let mut gathered = Gathered::default();
    let mut messages = Messages::new(path, input);
    while let Some((reader, payload)) = messages.next()? {
        gathered.take(reader, payload, wanted, numbered);
    }
    if gathered.has_numbered_messages {
        wanted = numbered;
    }
    let (lost, is_cut) = (messages.bytes_lost(), messages.is_cut());
    let problem = (lost > 0 || is_cut)
        .then(|| if is_cut { "it is cut short".to_owned() } else { format!("{lost} bytes are no messages") });
    choice::refuse_damage(path, Format::Dataflash, options.strict, problem.as_deref(), 0)?;
    let Gathered { acc, gyr, imu, instances, parameters, volts, .. } = gathered;
    let is_raw = acc.stamps_ns.len() > 1 && gyr.stamps_ns.len() > 1;
    if !is_raw && imu.stamps_ns.len() < 2 {
        let there: Vec<String> =
            instances.iter().enumerate().map(|(n, count)| format!("IMU {n} with {count} messages")).collect();
        let there = if there.is_empty() { "no message IMU, ACC or GYR".to_owned() } else { there.join(", ") };
        return Err(choice::no_sensors(
            path,
            Format::Dataflash,
            format!(
                "there are no samples of {}; there is {there}",
                options.topic.as_ref().map_or_else(|| "IMU 0".to_owned(), |topic| format!("\"{topic}\""))
            ),
            "set the IMU_RAW bit of LOG_BITMASK (every sample), or its IMU bit, and record again",
        ));
    }
    let Samples { stamps_ns: imu_ns, values: [ax, ay, az, gx, gy, gz, temperature] } = imu;
    let warmth = Some((&imu_ns[..], &temperature[..])).filter(|(stamps, _)| stamps.len() > 1);
    let correction = Correction::of(&parameters, wanted);
    let mut streams = Vec::new();
    let mut done = Vec::new();
    let described = if is_raw {
        for (name, triad, samples) in [("ACC", Triad::Accelerometers, acc), ("GYR", Triad::Gyros, gyr)] {
            let Samples { stamps_ns, mut values } = samples;
            done.push(correction.undo(triad, &stamps_ns, &mut values, warmth));
            let columns = named(triad, values).collect();
            streams.push(Stream { name: format!("{name} {wanted}"), stamps_ns, columns });
        }
        if imu_ns.len() > 1 {
            let columns = vec![("temp_c".to_owned(), temperature)];
            streams.push(Stream { name: format!("IMU {wanted}.T"), stamps_ns: imu_ns, columns });
        }
        format!("ACC and GYR {wanted}, every sample, by SampleUS")
    } else {
        let (mut force, mut rate) = ([ax, ay, az], [gx, gy, gz]);
        done.push(correction.undo(Triad::Accelerometers, &imu_ns, &mut force, warmth));
        done.push(correction.undo(Triad::Gyros, &imu_ns, &mut rate, warmth));
        let columns = named(Triad::Accelerometers, force).chain(named(Triad::Gyros, rate));
        let mut columns: Vec<(String, Vec<f64>)> = columns.collect();
        if temperature.iter().any(|value| value.is_finite()) {
            columns.push(("temp_c".to_owned(), temperature));
        }
        streams.push(Stream { name: format!("IMU {wanted}"), stamps_ns: imu_ns, columns });
        format!("IMU {wanted} by TimeUS or TimeMS, filtered and thinned out by ArduPilot")
    };
    let Samples { stamps_ns, values: [volts] } = volts;
    if stamps_ns.len() > 1 {
        let columns = vec![("supply_v".to_owned(), volts)];
        streams.push(Stream { name: "POWR.Vcc".to_owned(), stamps_ns, columns });
    }
    let others = choice::other_instances(instances.len(), wanted);
    let damaged =
        if lost > 0 { format!("; {lost} bytes of the file are no messages") } else { String::new() };
    let cut = if is_cut { "; the file is cut short within a message" } else { "" };
    let corrections = if parameters.is_empty() {
        "no parameters in the log, so that ArduPilot's corrections are not known and left in the values"
            .to_owned()
    } else {
        in_words(&done)
    };
    let assumed = format!("{described}{others}; m/s² with gravity, rad/s; {corrections}{damaged}{cut}");
    let provenance = provenance(&parameters, wanted, &done);
    Ok(Opened::Streams(streams, ReadAs { format: Format::Dataflash, assumed, provenance: Some(provenance) }))
}

/// Corrections of accelerometers and gyros that were undone and that were not, in words.
fn in_words(done: &[Undone]) -> String {
    let all = |which: fn(&Undone) -> &Vec<String>| {
        let mut all: Vec<&str> = Vec::new();
        for name in done.iter().flat_map(which) {
            if !all.contains(&name.as_str()) {
                all.push(name);
            }
        }
        all.join(", ")
    };
    let (undone, left) = (all(|done| &done.undone), all(|done| &done.left));
    match (undone.as_str(), left.as_str()) {
        ("", "") => "no correction by the parameters in the log".to_owned(),
        (undone, "") => format!("ArduPilot's corrections undone: {undone}"),
        ("", left) => format!("ArduPilot's corrections left in the values: {left}"),
        (undone, left) => {
            format!("ArduPilot's corrections undone: {undone}; left in the values: {left}")
        }
    }
}

/// Sensor, corrections and frame of the values of accelerometers and gyros, after undoing `done`.
fn provenance(parameters: &Parameters, instance: u8, done: &[Undone]) -> Provenance {
    let ids = device_ids(parameters, instance);
    let of = |sensor: usize| {
        let in_vehicle = done[sensor].in_vehicle;
        // a rotation alone corrects nothing
        let corrections: Vec<&str> =
            done[sensor].left.iter().skip(usize::from(in_vehicle)).map(String::as_str).collect();
        let (values, frame) = match (parameters.is_empty(), in_vehicle) {
            (true, _) => (Values::Unstated, Frame::Unstated),
            (false, true) => (corrections_left(&corrections), Frame::Vehicle),
            (false, false) => (corrections_left(&corrections), Frame::Board),
        };
        SensorProvenance { instance: Some(instance), device_id: ids[sensor], values, frame }
    };
    Provenance { accelerometers: of(0), gyros: of(1) }
}

fn corrections_left(names: &[&str]) -> Values {
    if names.is_empty() {
        return Values::Raw;
    }
    Values::Corrected(format!("ArduPilot: {}", names.join(", ")).into())
}

/// Axes of a triad with their names.
fn named(triad: Triad, values: [Vec<f64>; 3]) -> impl Iterator<Item = (String, Vec<f64>)> {
    triad.columns().into_iter().map(str::to_owned).zip(values)
}

impl Gathered {
    fn take(&mut self, reader: &Reader, payload: &[u8], wanted: u8, numbered: u8) {
        match reader.name() {
            "PARM" => {
                if let (Some(name), Some(value)) =
                    (reader.text("Name", payload), reader.number("Value", payload))
                {
                    // the first value is the one in force when sampling began
                    self.parameters.entry(name).or_insert(value);
                }
            }
            "POWR" => {
                if let (Some(stamp), Some(volts)) = (reader.stamp_ns(payload), reader.number("Vcc", payload))
                {
                    self.volts.push(stamp, [volts]);
                }
            }
            "ACC" if instance(reader, payload) == wanted => {
                self.acc.take(reader, payload, ["AccX", "AccY", "AccZ"]);
            }
            "GYR" if instance(reader, payload) == wanted => {
                self.gyr.take(reader, payload, ["GyrX", "GyrY", "GyrZ"]);
            }
            "IMU" => {
                let wanted = if reader.has("I") { wanted } else { numbered };
                self.take_imu(reader, payload, instance(reader, payload), wanted);
            }
            "IMU2" => self.take_numbered(reader, payload, 1, numbered),
            "IMU3" => self.take_numbered(reader, payload, 2, numbered),
            _ => {}
        }
    }

    fn take_numbered(&mut self, reader: &Reader, payload: &[u8], instance: u8, wanted: u8) {
        self.has_numbered_messages = true;
        self.take_imu(reader, payload, instance, wanted);
    }

    fn take_imu(&mut self, reader: &Reader, payload: &[u8], instance: u8, wanted: u8) {
        let n = usize::from(instance);
        self.instances.resize(self.instances.len().max(n + 1), 0);
        self.instances[n] += 1;
        if instance == wanted {
            // `Temp` up to 2016
            let celsius = if reader.has("T") { "T" } else { "Temp" };
            self.imu.take(reader, payload, ["AccX", "AccY", "AccZ", "GyrX", "GyrY", "GyrZ", celsius]);
        }
    }
}

/// Instance of a message; 0 in old logs, which had one.
fn instance(reader: &Reader, payload: &[u8]) -> u8 {
    reader.number("I", payload).map_or(0, |instance| instance as u8)
}

impl<const FIELDS: usize> Default for Samples<FIELDS> {
    fn default() -> Self {
        Self { stamps_ns: Vec::new(), values: [const { Vec::new() }; FIELDS] }
    }
}

impl<const FIELDS: usize> Samples<FIELDS> {
    /// Adds a message that has a timestamp; a field that it lacks is missing.
    fn take(&mut self, reader: &Reader, payload: &[u8], fields: [&str; FIELDS]) {
        let Some(stamp) = reader.stamp_ns(payload) else { return };
        self.push(stamp, fields.map(|field| reader.number(field, payload).unwrap_or(f64::NAN)));
    }

    fn push(&mut self, stamp_ns: i64, values: [f64; FIELDS]) {
        self.stamps_ns.push(stamp_ns);
        self.values.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
}
