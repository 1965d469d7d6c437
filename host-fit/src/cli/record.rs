//! `record`: from the telemetry of a device to a log.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;

use super::output::{Failure, print_json};
use crate::record::record;
use crate::recording::write_columns;

/// Bytes that are read at once, and pieces that may wait.
const PIECE: usize = 4096;
const WAITING: usize = 64;

/// Turn the telemetry of a device into a log that diagnose takes
#[derive(Debug, Args)]
#[command(after_help = "Example: host-fit record /dev/ttyACM0 --seconds 600 -o field.parquet")]
pub(super) struct Record {
    /// The stream: a serial port that is set up (stty), a file, or - for standard input
    stream: PathBuf,
    /// The log to write: .csv, .csv.gz or .parquet
    #[arg(short, long)]
    output: PathBuf,
    /// Stop after so long; else at the end of the stream, or at Ctrl-C
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Print what came and what was lost as JSON
    #[arg(long)]
    json: bool,
}

impl Record {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let until = self.seconds.map(end_of).transpose()?;
        let stream: Box<dyn Read + Send> = match self.stream == Path::new("-") {
            true => Box::new(io::stdin()),
            false => Box::new(
                File::open(&self.stream).map_err(|error| format!("{}: {error}", self.stream.display()))?,
            ),
        };
        let recorded = record(BufReader::new(Pieces::of(stream, until)))
            .map_err(|error| format!("{}: {error}", self.stream.display()))?;
        let columns: Vec<(&str, &[f64])> =
            recorded.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
        write_columns(&self.output, &columns)?;
        let report = &recorded.report;
        if self.json {
            return print_json(report);
        }
        println!(
            "{} samples, {} lost (gaps in the log), {} damaged frames, {} before what they hold was known, {} restarts",
            report.samples, report.lost, report.damaged, report.unknown, report.restarts
        );
        if let Some(why) = &report.broken_off {
            println!("{} broke off ({why}): the log holds what came before", self.stream.display());
        }
        println!("log written to {}", self.output.display());
        Ok(())
    }
}

/// When so many seconds will be over.
fn end_of(seconds: f64) -> Result<Instant, String> {
    let duration = Duration::try_from_secs_f64(seconds).ok();
    duration
        .and_then(|duration| Instant::now().checked_add(duration))
        .ok_or_else(|| format!("--seconds {seconds}: no such time\nhelp: leave it out to read until Ctrl-C"))
}

/// What another thread reads of a stream, until its end, Ctrl-C, or the end of the time: also where nothing comes any more.
struct Pieces {
    /// An empty piece is the end.
    coming: Receiver<io::Result<Vec<u8>>>,
    until: Option<Instant>,
    piece: Vec<u8>,
    taken: usize,
}

impl Pieces {
    fn of(mut stream: impl Read + Send + 'static, until: Option<Instant>) -> Self {
        let (sender, coming) = sync_channel(WAITING);
        end_at_interrupt(sender.clone());
        thread::spawn(move || {
            loop {
                let mut piece = vec![0; PIECE];
                let read = stream.read(&mut piece).map(|length| {
                    piece.truncate(length);
                    piece
                });
                let is_last = read.as_ref().map_or(true, Vec::is_empty);
                if sender.send(read).is_err() || is_last {
                    return;
                }
            }
        });
        Self { coming, until, piece: Vec::new(), taken: 0 }
    }
}

/// Ctrl-C ends the stream and not the program: what came is written.
fn end_at_interrupt(sender: SyncSender<io::Result<Vec<u8>>>) {
    thread::spawn(move || {
        // without it the program ends as programs do
        let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_all().build() else { return };
        if runtime.block_on(tokio::signal::ctrl_c()).is_ok() {
            let _ = sender.send(Ok(Vec::new()));
        }
    });
}

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.piece.len() {
            let next = match self.until {
                None => self.coming.recv().ok(),
                Some(until) => self.coming.recv_timeout(until.saturating_duration_since(Instant::now())).ok(),
            };
            (self.piece, self.taken) = (next.transpose()?.unwrap_or_default(), 0);
        }
        let length = buffer.len().min(self.piece.len() - self.taken);
        buffer[..length].copy_from_slice(&self.piece[self.taken..self.taken + length]);
        self.taken += length;
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A port that says something and then nothing any more.
    struct Silent(Option<Vec<u8>>);

    impl Read for Silent {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let Some(said) = self.0.take() else {
                loop {
                    thread::park();
                }
            };
            buffer[..said.len()].copy_from_slice(&said);
            Ok(said.len())
        }
    }

    #[test]
    fn a_device_that_falls_silent_does_not_keep_a_recording() {
        let until = Instant::now() + Duration::from_millis(200);
        let mut said = Vec::new();
        Pieces::of(Silent(Some(b"said".to_vec())), Some(until)).read_to_end(&mut said).expect("an end");
        assert_eq!(said, b"said");
        let mut whole = Vec::new();
        Pieces::of(&[7; 10_000][..], None).read_to_end(&mut whole).expect("an end");
        assert_eq!(whole, [7; 10_000]);
    }

    #[test]
    fn a_time_that_is_none_is_refused() {
        for seconds in [f64::INFINITY, f64::NAN, -1.0, 1e20] {
            assert!(end_of(seconds).is_err(), "{seconds}");
        }
        assert!(end_of(0.0).is_ok());
    }
}
