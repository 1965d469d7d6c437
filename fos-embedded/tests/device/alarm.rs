//! The alarm recorder sends the samples before and after an alarm, completely and once, and nothing else.

use crate::models::{MADE, Random, SCALES, TestHub, image};
use embedded_io::{ErrorKind, ErrorType, Write};
use fos_core::Quantity;
use fos_embedded::hub::Motion;
use fos_embedded::telemetry::{AlarmRecorder, Frame, HUB_AXES, Recorder, StartFrame, VERSION, decode};

#[derive(Default)]
struct Cable {
    bytes: Vec<u8>,
    broken: bool,
}

impl ErrorType for Cable {
    type Error = ErrorKind;
}

impl Write for Cable {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        if self.broken {
            return Err(ErrorKind::BrokenPipe);
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

const START: StartFrame<&str> =
    StartFrame { version: VERSION, period_s: 0.005, axes: HUB_AXES, quantities: "temp_c\nsupply_v" };

type Alarmed<'c> = AlarmRecorder<&'c mut Cable, 256, 2, 100>;

fn hub() -> TestHub {
    let mut hub = TestHub::new(SCALES);
    hub.load(&image(&MADE)).expect("a model");
    hub.give(Quantity::Supply, 3.3);
    hub.set_motion(Some(Motion::Still));
    hub
}

/// Ticks received.
fn ticks(cable: &Cable) -> Vec<u32> {
    sent(cable).into_iter().flatten().collect()
}

/// Frames received: the tick of a sample, `None` for a start frame.
fn sent(cable: &Cable) -> Vec<Option<u32>> {
    let mut sent = Vec::new();
    for frame in cable.bytes.split_inclusive(|byte| *byte == 0) {
        let mut frame = frame.to_vec();
        match decode::<Frame<&str, Vec<f32>, Vec<u16>>>(&mut frame).expect("a good cable") {
            Frame::Start(start) => {
                assert_eq!(start, START);
                sent.push(None);
            }
            Frame::Sample(sample) => {
                assert_eq!((sample.measured.len(), sample.quantities.len()), (6, 2));
                sent.push(Some(sample.tick));
            }
        }
    }
    sent
}

#[test]
fn sends_samples_around_an_alarm_once_and_in_order() {
    let (mut cable, mut hub, mut random) = (Cable::default(), hub(), Random(1));
    let mut alarmed: Alarmed<'_> = AlarmRecorder::new(Recorder::new(&mut cable), 50);
    let mut alarm_at = None;
    for n in 0..5000_u32 {
        let mut raw = random.at_rest();
        if n >= 3000 {
            raw.gyro[0] += 20;
        }
        let output = *hub.update(&raw);
        alarmed.sample(&START, &output, &hub.logged()).expect("sent");
        if output.drift && alarm_at.is_none() {
            alarm_at = Some(n);
        }
        // two frames per sample: 150 are sent in 75
        assert_eq!(alarmed.is_sending(), alarm_at.is_some_and(|at| n < at + 74), "{n}");
    }
    let at = alarm_at.expect("the model stops fitting");
    assert!((3000..4300).contains(&at), "{at}");
    assert_eq!(ticks(&cable), (at - 99..=at + 50).collect::<Vec<u32>>());
}

#[test]
fn alarm_while_sending_prolongs_it() {
    let (mut cable, mut hub, mut random) = (Cable::default(), hub(), Random(1));
    let mut alarmed: Alarmed<'_> = AlarmRecorder::new(Recorder::new(&mut cable), 50);
    for n in 0..1000_u32 {
        let output = *hub.update(&random.at_rest());
        alarmed.sample(&START, &output, &hub.logged()).expect("sent");
        if n == 400 || n == 430 || n == 800 {
            alarmed.trigger();
        }
    }
    assert_eq!(ticks(&cable), (301..=480).chain(701..=850).collect::<Vec<u32>>());
    // a start frame at the beginning of each of the two transmissions
    let sent = sent(&cable);
    let starts = (0..sent.len()).filter(|&at| sent[at].is_none()).map(|at| sent[at + 1]);
    assert_eq!(starts.collect::<Vec<_>>(), [Some(301), Some(701)]);
}

#[test]
fn broken_cable_loses_only_its_frames() {
    let (mut cable, mut hub, mut random) = (Cable { broken: true, ..Cable::default() }, hub(), Random(1));
    let mut alarmed: Alarmed<'_> = AlarmRecorder::new(Recorder::new(&mut cable), 50);
    let mut failed = 0;
    for n in 0..500_u32 {
        if n == 200 {
            alarmed.trigger();
        }
        let output = *hub.update(&random.at_rest());
        failed += u32::from(alarmed.sample(&START, &output, &hub.logged()).is_err());
    }
    assert!(!alarmed.is_sending());
    assert_eq!((failed, alarmed.recorder().failed()), (75, 300), "150 samples, and with each what it holds");
}
