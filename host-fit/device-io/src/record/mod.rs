//! Converts a stream of telemetry into a log.

pub mod arriving;
mod end;
pub mod received_file;

use fos_data::column::Column;
use std::io::{self, BufRead};

use fos_embedded::telemetry::{Frame, SampleFrame, StartFrame, TelemetryError, VERSION, decode};
use serde::Serialize;

/// Longest accepted frame, bytes; longer ones are not telemetry.
const LONGEST: u64 = 4096;

/// Number of bytes without a valid frame after which the stream is refused: some twenty seconds of a serial port at 115200 baud.
const STRANGE: u64 = 1 << 18;

/// Largest increase of the tick from one sample to the next; a larger one is a restart.
const MAX_INCREASE: u32 = 1 << 31;

/// Largest increase across a wrap of the counter: 3.9 days at 200 Hz. The tick of a restarted device decreases too, and as a wrap it would
/// be a gap of up to months.
const MAX_INCREASE_IN_WRAP: u32 = 1 << 26;

/// A stream cannot be converted into a log.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    #[error(
        "the stream cannot be read: {0}\nhelp: is the device connected, and may you read its port (on Linux: are you in the group dialout)?"
    )]
    Read(#[from] io::Error),
    #[error(
        "the device sends telemetry of version {found}; this program reads version {VERSION}\nhelp: use the fos that came with the firmware"
    )]
    Version {
        /// Version of the telemetry.
        found: u16,
    },
    #[error(
        "nothing came\nhelp: is the device on, and is this its port? A FIFO needs somebody who writes into it"
    )]
    Silent,
    /// The stream has data but no frames, and does not end.
    #[error(
        "no frame of telemetry in the first {bytes} bytes\nhelp: is it the telemetry of fos, at the right baud rate, as `stty -F PORT raw 115200` sets it? In a file, what comes before it can be cut off: `tail -c +{bytes} FILE | fos record - -o LOG`"
    )]
    Strange { bytes: u64 },
    #[error(
        "no sample in {bytes} bytes ({damaged} damaged frames)\nhelp: is it the telemetry of fos, at the right baud rate? A device sends what its samples hold once a minute: wait for it"
    )]
    Nothing { bytes: u64, damaged: u64 },
}

impl RecordError {
    /// The stream may be readable by another program, so its bytes are preserved.
    pub fn holds_something(&self) -> bool {
        matches!(self, Self::Version { .. })
    }
}

/// A log, with statistics of lost data.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Names and values of the columns.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Statistics of lost data.
    pub report: Report,
}

/// Received and lost data.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Report {
    /// Complete samples.
    pub samples: u64,
    /// Samples missing from the tick counter: gaps in the log.
    pub lost: u64,
    /// Frames that could not be decoded.
    pub damaged: u64,
    /// Samples received before the start frame that defines their columns.
    pub unknown: u64,
    /// Restarts of the device, each beginning a new segment.
    pub restarts: u64,
    /// Bytes read.
    pub bytes: u64,
    /// Reason of an early end of the stream; none if it was read to its end.
    pub broken_off: Option<String>,
}

/// Reads `stream` to its end. If it fails midway, the samples until then are the log.
pub fn record(stream: impl BufRead) -> Result<Recorded, RecordError> {
    record_watched(stream, f64::INFINITY, |_| {})
}

/// Does what [`record`] does, and shows `watch` the log so far every `every_s` of its time. Meanwhile nothing is read: a stream must be able to wait.
pub fn record_watched(
    mut stream: impl BufRead,
    every_s: f64,
    mut watch: impl FnMut(&Recorded),
) -> Result<Recorded, RecordError> {
    let mut log = Log::default();
    let mut next_s = every_s;
    let mut frame = Vec::new();
    let (mut joined, mut is_telemetry) = (false, false);
    loop {
        frame.clear();
        let read = match io::Read::take(&mut stream, LONGEST).read_until(0, &mut frame) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) if log.report.samples > 0 => {
                log.report.broken_off = Some(error.to_string());
                break;
            }
            Err(error) => return Err(error.into()),
        };
        log.report.bytes += read as u64;
        if frame != [0] {
            let decoded = decode::<Frame<&str, Vec<f32>, Vec<u16>>>(&mut frame);
            is_telemetry |= decoded.is_ok();
            match decoded {
                Ok(Frame::Start(start)) => log.start(&start)?,
                Ok(Frame::Sample(sample)) => {
                    log.sample(&sample);
                    let now_s = log.time_s.last().copied().unwrap_or_default();
                    if now_s >= next_s {
                        next_s = now_s + every_s;
                        log.clone().recorded().iter().for_each(&mut watch);
                    }
                }
                Err(TelemetryError::OtherVersion(found)) => return Err(RecordError::Version { found }),
                // A late start begins in the middle of a frame.
                Err(_) if !joined => {}
                Err(_) => log.report.damaged += 1,
            }
        }
        joined = true;
        if !is_telemetry && log.report.bytes >= STRANGE {
            return Err(RecordError::Strange { bytes: log.report.bytes });
        }
    }
    log.finish()
}

