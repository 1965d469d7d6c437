//! Bytes of a stream until it ends, the time is over, or the user stops.

use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use super::end::when_asked_to_end;
use super::received_file::ReceivedFile;

/// Bytes per read, and reads that may wait for a slow disk: seconds of a serial port.
const PIECE: usize = 4096;
const WAITING: usize = 1024;

/// Time without an open stream, or without data, after which the user is notified.
const PATIENCE_TO_OPEN: Duration = Duration::from_secs(1);
const PATIENCE_TO_HEAR: Duration = Duration::from_secs(5);

/// Notifications during a recording.
#[derive(Debug)]
pub enum Notice {
    /// The stream does not open; a FIFO without a writer does not.
    NotOpen,
    /// The stream is open, and no data have come.
    Silent,
    /// Further data are in memory only.
    WriteFailed(io::Error),
}

/// Bytes of a stream that another thread opens and reads, so that the recording can end even if nothing opens or no data come.
pub struct Arriving<N> {
    coming: Receiver<Coming>,
    until: Option<Instant>,
    /// Time of the next notification; none after the first data.
    impatient: Option<(Instant, Notice)>,
    received_file: Option<ReceivedFile>,
    /// The file can be written and synced.
    keeps: bool,
    notify: N,
    piece: Vec<u8>,
    taken: usize,
    ended: bool,
}

enum Coming {
    Opened,
    Piece(Vec<u8>),
    WriteFailed(io::Error),
    BrokenOff(io::Error),
    End,
}

impl<N: FnMut(&Notice)> Arriving<N> {
    /// Reads the stream returned by `open` until `until`. Data are written to `received_file` before any other use; `notify` receives the
    /// notifications.
    ///
    /// # Errors
    ///
    /// The system cannot deliver requests to end.
    pub fn of<S: Read>(
        open: impl FnOnce() -> io::Result<S> + Send + 'static,
        until: Option<Instant>,
        received_file: Option<ReceivedFile>,
        notify: N,
    ) -> io::Result<Self> {
        let (sender, coming) = sync_channel(WAITING);
        let ending = sender.clone();
        when_asked_to_end(move || drop(ending.send(Coming::End)))?;
        let keep = received_file.as_ref().map(ReceivedFile::writer).transpose()?;
        thread::spawn(move || pass_on(open, keep, &sender));
        Ok(Self {
            coming,
            until,
            impatient: Some((Instant::now() + PATIENCE_TO_OPEN, Notice::NotOpen)),
            keeps: received_file.is_some(),
            received_file,
            notify,
            piece: Vec::new(),
            taken: 0,
            ended: false,
        })
    }

    /// File with the received bytes, if there is one.
    pub fn into_received_file(self) -> Option<ReceivedFile> {
        self.received_file
    }

    /// Waits for the next piece; an empty one is the end.
    fn next(&mut self) -> io::Result<Vec<u8>> {
        loop {
            if self.until.is_some_and(|until| until <= Instant::now()) {
                return Ok(Vec::new());
            }
            self.bring_to_the_disk();
            match self.wait() {
                Ok(Coming::Opened) => {
                    self.impatient = Some((Instant::now() + PATIENCE_TO_HEAR, Notice::Silent));
                }
                Ok(Coming::Piece(piece)) => {
                    self.impatient = None;
                    return Ok(piece);
                }
                Ok(Coming::WriteFailed(error)) => self.keeps_no_more(error),
                Ok(Coming::BrokenOff(error)) => return Err(error),
                Ok(Coming::End) | Err(RecvTimeoutError::Disconnected) => return Ok(Vec::new()),
                Err(RecvTimeoutError::Timeout) => {
                    let over = |(at, _): &mut (Instant, Notice)| *at <= Instant::now();
                    if let Some((_, notice)) = self.impatient.take_if(over) {
                        (self.notify)(&notice);
                    }
                }
            }
        }
    }

    /// Waits for data, or until a sync or notification is due.
    fn wait(&self) -> Result<Coming, RecvTimeoutError> {
        let impatient = self.impatient.as_ref().map(|(at, _)| *at);
        let due = self.received_file.as_ref().filter(|_| self.keeps).map(ReceivedFile::due);
        match [self.until, impatient, due].into_iter().flatten().min() {
            Some(at) => self.coming.recv_timeout(at.saturating_duration_since(Instant::now())),
            None => self.coming.recv().map_err(|_| RecvTimeoutError::Disconnected),
        }
    }

