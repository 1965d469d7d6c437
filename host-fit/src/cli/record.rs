//! `record`: converts the telemetry of a device into a log.

use std::fmt::Display;
use std::fs::{self, File, Metadata};
use std::io::{self, BufReader, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use super::arguments::OutputFile;
use super::guide::Guide;
use super::output::{Failure, print_json, print_line, print_note, print_warning};
use fos_data::file::{self, FileError};
use fos_data::recording::{check_log_path, write_columns};
use fos_device_io::record::arriving::{Arriving, Notice};
use fos_device_io::record::received_file::ReceivedFile;
use fos_device_io::record::{Report, record_watched};

/// Time of the log between two lines of guidance, s.
const GUIDED_EVERY_S: f64 = 5.0;

/// Record the telemetry of a device as a log
///
/// While it runs, the received bytes are in LOG.telemetry, synced every second; when the log is written,
/// that is removed. After a power loss or a killed recording, `fos record LOG.telemetry -o LOG`
/// makes the log of it.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: fos record /dev/ttyACM0 --seconds 600 -o log.parquet\nExample: fos record /dev/ttyACM0 --guide calibration -o turned.parquet"
)]
pub(super) struct Record {
    /// The stream: a serial port that is set up (stty), a FIFO, a file, or - for standard input
    stream: PathBuf,
    /// The log to write: .csv, .csv.gz or .parquet
    #[arg(short, long)]
    output: OutputFile,
    /// Stop after this time; otherwise at the end of the stream, or at Ctrl-C
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Say every 5 s on standard error what the log still lacks
    #[arg(long, value_name = "PURPOSE")]
    guide: Option<Guide>,
    /// Print the number of received and lost samples as JSON
    #[arg(long)]
    json: bool,
}

impl Record {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let until = self.seconds.map(end_of).transpose()?;
        check_log_path(&self.output)?;
        let stream = Stream::at(&self.stream)?;
        // The bytes of a file are stored already.
        let received_file = (stream.kind != Kind::File).then(|| self.keep()).transpose()?;
        let of = |error: &dyn Display| format!("{}: {error}", stream.name());
        let notify = |notice: &Notice| print_warning(&of(&stream.says(notice)));
        let opened = stream.clone();
        let arriving = Arriving::of(move || opened.open(), until, received_file, notify);
        let mut arriving = arriving.map_err(|error| of(&error))?;
        let every_s = self.guide.map_or(f64::INFINITY, |_| GUIDED_EVERY_S);
        let mut said = String::new();
        let recorded = record_watched(BufReader::new(&mut arriving), every_s, |log| {
            let line = self.guide.map(|guide| guide.line(log)).unwrap_or_default();
            if line != said {
                print_note!("{line}");
                said = line;
            }
        });
        let received_file = arriving.into_received_file();
        let done =
            recorded.map_err(|error| (error.holds_something(), of(&error).into())).and_then(|recorded| {
                let columns = recorded.columns.iter();
                let columns: Vec<(&str, &[f64])> =
                    columns.map(|(name, values)| (name.as_str(), values.as_slice())).collect();
                let written = write_columns(&self.output, &columns);
                written.map(|()| recorded.report).map_err(|error| (true, Failure::from(error)))
            });
        match (done, received_file) {
            (Err((true, failure)), Some(received_file)) => Err(format!(
                "{failure}\nwhat arrived is in {0}: `fos record {0} -o {1}` makes a log of it",
                received_file.path().display(),
                self.output.display()
            )
            .into()),
            (done, received_file) => {
                received_file.into_iter().for_each(ReceivedFile::remove);
                self.print(&stream, &done.map_err(|(_, failure)| failure)?)
            }
        }
    }

    /// Opens the file for the received bytes, and reports one from an earlier recording.
    fn keep(&self) -> Result<ReceivedFile, Failure> {
        let (received_file, left) = ReceivedFile::beside(&self.output)?;
        for left in left {
            print_warning(&format!(
                "{0} is from an interrupted recording and is not touched: `fos record {0} -o LOG` converts it to a log",
                left.display()
            ));
        }
        Ok(received_file)
    }

    fn print(&self, stream: &Stream, report: &Report) -> Result<(), Failure> {
        if self.json {
            return print_json(report);
        }
        print_line!(
            "{} samples, {} lost (gaps in the log), {} damaged frames, {} before what they hold was known, {} restarts",
            report.samples,
            report.lost,
            report.damaged,
            report.unknown,
            report.restarts
        );
        if let Some(why) = &report.broken_off {
            print_line!("{} broke off ({why}): the log holds what came before", stream.name());
        }
        print_line!("log written to {}", self.output.display());
        Ok(())
    }
}

/// Source of the telemetry.
#[derive(Debug, Clone)]
struct Stream {
    /// None for standard input.
    path: Option<PathBuf>,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Persists after this program ends.
    File,
    /// Opens when another process writes to it.
    Fifo,
    Other,
}

impl Stream {
    fn at(path: &Path) -> Result<Self, FileError> {
        let path = Some(path).filter(|path| *path != Path::new("-")).map(Path::to_owned);
        let about = match &path {
            Some(path) => fs::metadata(path),
            None => file::standard_input().and_then(|input| input.metadata()),
        };
        let mut stream = Self { path, kind: Kind::Other };
        let failed = || FileError::opening(Path::new(stream.name()));
        let about = about.map_err(failed())?;
        if about.is_dir() {
            return Err(failed()(ErrorKind::IsADirectory.into()));
        }
        stream.kind = match about.is_file() {
            true => Kind::File,
            false if is_fifo(&about) => Kind::Fifo,
            false => Kind::Other,
        };
        Ok(stream)
    }

    fn open(&self) -> io::Result<File> {
        match &self.path {
            Some(path) => file::open(path).map_err(|error| error.source),
            None => file::standard_input(),
        }
    }

    fn name(&self) -> &str {
        self.path.as_ref().map_or("standard input", |path| path.to_str().unwrap_or("the stream"))
    }

    fn says(&self, notice: &Notice) -> String {
        match notice {
            Notice::NotOpen if self.kind == Kind::Fifo => {
                "a FIFO without a writer; waiting for one, Ctrl-C ends".to_owned()
            }
            Notice::NotOpen => "waiting for it to open, Ctrl-C ends".to_owned(),
            Notice::Silent => "nothing has come yet; still waiting, Ctrl-C ends".to_owned(),
            Notice::WriteFailed(error) => format!(
                "what arrives cannot be kept on the disk any more ({error}); from now on it is in memory only, until the log is written"
            ),
        }
    }
}

#[cfg(unix)]
fn is_fifo(about: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    about.file_type().is_fifo()
}

#[cfg(not(unix))]
fn is_fifo(_: &Metadata) -> bool {
    false
}

/// Time at which `seconds` have passed.
fn end_of(seconds: f64) -> Result<Instant, String> {
    let duration = Duration::try_from_secs_f64(seconds).ok();
    duration
        .and_then(|duration| Instant::now().checked_add(duration))
        .ok_or_else(|| format!("--seconds {seconds}: no such time\nhelp: leave it out to read until Ctrl-C"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_invalid_duration() {
        for seconds in [f64::INFINITY, f64::NAN, -1.0, 1e20] {
            assert!(end_of(seconds).is_err(), "{seconds}");
        }
        assert!(end_of(0.0).is_ok());
    }
}
