//! Logs of GENEActiv wrist-worn accelerometers (`.bin`): a header of text, then pages of text, each with its time, its
//! temperature and 300 samples in hexadecimal.
//!
//! A sample has 48 bits: 12 for each axis as a signed number, 10 for the light, one for the button, one unused. The
//! header states how a number becomes an acceleration: `(100 × number − offset) / gain` is in g.

use std::io::{BufRead, Read};
use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::provenance::{Frame, Provenance, Values};
use super::opened::Opened;
use super::wearable::{Blocks, is_rate, ns_since_1970};
use super::{Format, choice};
use crate::file::FileError;
use crate::interrupt;
use crate::unit::STANDARD_GRAVITY_MPS2;

/// Hexadecimal digits of one sample.
const DIGITS: usize = 12;

/// Longest line of a page, bytes: the format fixes its length to 300 samples.
const LONGEST_LINE: u64 = 1 << 16;

/// Returns true if a file begins like such a log.
pub(super) fn is(begin: &[u8]) -> bool {
    let names = |word: &[u8]| begin.windows(word.len()).take(1024).any(|part| part == word);
    begin.starts_with(b"Device Identity") && names(b"GENEActiv")
}

/// Gain and offset of each axis, NaN until the header states them.
struct Calibration {
    gain: [f64; 3],
    offset: [f64; 3],
}

/// Values from the lines above the samples of a page.
#[derive(Default)]
struct Page {
    start_ns: Option<i64>,
    celsius: Option<f64>,
    rate_hz: Option<f64>,
}

pub(super) fn read(
    path: &Path,
    mut input: impl BufRead,
    options: &LoadOptions,
) -> Result<Opened, RecordingError> {
    let mut calibration = Calibration { gain: [f64::NAN; 3], offset: [f64::NAN; 3] };
    let mut header_hz = None;
    let mut serial = String::new();
    let (mut page, mut in_pages, mut has_samples) = (Page::default(), false, true);
    let mut blocks = Blocks::default();
    let mut line = Vec::new();
    loop {
        line.clear();
        let n = input.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line);
        if n.map_err(FileError::reading(path))? == 0 {
            break;
        }
        interrupt::check();
        let text = line.trim_ascii();
        if text == b"Recorded Data" {
            if !in_pages {
                let is_sound =
                    |axis: usize| calibration.gain[axis] != 0.0 && calibration.offset[axis].is_finite();
                if !(0..3).all(|axis| calibration.gain[axis].is_finite() && is_sound(axis)) {
                    let problem = "the header states no gain and offset for each axis".to_owned();
                    let help = "extract the .bin file from the device again with the GENEActiv software";
                    return Err(choice::no_sensors(path, Format::GeneActiv, problem, help));
                }
            }
            blocks.damaged += u64::from(!has_samples);
            (page, in_pages, has_samples) = (Page { rate_hz: header_hz, ..Page::default() }, true, false);
            continue;
        }
        if let Some((name, value)) = split(text) {
            let number = || value.split(' ').next().and_then(|number| number.parse::<f64>().ok());
            match name {
                "Page Time" => page.start_ns = time(value),
                "Temperature" => page.celsius = number(),
                "Measurement Frequency" => {
                    let rate_hz = number().filter(|rate_hz| is_rate(*rate_hz));
                    if in_pages { page.rate_hz = rate_hz.or(page.rate_hz) } else { header_hz = rate_hz }
                }
                "Device Unique Serial Code" if serial.is_empty() => value.clone_into(&mut serial),
                _ if !in_pages => calibration.take(name, number()),
                _ => {}
            }
            continue;
        }
        if in_pages && !has_samples && !text.is_empty() {
            has_samples = true;
            match (page.start_ns, page.rate_hz, samples(text)) {
                (Some(start_ns), Some(rate_hz), Some(samples)) => {
                    let count = samples.len();
                    samples.into_iter().for_each(|raw| blocks.push(Some(calibration.mps2(raw)), None));
                    let celsius = page.celsius.filter(|celsius| celsius.is_finite());
                    blocks.end(start_ns, rate_hz, count, celsius.unwrap_or(f64::NAN));
                }
                _ => blocks.damaged += 1,
            }
        }
    }
    blocks.damaged += u64::from(!has_samples);
    let assumed = format!(
        "GENEActiv {serial}, by the gain and offset in its header, in g with gravity; its clock shows local time"
    );
    let values = Values::Corrected("the factory gain and offset in the header".into());
    let provenance = Provenance::of_both(values, Frame::Sensor);
    blocks.opened(path, Format::GeneActiv, options, &assumed, provenance)
}

/// Splits a line `name:value`; samples have no colon.
fn split(line: &[u8]) -> Option<(&str, &str)> {
    let (name, value) = std::str::from_utf8(line).ok()?.split_once(':')?;
    Some((name.trim(), value.trim()))
}

/// Parses a time such as `2012-05-23 16:47:50:000`, the last number in ms.
fn time(text: &str) -> Option<i64> {
    let (date, time) = text.split_once(' ')?;
    let numbers = |text: &str, at: char| -> Option<Vec<i64>> {
        text.split(at).map(|number| number.trim().parse().ok()).collect()
    };
    let date: [i64; 3] = numbers(date, '-')?.try_into().ok()?;
    let [hour, minute, second, ms] = numbers(time, ':')?.try_into().ok()?;
    let ms: i64 = Some(ms).filter(|ms| (0..1000).contains(ms))?;
    ns_since_1970(date, [hour, minute, second])?.checked_add(ms * 1_000_000)
}

/// Samples of a page, three signed numbers each; `None` if the line is cut short or holds something else.
fn samples(line: &[u8]) -> Option<Vec<[i16; 3]>> {
    if !line.len().is_multiple_of(DIGITS) {
        return None;
    }
    let axis = |digits: &[u8]| -> Option<i16> {
        let raw = i16::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
        // a sign before the digits is not part of the format
        digits.iter().all(u8::is_ascii_hexdigit).then_some(if raw < 0x800 { raw } else { raw - 0x1000 })
    };
    let sample = |digits: &[u8]| Some([axis(&digits[..3])?, axis(&digits[3..6])?, axis(&digits[6..9])?]);
    line.chunks_exact(DIGITS).map(sample).collect()
}

impl Calibration {
    fn take(&mut self, name: &str, value: Option<f64>) {
        let (Some(value), Some((axis, what))) = (value, name.split_once(' ')) else { return };
        let Some(axis) = ["x", "y", "z"].iter().position(|known| *known == axis) else { return };
        match what {
            "gain" => self.gain[axis] = value,
            "offset" => self.offset[axis] = value,
            _ => {}
        }
    }

    fn mps2(&self, raw: [i16; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let g = (100.0 * f64::from(raw[axis]) - self.offset[axis]) / self.gain[axis];
            g * STANDARD_GRAVITY_MPS2
        })
    }
}