#[derive(Clone, Default)]
struct Log {
    names: Option<Names>,
    period_s: f64,
    /// Ticks since the first sample, and the counter value of the last.
    tick: Option<(u64, u32)>,
    time_s: Vec<f64>,
    segment: Vec<f64>,
    still: Vec<f64>,
    values: Vec<Vec<f64>>,
    report: Report,
}

/// Columns of a log, as named in its start frame.
#[derive(Clone)]
struct Names {
    axes: Vec<String>,
    quantities: Vec<String>,
}

impl Log {
    fn start(&mut self, start: &StartFrame<&str>) -> Result<(), RecordError> {
        if start.version != VERSION {
            return Err(RecordError::Version { found: start.version });
        }
        if !(start.period_s.is_finite() && start.period_s > 0.0) {
            self.report.damaged += 1;
            return Ok(());
        }
        let lines = |text: &str| text.lines().map(str::to_owned).collect();
        let names = Names { axes: lines(start.axes), quantities: lines(start.quantities) };
        // The columns are fixed after the first sample; other frames are ignored.
        if self.time_s.is_empty() {
            self.values = vec![Vec::new(); 3 * names.axes.len() + names.quantities.len()];
            self.names = Some(names);
            self.period_s = f64::from(start.period_s);
        }
        Ok(())
    }

    fn sample(&mut self, sample: &SampleFrame<Vec<f32>, Vec<u16>>) {
        let fits = self.names.as_ref().is_some_and(|names| {
            let n = names.axes.len();
            sample.measured.len() == n
                && sample.innovations.len() == n
                && sample.validity.len() == n
                && sample.quantities.len() == names.quantities.len()
        });
        if !fits {
            self.report.unknown += 1;
            return;
        }
        let ticks = match self.tick {
            None => 0,
            Some((ticks, counter)) => {
                let limit = if sample.tick < counter { MAX_INCREASE_IN_WRAP } else { MAX_INCREASE };
                match sample.tick.wrapping_sub(counter) {
                    0 => return,
                    ahead if ahead < limit => {
                        self.report.lost += u64::from(ahead) - 1;
                        ticks + u64::from(ahead)
                    }
                    _ => {
                        self.report.restarts += 1;
                        ticks + 1
                    }
                }
            }
        };
        self.tick = Some((ticks, sample.tick));
        self.report.samples += 1;
        self.time_s.push(ticks as f64 * self.period_s);
        self.segment.push(self.report.restarts as f64);
        self.still.push(f64::from(u8::from(sample.still)));
        let values = sample
            .measured
            .iter()
            .chain(&sample.quantities)
            .chain(&sample.innovations)
            .map(|value| f64::from(*value))
            .chain(sample.validity.iter().map(|bits| f64::from(*bits)));
        self.values.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }

    fn finish(self) -> Result<Recorded, RecordError> {
        let Report { bytes, damaged, .. } = self.report;
        match self.recorded() {
            Some(recorded) => Ok(recorded),
            None if bytes == 0 => Err(RecordError::Silent),
            None => Err(RecordError::Nothing { bytes, damaged }),
        }
    }

    /// The log so far; none before its first sample.
    fn recorded(self) -> Option<Recorded> {
        let names = self.names.filter(|_| !self.time_s.is_empty())?;
        let axes = || names.axes.iter().map(|axis| Column::named(axis));
        let of_values = names.axes.iter().cloned().chain(names.quantities.iter().cloned());
        let of_values = of_values.chain(axes().map(Column::innovation)).chain(axes().map(Column::validity));
        let mut columns = vec![
            ("t_s".to_owned(), self.time_s),
            ("still".to_owned(), self.still),
            ("segment".to_owned(), self.segment),
        ];
        columns.extend(of_values.zip(self.values));
        Some(Recorded { columns, report: self.report })
    }
}