    fn bring_to_the_disk(&mut self) {
        let received_file = self.received_file.as_mut().filter(|_| self.keeps);
        if let Some(Err(error)) = received_file.map(ReceivedFile::sync_if_due) {
            self.keeps_no_more(error);
        }
    }

    fn keeps_no_more(&mut self, error: io::Error) {
        if self.keeps {
            self.keeps = false;
            (self.notify)(&Notice::WriteFailed(error));
        }
    }
}

/// Opens a stream, and forwards its bytes.
fn pass_on<S: Read>(
    open: impl FnOnce() -> io::Result<S>,
    mut keep: Option<impl Write>,
    sender: &SyncSender<Coming>,
) {
    // Sending fails after the recording has ended.
    let tell = |coming| sender.send(coming).is_ok();
    let mut stream = match open() {
        Ok(stream) => stream,
        Err(error) => {
            tell(Coming::BrokenOff(error));
            return;
        }
    };
    if !tell(Coming::Opened) {
        return;
    }
    let mut piece = vec![0; PIECE];
    loop {
        let length = match stream.read(&mut piece) {
            Ok(0) => {
                tell(Coming::End);
                return;
            }
            Ok(length) => length,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => {
                tell(Coming::BrokenOff(error));
                return;
            }
        };
        if let Some(Err(error)) = keep.as_mut().map(|file| file.write_all(&piece[..length])) {
            keep = None;
            tell(Coming::WriteFailed(error));
        }
        if !tell(Coming::Piece(piece[..length].to_vec())) {
            return;
        }
    }
}

impl<N: FnMut(&Notice)> Read for Arriving<N> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.piece.len() && !self.ended {
            (self.piece, self.taken) = (self.next()?, 0);
            // After the end nothing more is awaited.
            self.ended = self.piece.is_empty();
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

    /// A port that sends some bytes and then nothing.
    struct Silent(Option<Vec<u8>>);

    impl Read for Silent {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let Some(received) = self.0.take() else {
                loop {
                    thread::park();
                }
            };
            buffer[..received.len()].copy_from_slice(&received);
            Ok(received.len())
        }
    }

    fn arriving<S: Read + Send + 'static>(
        stream: S,
        until: Option<Instant>,
    ) -> Arriving<impl FnMut(&Notice)> {
        Arriving::of(|| Ok(stream), until, None, |_| {}).unwrap()
    }

    #[test]
    fn silent_device_does_not_block_the_recording() {
        let until = Instant::now() + Duration::from_millis(200);
        let mut received = Vec::new();
        arriving(Silent(Some(b"said".to_vec())), Some(until)).read_to_end(&mut received).unwrap();
        assert_eq!(received, b"said");
        let mut whole = Vec::new();
        arriving(&[7; 10_000][..], None).read_to_end(&mut whole).unwrap();
        assert_eq!(whole, [7; 10_000]);
    }

    #[test]
    fn read_after_the_end_returns_nothing() {
        // Regression test: a second read after the end waited forever.
        let mut stream = arriving(&b"0123"[..], None);
        let mut received = Vec::new();
        stream.read_to_end(&mut received).unwrap();
        assert_eq!((received.as_slice(), stream.read(&mut [0; 8]).unwrap()), (&b"0123"[..], 0));
    }

    #[test]
    fn endless_stream_ends_at_the_time_limit() {
        let until = Instant::now() + Duration::from_millis(100);
        let mut stream = arriving(io::repeat(7), Some(until));
        let read = io::copy(&mut stream, &mut io::sink()).unwrap();
        assert!(read > 0 && Instant::now() < until + Duration::from_secs(20), "{read}");
    }

    #[test]
    fn notifies_of_a_stream_that_does_not_open() {
        let until = Instant::now() + PATIENCE_TO_OPEN + Duration::from_millis(300);
        let mut notices = Vec::new();
        let never = || -> io::Result<io::Empty> {
            loop {
                thread::park();
            }
        };
        let notify = |notice: &Notice| notices.push(format!("{notice:?}"));
        let mut stream = Arriving::of(never, Some(until), None, notify).unwrap();
        assert_eq!(stream.read(&mut [0; 8]).unwrap(), 0);
        drop(stream);
        assert_eq!(notices, ["NotOpen"]);
    }
}
