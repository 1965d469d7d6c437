//! A small image, byte by byte, as docs/MODEL_FORMAT.md describes it; written without the encoder that it checks.
#![allow(unreachable_pub)] // a module of a test

use fos_core::{
    Axis, AxisParameters, InnovationStatistics, Input, Quantity, Range, Source, StillnessLimits, Term,
    Transform, u, y,
};

use fos_core::Info;
use fos_testkit::models::{OwnedAxis, OwnedModel};

/// Bytes with their meaning.
#[derive(Debug, Clone)]
pub struct Field {
    pub meaning: &'static str,
    pub bytes: Vec<u8>,
}

pub const INFO: Info<'_> = Info {
    sensor: "example",
    quantities: "temp_c °C",
    effects: "thermal_lag",
    provenance: "written by hand",
};

/// The model encoded by the bytes below.
pub fn model() -> OwnedModel<f32> {
    OwnedModel {
        period_s: 0.005,
        stillness: Some(StillnessLimits {
            window: 100,
            accel_variance: 0.0015,
            gyro_variance: 7.5e-6,
            gyro_at_rest: [0.0, 0.0, 0.01],
            gyro_deviation: 0.0087,
        }),
        calibration: None,
        quantities: vec![Quantity::Temperature, Quantity::Measured(Axis::Az)],
        inputs: vec![
            Input {
                source: Source::Quantity(0),
                transform: Transform::LowPass { tau_s: 20.0 },
                centre: 30.0,
                scale: 10.0,
                source_range: Range::new(-1.0, 1.5),
                range: Range::new(-0.9, 1.25),
            },
            Input {
                source: Source::Clock,
                transform: Transform::Time,
                centre: 600.0,
                scale: 350.0,
                source_range: Range::new(-1.7, 1.7),
                range: Range::new(-1.7, 1.7),
            },
        ],
        axes: vec![OwnedAxis {
            parameters: AxisParameters {
                axis: Axis::Gz,
                reference: 0.0,
                offset: 0.01,
                scale: 0.002,
                constant: 0.125,
                range: Range::new(-4.0, 4.0),
                physical_range: Range::new(-0.5, 0.75),
                full_scale: 4.36,
                stuck_after_repeats: 200,
                gap_limit_samples: 20,
                coast_limit_s: 10.0,
                innovation: InnovationStatistics { mean: 0.0, variance: 0.25, lag_1_correlation: -0.5 },
            },
            physical: vec![Term::new(0.75, &[u(0, 0)])],
            stochastic: vec![Term::new(0.5, &[y(1)]), Term::new(-0.03125, &[y(2), u(1, 300)])],
        }],
    }
}

fn field(meaning: &'static str, bytes: &[u8]) -> Field {
    Field { meaning, bytes: bytes.to_vec() }
}

fn single(meaning: &'static str, value: f32) -> Field {
    field(meaning, &value.to_le_bytes())
}

fn string(length: &'static str, meaning: &'static str, value: &str) -> [Field; 2] {
    // one byte of length: shorter than 128
    [field(length, &[value.len() as u8]), field(meaning, value.as_bytes())]
}