#[cfg(test)]
mod tests {
    use fos_core::Validity;
    use fos_embedded::telemetry::{Borrowed, encode};

    use super::*;

    const START: StartFrame<&str> =
        StartFrame { version: VERSION, period_s: 0.005, axes: "gx_rads", quantities: "temp_c" };

    fn stream(frames: &[Borrowed<'_>]) -> Vec<u8> {
        let mut buffer = [0; 256];
        frames.iter().flat_map(|frame| encode(frame, &mut buffer).expect("fits").to_vec()).collect()
    }

    fn sample(tick: u32) -> Vec<u8> {
        let frame = SampleFrame {
            tick,
            still: tick.is_multiple_of(2),
            measured: &[tick as f32][..],
            quantities: &[21.5][..],
            innovations: &[f32::NAN][..],
            validity: &[if tick == 1 { Validity::STUCK } else { Validity::VALID }][..],
        };
        stream(&[Frame::Sample(frame)])
    }

    fn column(recorded: &Recorded, name: &str) -> Vec<f64> {
        recorded.columns.iter().find(|(column, _)| column == name).expect("a column").1.clone()
    }

    fn read(bytes: &[u8]) -> Recorded {
        record(bytes).expect("a log")
    }

    #[test]
    fn lost_frames_become_gaps_of_the_log() {
        let mut bytes = stream(&[Frame::Start(START)]);
        [0, 1, 2, 5, 6].map(sample).iter().for_each(|frame| bytes.extend(frame));
        let recorded = read(&bytes);
        assert_eq!(
            recorded.report,
            Report { samples: 5, lost: 2, bytes: bytes.len() as u64, ..Report::default() }
        );
        let times = column(&recorded, "t_s");
        let wanted = [0.0, 0.005, 0.01, 0.025, 0.03];
        // The period is transmitted as f32.
        assert!(times.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{times:?}");
        assert_eq!(column(&recorded, "gx_rads"), [0.0, 1.0, 2.0, 5.0, 6.0]);
        assert_eq!(column(&recorded, "validity_gx_rads"), [0.0, 256.0, 0.0, 0.0, 0.0]);
        assert!(column(&recorded, "innovation_gx_rads").iter().all(|value| value.is_nan()));
    }

    #[test]
    fn failed_stream_gives_a_log_of_its_start() {
        struct Pulled<'a>(&'a [u8]);
        impl io::Read for Pulled<'_> {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                match self.0.read(buffer)? {
                    0 => Err(io::Error::other("no such device")),
                    read => Ok(read),
                }
            }
        }
        let bytes = [stream(&[Frame::Start(START)]), sample(1), sample(2)].concat();
        let recorded = record(io::BufReader::new(Pulled(&bytes))).expect("a log");
        assert_eq!(
            (recorded.report.samples, recorded.report.broken_off.as_deref()),
            (2, Some("no such device"))
        );
        assert!(matches!(record(io::BufReader::new(Pulled(&[]))), Err(RecordError::Read(_))));
    }

    #[test]
    fn log_so_far_is_shown_at_intervals() {
        let bytes = [stream(&[Frame::Start(START)]), (0..50).flat_map(sample).collect()].concat();
        let mut rows = Vec::new();
        let recorded = record_watched(&bytes[..], 0.0999, |log| rows.push(column(log, "t_s").len()));
        assert_eq!(rows, [21, 41]);
        assert_eq!(column(&recorded.expect("a log"), "gx_rads"), column(&read(&bytes), "gx_rads"));
    }

    #[test]
    fn columns_are_fixed_by_the_first_sample() {
        let nothing = StartFrame { axes: "", quantities: "", ..START };
        let empty = SampleFrame {
            tick: 1,
            still: true,
            measured: &[][..],
            quantities: &[],
            innovations: &[],
            validity: &[][..],
        };
        let mut bytes = stream(&[Frame::Start(nothing), Frame::Sample(empty), Frame::Start(START)]);
        bytes.extend(sample(2));
        let recorded = read(&bytes);
        assert_eq!((recorded.report.samples, recorded.report.unknown), (1, 1));
        assert!(recorded.columns.iter().all(|(_, values)| values.len() == 1));
        // Without a sample period there are no timestamps.
        let timeless = stream(&[Frame::Start(StartFrame { period_s: f32::NAN, ..START })]);
        let recorded = read(&[timeless, stream(&[Frame::Start(START)]), sample(0)].concat());
        assert_eq!(recorded.report.damaged, 1);
    }

    #[test]
    fn damage_costs_only_the_damaged_frame() {
        let mut whole = stream(&[Frame::Start(START)]);
        let start = whole.len();
        (0..20).map(sample).for_each(|frame| whole.extend(frame));
        for place in start..whole.len() {
            let mut changed = whole.clone();
            changed[place] ^= 0x55;
            let mut shorter = whole.clone();
            shorter.remove(place);
            for bytes in [changed, shorter] {
                let Report { samples, lost, damaged, .. } = read(&bytes).report;
                assert!(samples >= 18 && damaged <= 2, "at {place}: {samples}, {damaged}");
                // Samples lost at the ends leave no gap between ticks.
                assert!(samples + lost >= 18 && samples + lost <= 20, "at {place}: {samples} + {lost}");
            }
        }
    }

    #[test]
    fn late_start_waits_for_a_start_frame() {
        let mut bytes = sample(0)[3..].to_vec();
        bytes.extend(sample(1));
        bytes.extend(stream(&[Frame::Start(START)]));
        bytes.extend(sample(2));
        let report = read(&bytes).report;
        assert_eq!((report.samples, report.unknown, report.damaged), (1, 1, 0));
    }

    #[test]
    fn distinguishes_wrapped_counter_from_restart() {
        let mut bytes = stream(&[Frame::Start(START)]);
        [u32::MAX - 1, u32::MAX, 0, 1].map(sample).iter().for_each(|frame| bytes.extend(frame));
        let wrapped = read(&bytes);
        assert_eq!((wrapped.report.lost, wrapped.report.restarts), (0, 0));
        let mut bytes = stream(&[Frame::Start(START)]);
        [500, 501, 0, 1].map(sample).iter().for_each(|frame| bytes.extend(frame));
        let restarted = read(&bytes);
        assert_eq!(column(&restarted, "segment"), [0.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn detects_restart_at_any_counter_value() {
        let lost_and_restarts = |ticks: [u32; 2]| {
            let bytes = [stream(&[Frame::Start(START)]), ticks.map(sample).concat()].concat();
            let Report { lost, restarts, .. } = read(&bytes).report;
            (lost, restarts)
        };
        let half = 1 << 31;
        for before in [1, half - 1, half, half + 1, 3_000_000_000, 4_200_000_000] {
            for after in [0, 40].into_iter().filter(|after| *after < before) {
                assert_eq!(lost_and_restarts([before, after]), (0, 1), "{before} to {after}");
            }
        }
        // A wrap with and without lost samples.
        assert_eq!(lost_and_restarts([u32::MAX, 0]), (0, 0));
        assert_eq!(lost_and_restarts([u32::MAX - 5, 10]), (15, 0));
        let longest = MAX_INCREASE_IN_WRAP - 1;
        assert_eq!(lost_and_restarts([longest.wrapping_neg(), 0]), (u64::from(longest) - 1, 0));
        assert_eq!(lost_and_restarts([longest.wrapping_neg(), 1]), (0, 1));
        // Without a wrap, the tick increases, so the gap may be long.
        assert_eq!(lost_and_restarts([7, half]), (u64::from(half) - 8, 0));
    }

    #[test]
    fn rejects_other_data_than_telemetry() {
        let noise: Vec<u8> = (0..20_000_u32).map(|n| (n * n % 251) as u8).collect();
        let message = record(&noise[..]).expect_err("nothing in it").to_string();
        assert!(message.contains("baud rate"), "{message}");
        // Detected before the end of the stream.
        let message = record(io::BufReader::new(io::repeat(b'x'))).expect_err("nothing in it").to_string();
        assert!(message.contains("no frame of telemetry in the first 262144 bytes\nhelp: "), "{message}");
        assert!(matches!(record(&[][..]), Err(RecordError::Silent)));
        let other = stream(&[Frame::Start(StartFrame { version: 9, ..START })]);
        assert!(matches!(record(&other[..]), Err(RecordError::Version { found: 9 })));
    }
}
