//! Only what matters: the stretch before and after an alarm.

use fos_core::Scalar;
use heapless::Deque;

use super::{Recorder, Snapshot, StartFrame, TelemetryError};
use crate::hub::Output;

/// So many frames are sent a sample while there is something to send: one more than come in, so that the stretch
/// before drains.
const FRAMES_A_SAMPLE: usize = 2;

/// Keeps the last `BEFORE` samples, with up to `LOGGED` logged quantities each; on an alarm it sends them and those
/// that follow.
///
/// The alarm is a model that stops fitting ([`Output::drift`]), or whatever the application takes for one
/// ([`trigger`](Self::trigger)). A sample takes 80 + 4·`LOGGED` bytes.
#[derive(Debug)]
pub struct AlarmRecorder<W, const BYTES: usize, const LOGGED: usize, const BEFORE: usize> {
    recorder: Recorder<W, BYTES>,
    kept: Deque<Snapshot<LOGGED>, BEFORE>,
    after: u32,
    /// Samples that are still to come into the stretch under way.
    to_come: u32,
    /// Kept samples that belong to it: the oldest ones.
    to_send: usize,
    drifted: bool,
}

impl<W: embedded_io::Write, const BYTES: usize, const LOGGED: usize, const BEFORE: usize>
    AlarmRecorder<W, BYTES, LOGGED, BEFORE>
{
    /// Over this recorder; `after` samples are sent after an alarm.
    pub const fn new(recorder: Recorder<W, BYTES>, after: u32) -> Self {
        const { assert!(BEFORE > 0, "there must be room for a sample") };
        Self { recorder, kept: Deque::new(), after, to_come: 0, to_send: 0, drifted: false }
    }

    /// An alarm at the latest sample: what is kept, and what follows, is sent.
    pub fn trigger(&mut self) {
        // who listens since a short while knows what the samples hold
        if !self.is_sending() {
            self.recorder.begin();
        }
        self.to_send = self.kept.len();
        self.to_come = self.after;
    }

    /// Takes a sample, and sends at most two.
    ///
    /// # Errors
    ///
    /// The first frame that was not sent; it is counted and given up, the others are sent.
    pub fn sample<R: Scalar<Stored = f32>>(
        &mut self,
        start: &StartFrame<&str>,
        output: &Output<R>,
        logged: &[f32],
    ) -> Result<(), TelemetryError<W::Error>> {
        let mut sent = Ok(());
        let mut frames = FRAMES_A_SAMPLE;
        if self.kept.is_full() {
            frames -= usize::from(self.to_send > 0);
            sent = sent.and(self.oldest(start));
        }
        // there is room: the oldest has gone
        let _ = self.kept.push_back(Snapshot::new(output, logged));
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
                sent = sent.and(self.oldest(start));
            }
        }
        sent
    }

    /// A stretch is being sent.
    pub fn is_sending(&self) -> bool {
        self.to_send > 0 || self.to_come > 0
    }

    /// The recorder: for its count of failures, or to send everything.
    pub fn recorder(&mut self) -> &mut Recorder<W, BYTES> {
        &mut self.recorder
    }

    /// Lets go of the oldest; sends it if it belongs to a stretch.
    fn oldest(&mut self, start: &StartFrame<&str>) -> Result<(), TelemetryError<W::Error>> {
        let Some(kept) = self.kept.pop_front() else { return Ok(()) };
        if self.to_send == 0 {
            return Ok(());
        }
        self.to_send -= 1;
        self.recorder.sample(start, kept.frame())
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
            self.kept.len(),
            self.to_send,
            self.to_come,
            self.recorder
        );
    }
}