pub fn body() -> Vec<Field> {
    vec![
        field("period_s, f64", &0.005_f64.to_le_bytes()),
        field("fitted_on: Raw", &[0]),
        field("stillness: Some", &[1]),
        field("  window: 100", &[100]),
        single("  accel_variance", 0.0015),
        single("  gyro_variance", 7.5e-6),
        single("  gyro_at_rest x", 0.0),
        single("  gyro_at_rest y", 0.0),
        single("  gyro_at_rest z", 0.01),
        single("  gyro_deviation", 0.0087),
        field("n_quantities", &[2]),
        field("n_inputs", &[2]),
        field("n_axes", &[1]),
        field("quantity 0: Temperature", &[0]),
        field("quantity 1: Measured", &[6]),
        field("  axis: Az", &[2]),
        field("input 0: source: Quantity", &[1]),
        field("  index", &[0]),
        field("  transform: LowPass", &[1]),
        single("  tau_s: 20", 20.0),
        single("  centre: 30", 30.0),
        single("  scale: 10", 10.0),
        single("  source_range low", -1.0),
        single("  source_range high", 1.5),
        single("  range low", -0.9),
        single("  range high", 1.25),
        field("input 1: source: Clock", &[0]),
        field("  transform: Time", &[7]),
        single("  centre: 600", 600.0),
        single("  scale: 350", 350.0),
        single("  source_range low", -1.7),
        single("  source_range high", 1.7),
        single("  range low", -1.7),
        single("  range high", 1.7),
        field("axis 0: Gz", &[5]),
        single("  reference", 0.0),
        single("  offset", 0.01),
        single("  scale", 0.002),
        single("  constant", 0.125),
        single("  range low", -4.0),
        single("  range high", 4.0),
        single("  physical_range low", -0.5),
        single("  physical_range high", 0.75),
        single("  full_scale", 4.36),
        field("  stuck_after_repeats: 200, two bytes", &[0xc8, 0x01]),
        field("  gap_limit_samples", &[20]),
        single("  coast_limit_s", 10.0),
        single("  innovation mean", 0.0),
        single("  innovation variance", 0.25),
        single("  innovation lag_1_correlation", -0.5),
        field("  n_physical", &[1]),
        field("  n_stochastic", &[2]),
        single("  term 0: coefficient", 0.75),
        field("    degree", &[1]),
        field("    channel: Input", &[1]),
        field("      index", &[0]),
        field("    lag", &[0]),
        single("  term 1: coefficient", 0.5),
        field("    degree", &[1]),
        field("    channel: Output", &[0]),
        field("    lag", &[1]),
        single("  term 2: coefficient", -0.03125),
        field("    degree", &[2]),
        field("    channel: Output", &[0]),
        field("    lag", &[2]),
        field("    channel: Input", &[1]),
        field("      index", &[1]),
        field("    lag: 300, two bytes", &[0xac, 0x02]),
    ]
}

pub fn information() -> Vec<Field> {
    [
        string("sensor: length", "sensor", INFO.sensor),
        string("quantities: length", "quantities", INFO.quantities),
        string("effects: length", "effects", INFO.effects),
        string("provenance: length", "provenance", INFO.provenance),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub fn bytes(fields: &[Field]) -> Vec<u8> {
    fields.iter().flat_map(|field| field.bytes.clone()).collect()
}

/// Header with a correct checksum for a body and an information block.
pub fn header(body: &[u8], information: &[u8]) -> Vec<Field> {
    let mut fields = vec![
        field("magic: FOSM", b"FOSM"),
        field("version: 1", &1_u16.to_le_bytes()),
        field("flags: 0", &0_u16.to_le_bytes()),
        field("length of the body", &(body.len() as u32).to_le_bytes()),
        field("length of the information", &(information.len() as u32).to_le_bytes()),
    ];
    let checksum = crc_32(&[&bytes(&fields), body, information].concat());
    fields.push(field("checksum", &checksum.to_le_bytes()));
    fields
}

pub fn assemble(body: &[u8], information: &[u8]) -> Vec<u8> {
    [&bytes(&header(body, information)), body, information].concat()
}

/// Corrects the checksum after a change.
pub fn sealed(mut image: Vec<u8>) -> Vec<u8> {
    let checksum = crc_32(&[&image[..16], &image[20..]].concat());
    image[16..20].copy_from_slice(&checksum.to_le_bytes());
    image
}

/// CRC-32 as in IEEE 802.3, bit by bit: reflected polynomial 0xedb88320, start and end inverted.
pub fn crc_32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |mut crc, &byte| {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
        }
        crc
    })
}

/// The image line by line: offset, bytes, meaning.
pub fn dump() -> String {
    let (body, information) = (body(), information());
    let header = header(&bytes(&body), &bytes(&information));
    let mut offset = 0;
    let mut text = String::new();
    for (title, fields) in [("header", header), ("body", body), ("information", information)] {
        text += &format!("; {title}\n");
        for Field { meaning, bytes } in fields {
            // at most eight bytes per line
            for (line, chunk) in bytes.chunks(8).enumerate() {
                let hex: Vec<String> = chunk.iter().map(|byte| format!("{byte:02x}")).collect();
                let meaning = if line == 0 { meaning } else { "  …" };
                text += format!("{offset:04x}  {:<23}  {meaning}", hex.join(" ")).trim_end();
                text += "\n";
                offset += chunk.len();
            }
        }
    }
    text
}
