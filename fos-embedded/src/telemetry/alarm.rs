//! Telemetry around alarms: the samples before and after each.

use fos_core::Scalar;
use heapless::Deque;

use super::{Recorder, Snapshot, StartFrame, TelemetryError};
use crate::hub::Output;

/// Most frames sent per sample: one more than come in, so that the buffered samples drain.
const FRAMES_PER_SAMPLE: usize = 2;

/// Buffers the last `BEFORE` samples, with up to `LOGGED` logged quantities each; on an alarm it sends them and the samples
/// that follow.
///
/// An alarm is a model that no longer fits ([`Output::drift`]), or any condition for which the application calls
/// [`trigger`](Self::trigger). A buffered sample takes 80 + 4·`LOGGED` bytes.
#[derive(Debug)]
pub struct AlarmRecorder<W, const BYTES: usize, const LOGGED: usize, const BEFORE: usize> {
    recorder: Recorder<W, BYTES>,
    buffered: Deque<Snapshot<LOGGED>, BEFORE>,
    after: u32,
    /// Future samples that belong to the current alarm.
    to_come: u32,
    /// Buffered samples to send, the oldest ones.
    to_send: usize,
    drifted: bool,
}

impl<W: embedded_io::Write, const BYTES: usize, const LOGGED: usize, const BEFORE: usize>
    AlarmRecorder<W, BYTES, LOGGED, BEFORE>
{
    /// Creates an alarm recorder that sends through `recorder`; `after` samples are sent after an alarm.
    pub const fn new(recorder: Recorder<W, BYTES>, after: u32) -> Self {
        const { assert!(BEFORE > 0, "there must be room for a sample") };
        Self { recorder, buffered: Deque::new(), after, to_come: 0, to_send: 0, drifted: false }
    }

    /// Raises an alarm at the latest sample: the buffered and the following samples are sent.
    pub fn trigger(&mut self) {
        // while sending, listeners already have the start frame
        if !self.is_sending() {
            self.recorder.begin();
        }
        self.to_send = self.buffered.len();
        self.to_come = self.after;
    }

    /// Buffers a sample and sends at most two.
    ///
    /// # Errors
    ///
    /// Error of the first frame that could not be sent; it is counted and dropped, the others are sent.
    pub fn sample<R: Scalar<Stored = f32>>(
        &mut self,
        start: &StartFrame<&str>,
        output: &Output<R>,
        logged: &[f32],
    ) -> Result<(), TelemetryError<W::Error>> {
        let mut sent = Ok(());
        let mut frames = FRAMES_PER_SAMPLE;
        if self.buffered.is_full() {
            frames -= usize::from(self.to_send > 0);
            sent = sent.and(self.release_oldest(start));
        }
        // never full here: the oldest was released
        let _ = self.buffered.push_back(Snapshot::new(output, logged));
        if self.to_come > 0 {
            self.to_come -= 1;
            self.to_send += 1;
        }
        if output.drift && !self.drifted {
            self.trigger();
        }
        self.drifted = output.drift;
        for _ in 0..frames {
            if self.to_send > 0 {
                sent = sent.and(self.release_oldest(start));
            }
        }
        sent
    }

    /// True while samples of an alarm are being sent.
    pub fn is_sending(&self) -> bool {
        self.to_send > 0 || self.to_come > 0
    }

    /// The recorder, for its count of failures or to send frames directly.
    pub fn recorder(&mut self) -> &mut Recorder<W, BYTES> {
        &mut self.recorder
    }

    /// Removes the oldest sample; sends it if it belongs to an alarm.
    fn release_oldest(&mut self, start: &StartFrame<&str>) -> Result<(), TelemetryError<W::Error>> {
        let Some(snapshot) = self.buffered.pop_front() else { return Ok(()) };
        if self.to_send == 0 {
            return Ok(());
        }
        self.to_send -= 1;
        self.recorder.sample(start, snapshot.frame())
    }
}

#[cfg(feature = "defmt")]
impl<W, const BYTES: usize, const LOGGED: usize, const BEFORE: usize> defmt::Format
    for AlarmRecorder<W, BYTES, LOGGED, BEFORE>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "AlarmRecorder {{ kept: {=usize}, to_send: {=usize}, to_come: {=u32}, recorder: {} }}",
            self.buffered.len(),
            self.to_send,
            self.to_come,
            self.recorder
        );
    }
}
