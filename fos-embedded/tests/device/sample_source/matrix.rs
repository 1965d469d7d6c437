//! Every sensor fault, with a hub: flagged, bounded, recovered. The resulting table is in docs/faults.md.

use std::collections::HashMap;
use std::fmt::Write;

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Info, InnovationStatistics, Input, Model, Quantity, Range,
    Source, Term, Transform, u, y,
};
use fos_embedded::blocking::poll_once;
use fos_embedded::hub::{AXES, Hub, Motion, Output};
use fos_embedded::raw::{Faults, Scales};
use fos_embedded::sample_source::{Batch, Imu, SampleSource, SensorClock, SourceError};
use fos_parts::{BIAS, Fault as PartFault, generated};

use super::simulated::{
    Board, NoAnswer, Shared, Simulated, SimulatedBmi323, SimulatedIcm42688, SimulatedLsm6dso,
    SimulatedLsm6dsv16x, for_every_part,
};

/// Interval between polls, µs: ten samples.
const POLL_US: f64 = 50_000.0;

/// Time before the fault, µs.
const CLEAN_US: f64 = 5e6;

/// Largest error of a corrected value, m/s² for accelerometers, rad/s for gyros: 10 standard deviations of the noise.
const BOUNDS: [f64; 2] = [0.1, 0.025];

/// Largest miscount, ticks: across a reset the application's clock counts, and a poll may be one sample late at either end.
const MISCOUNTED: i64 = 2;

struct Fault {
    name: &'static str,
    begins: fn(&mut Board),
    lasts_us: f64,
    ends: fn(&mut Board),
    polled: bool,
    /// Expected faults of the outputs.
    flagged: Faults,
    /// Faults that depend on the part, or on the moment.
    possible: Faults,
    /// Expected error of a poll, one of these.
    errors: &'static [&'static str],
    /// Largest time from the end of the fault to valid outputs, ticks.
    within: u64,
    /// Seconds of the application's clock after the fault.
    after_s: f64,
}

/// Default of a momentary fault.
const MOMENT: Fault = Fault {
    name: "",
    begins: |_| (),
    lasts_us: 0.0,
    ends: |_| (),
    polled: true,
    flagged: Faults::empty(),
    // the first temperature comes up to 14 samples after a set-up
    possible: Faults::TEMPERATURE,
    errors: &[""],
    within: 20,
    after_s: 5.0,
};

/// Default of a fault that lasts 1 s.
const SECOND: Fault = Fault { lasts_us: 1e6, within: 300, ..MOMENT };

const FAULTS: [Fault; 15] = [
    Fault { name: "one transfer fails", begins: |board| board.fail(1), flagged: Faults::BUS, ..MOMENT },
    Fault {
        name: "bus dead for 1 s",
        begins: |board| board.fail(u32::MAX),
        ends: |board| board.fail(0),
        flagged: Faults::BUS.union(Faults::RESET).union(Faults::GAP),
        errors: &["Bus"],
        ..SECOND
    },
    Fault {
        name: "a burst ends early",
        begins: |board| board.fault(PartFault::Cut, 75.0),
        flagged: Faults::BUS,
        // a BMI323 sends a frame again that was read in part
        possible: Faults::GAP,
        ..MOMENT
    },
    Fault {
        name: "FIFO not read for 1 s",
        polled: false,
        flagged: Faults::OVERRUN.union(Faults::GAP),
        ..SECOND
    },
    Fault {
        name: "data line stuck high for 1 s",
        begins: |board| board.fault(PartFault::StuckHigh, 1.0),
        ends: |board| board.fault(PartFault::StuckHigh, 0.0),
        flagged: Faults::RESET.union(Faults::GAP),
        possible: Faults::BUS.union(Faults::WRONG_PART).union(Faults::TEMPERATURE),
        errors: &["Bus", "WrongPart"],
        ..SECOND
    },
    Fault {
        name: "data line stuck low for 1 s",
        begins: |board| board.fault(PartFault::StuckLow, 1.0),
        ends: |board| board.fault(PartFault::StuckLow, 0.0),
        flagged: Faults::WRONG_PART.union(Faults::RESET).union(Faults::GAP),
        errors: &["WrongPart"],
        ..SECOND
    },
    Fault {
        name: "part does not answer for 60 ms",
        begins: |board| board.fault(PartFault::Unanswered, 60e6),
        flagged: Faults::empty(),
        possible: Faults::all(),
        errors: &["Bus", "WrongPart"],
        within: 60,
        ..MOMENT
    },
    Fault {
        name: "another part answers for 1 s",
        begins: |board| {
            board.fault(PartFault::Reset, 1.0);
            board.fault(PartFault::Identity, 66.0);
        },
        ends: |board| board.fault(PartFault::Identity, 0.0),
        flagged: Faults::WRONG_PART.union(Faults::RESET).union(Faults::GAP),
        errors: &["WrongPart"],
        ..SECOND
    },
    Fault {
        name: "codes stand still for 1 s",
        begins: |board| board.fault(PartFault::Frozen, 1.0),
        ends: |board| board.fault(PartFault::Frozen, 0.0),
        flagged: Faults::STUCK.union(Faults::RESET).union(Faults::GAP),
        ..SECOND
    },
    Fault {
        name: "no temperature for 3 s",
        begins: |board| board.fault(PartFault::NoTemperature, 1.0),
        lasts_us: 3e6,
        ends: |board| board.fault(PartFault::NoTemperature, 0.0),
        flagged: Faults::TEMPERATURE,
        ..MOMENT
    },
    Fault {
        name: "sensor resets",
        begins: |board| board.fault(PartFault::Reset, 1.0),
        flagged: Faults::RESET.union(Faults::GAP),
        within: 45,
        ..MOMENT
    },
    Fault {
        name: "registers keep nothing for 1 s",
        begins: |board| {
            board.fault(PartFault::Reset, 1.0);
            board.fault(PartFault::Forgetful, 1.0);
        },
        ends: |board| board.fault(PartFault::Forgetful, 0.0),
        flagged: Faults::RESET.union(Faults::GAP),
        errors: &["VerifyFailed"],
        ..SECOND
    },
    Fault {
        name: "FIFO stays empty for 1 s",
        begins: |board| board.fault(PartFault::Silent, 1.0),
        ends: |board| board.fault(PartFault::Silent, 0.0),
        flagged: Faults::RESET.union(Faults::GAP),
        ..SECOND
    },
    Fault {
        name: "FIFO runs over",
        begins: |board| board.fault(PartFault::Overrun, 1.0),
        flagged: Faults::GAP,
        possible: Faults::OVERRUN,
        ..MOMENT
    },
    Fault {
        name: "clock 3 % fast for 25 s",
        begins: |board| board.fault(PartFault::Ppm, 30_000.0),
        lasts_us: 25e6,
        ends: |board| board.fault(PartFault::Ppm, 0.0),
        flagged: Faults::RATE,
        // two windows of 10 s of the hub's rate measurement
        within: 4100,
        after_s: 25.0,
        ..MOMENT
    },
];

/// An output with its tick of the sensor.
struct At {
    tick: u64,
    output: Output,
}

struct Run {
    outputs: Vec<At>,
    errors: Vec<String>,
    /// Ticks of the sensor: first sample not yet returned at the start of the fault, first sample after its end.
    fault: [u64; 2],
}

fn wait_until(board: &Shared, us: f64) {
    let wait_us = (us - board.borrow().now_us()).max(0.0);
    board.borrow_mut().pass(wait_us);
}

/// Runs `source` through a fault, which begins halfway between two polls.
fn run<P: Imu<BusError = NoAnswer>>(
    board: &Shared,
    mut source: SampleSource<P>,
    fault: &Fault,
) -> Result<Run, String> {
    let mut hub: Hub<2, 32, 128> = Hub::new(P::scales());
    hub.load(&image(&P::scales())).map_err(|error| error.to_string())?;
    hub.set_motion(Some(Motion::Still));
    let known: HashMap<_, u64> = (0..13_000).map(|tick| (generated(tick), tick)).collect();
    let mut run = Run { outputs: Vec::new(), errors: Vec::new(), fault: [u64::MAX; 2] };
    let [begins_us, ends_us] = [CLEAN_US, CLEAN_US + fault.lasts_us];
    let end_us = ends_us + fault.after_s * 1e6;
    for poll in 1.. {
        let due_us = f64::from(poll) * POLL_US;
        if due_us > end_us {
            return Ok(run);
        }
        if due_us >= begins_us && run.fault[0] == u64::MAX {
            run.fault[0] = run.outputs.last().map_or(0, |at| at.tick + 1);
            wait_until(board, due_us - POLL_US / 2.0);
            (fault.begins)(&mut board.borrow_mut());
        }
        wait_until(board, due_us);
        if due_us >= ends_us && run.fault[1] == u64::MAX {
            run.fault[1] = board.borrow().tick() + 1;
            (fault.ends)(&mut board.borrow_mut());
        }
        if !fault.polled && (begins_us..ends_us).contains(&due_us) {
            continue;
        }
        for _ in 0..10 {
            let now_us = board.borrow().now_us() as u64;
            let mut given = 0;
            match poll_once(source.poll(now_us)).ok_or("not done at once")? {
                Ok(samples) => {
                    given = samples.len();
                    for raw in samples {
                        let before = run.outputs.last().map(|at| at.tick);
                        let next = before.map_or(0, |tick| tick + 1 + u64::from(raw.skipped));
                        // stuck codes belong to no tick
                        let tick = known.get(&(raw.accel, raw.gyro)).copied();
                        let tick = tick.filter(|tick| before.is_none_or(|before| *tick > before));
                        if tick.is_none()
                            && !raw.faults.contains(Faults::STUCK)
                            && !(fault.flagged.contains(Faults::STUCK)
                                && (begins_us..ends_us).contains(&due_us))
                        {
                            return Err(format!("codes that the sensor never gave: {raw:?}"));
                        }
                        let output = *hub.update(raw);
                        run.outputs.push(At { tick: tick.unwrap_or(next), output });
                    }
                }
                Err(error) => run.errors.push(name(&error).into()),
            }
            if !source.has_more() {
                if given > 0 {
                    hub.clock(now_us);
                }
                break;
            }
        }
    }
    Err("endless".into())
}

fn name(error: &SourceError<NoAnswer>) -> &'static str {
    match error {
        SourceError::Bus(_) => "Bus",
        SourceError::WrongPart(_) => "WrongPart",
        SourceError::VerifyFailed { .. } => "VerifyFailed",
        SourceError::Resting(_) => "Resting",
        _ => "another",
    }
}

/// Effect of a fault.
#[derive(Debug, PartialEq)]
struct Row {
    flagged: String,
    errors: usize,
    /// Number of ticks with a flag.
    ticks: usize,
    /// Ticks from the end of the fault to valid outputs.
    recovered: u64,
    /// Ticks counted in excess; negative if too few.
    miscounted: i64,
    /// Largest error of accelerometers and gyros.
    furthest: [f64; 2],
}

/// Returns the table row of a fault, or an error if a requirement is violated.
fn assess<P: Imu<BusError = NoAnswer>>(
    (board, source): (Shared, SampleSource<P>),
    fault: &Fault,
    undisturbed: &HashMap<u64, [f32; AXES]>,
) -> Result<Row, String> {
    let run = run(&board, source, fault)?;
    let [begun, ended] = run.fault;
    let mut row = Row {
        flagged: String::new(),
        errors: run.errors.len(),
        ticks: 0,
        recovered: 0,
        miscounted: 0,
        furthest: [0.0; 2],
    };
    let mut flagged = Faults::empty();
    for At { tick, output } in &run.outputs {
        for (axis, corrected) in output.corrected().iter().enumerate() {
            let truth = if axis == 2 { 9.80665 } else { 0.0 };
            let off = (f64::from(*corrected) - truth).abs();
            let furthest = &mut row.furthest[axis / 3];
            // NaN is never within bounds
            if off.is_nan() || off > BOUNDS[axis / 3] {
                return Err(format!("axis {axis} is {off} from the truth at tick {tick}"));
            }
            *furthest = furthest.max(off);
        }
        if *tick < begun {
            if *tick > 100 && !output.is_valid() {
                return Err(format!("flagged before the fault: {output:?}"));
            }
            continue;
        }
        flagged |= output.faults;
        if !output.is_valid() {
            row.ticks += 1;
            row.recovered = (tick + 1).saturating_sub(ended);
        }
    }
    if !flagged.contains(fault.flagged) || !(fault.flagged | fault.possible).contains(flagged) {
        return Err(format!("flagged as {flagged:?}"));
    }
    let error = run.errors.iter().find(|error| *error != "Resting").map_or("", String::as_str);
    if !fault.errors.contains(&error) {
        return Err(format!("returned {error:?}"));
    }
    if row.recovered > fault.within {
        return Err(format!("recovered only after {} ticks", row.recovered));
    }
    let [first, .., last] = &run.outputs[..] else { return Err("no samples".into()) };
    if last.tick + 20 < board.borrow().tick() {
        return Err("no samples after the fault".into());
    }
    let counted = last.output.tick.wrapping_sub(first.output.tick);
    row.miscounted = i64::from(counted) - (last.tick - first.tick) as i64;
    for At { tick, output } in run.outputs.iter().rev().take(100) {
        let clean = undisturbed.get(tick).ok_or("no such tick")?;
        for (value, clean) in output.corrected().iter().zip(clean) {
            if (value - clean).abs() > 1e-5 {
                return Err(format!("{value} instead of {clean} after recovery"));
            }
        }
    }
    let names: Vec<&str> = flagged.iter_names().map(|(name, _)| name).collect();
    row.flagged = names.join(", ");
    if !error.is_empty() {
        let _ = write!(row.flagged, "; `{error}`");
    }
    Ok(row)
}

/// Corrected values without a fault, by tick of the sensor.
fn undisturbed<P: Simulated>() -> HashMap<u64, [f32; AXES]> {
    let (board, source) = P::source();
    let nothing = Fault { after_s: 55.0, ..MOMENT };
    let run = run(&board, source, &nothing).expect("a run without faults");
    assert!(run.errors.is_empty());
    let flagged = run.outputs.iter().skip(100).find(|at| !at.output.is_valid());
    assert!(flagged.is_none(), "{:?}", flagged.map(|at| at.output));
    run.outputs.into_iter().map(|at| (at.tick, at.output.corrected())).collect()
}

fn input(centre_c: f32) -> Input<f32> {
    let range = Range::new(-3.0, 3.0);
    let source = Source::Quantity(0);
    Input { source, transform: Transform::Identity, centre: centre_c, scale: 5.0, source_range: range, range }
}

/// A model of the noise of [`generated`] codes, linear in temperature.
fn image(scales: &Scales) -> Vec<u8> {
    const PHYSICAL: [Term<f32>; 1] = [Term::new(0.5, &[u(0, 0)])];
    const STOCHASTIC: [Term<f32>; 2] = [Term::new(0.1, &[y(1)]), Term::new(0.05, &[y(2)])];
    let axes = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];
    let axes = axes.into_iter().enumerate().map(|(index, axis)| {
        let code = if index < 3 { scales.accel_mps2 } else { scales.gyro_rads };
        let reference = if index == 2 { 9.80665 } else { 0.0 };
        let parameters = AxisParameters {
            axis,
            reference,
            offset: BIAS[index] as f32 * code - reference,
            scale: 8.0 * code,
            constant: 0.0,
            range: Range::new(-5.0, 5.0),
            physical_range: Range::unlimited(),
            full_scale: 0.0,
            stuck_after_repeats: 200,
            gap_limit_samples: 20,
            coast_limit_s: 60.0,
            // white noise filtered by 1 - 0.1/z - 0.05/z²
            innovation: InnovationStatistics { mean: 0.0, variance: 1.0125, lag_1_correlation: -0.0938 },
        };
        AxisModel { parameters, physical: &PHYSICAL, stochastic: &STOCHASTIC }
    });
    let celsius = if scales.temperature_zero_c < 24.0 { 25.0 } else { 26.0 };
    let model = Model {
        period_s: scales.period_s,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[Quantity::Temperature],
        inputs: &[input(celsius)],
        axes: &axes.collect::<Vec<_>>(),
    };
    let mut buffer = [0; 4096];
    encode(&model, &Info::default(), &mut buffer).expect("an image").to_vec()
}

const BEGIN: &str = "<!-- table: cargo test -p fos-embedded --test device sample_source:: -->\n";
const END: &str = "<!-- end of table -->\n";

/// Name of a part, and its row for every fault.
fn rows<P: Simulated>() -> (&'static str, Vec<Result<Row, String>>) {
    let clean = undisturbed::<P>();
    (P::NAME, FAULTS.iter().map(|fault| assess(P::source(), fault, &clean)).collect())
}

#[test]
fn every_fault_is_flagged_bounded_and_recovered_from() {
    let mut table = String::from(
        "| fault | part | flagged as; error | polls with an error | ticks with a flag | valid again after (ticks) | \
         ticks miscounted | furthest from the truth (m/s², rad/s) |\n|---|---|---|---|---|---|---|---|\n",
    );
    let mut wrong = String::new();
    let rows = [
        rows::<SimulatedLsm6dsv16x>(),
        rows::<SimulatedLsm6dso>(),
        rows::<SimulatedBmi323>(),
        rows::<SimulatedIcm42688>(),
    ];
    for (index, fault) in FAULTS.iter().enumerate() {
        for (part, rows) in &rows {
            match &rows[index] {
                Ok(Row { flagged, errors, ticks, recovered, miscounted, furthest: [accel, gyro] }) => {
                    let (name, furthest) = (fault.name, format!("{accel:.3}, {gyro:.4}"));
                    let _ = writeln!(
                        table,
                        "| {name} | {part} | {flagged} | {errors} | {ticks} | {recovered} | {miscounted} | {furthest} |"
                    );
                    if miscounted.abs() > MISCOUNTED {
                        let _ = writeln!(wrong, "{name}, {part}: {miscounted} ticks miscounted");
                    }
                }
                Err(error) => {
                    let _ = writeln!(wrong, "{}, {part}: {error}", fault.name);
                }
            }
        }
    }
    println!("{table}");
    assert!(wrong.is_empty(), "{wrong}");

    crate::page::holds(BEGIN, END, &table);
}

/// Deliberate defects of a driver.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Defect {
    None,
    /// Failed transfers are not repeated.
    NoRetry,
    /// Axes x and y are exchanged.
    Exchanged,
    /// The high byte comes first.
    Swapped,
    /// The sensor's clock is not read.
    NoClock,
    /// Resets of the sensor are not detected.
    Blind,
    /// Overruns are not reported.
    NoOverrun,
    /// Invalid temperatures are passed on.
    AnyTemperature,
}

struct Defective<P> {
    part: P,
    defect: Defect,
    stamp: u32,
    failing: u8,
}

impl<P: Simulated> Defective<P> {
    fn source(defect: Defect) -> (Shared, SampleSource<Self>) {
        let board = Board::new::<P>();
        let part = Self { part: P::new(&board), defect, stamp: 0, failing: 0 };
        (board, SampleSource::new(part))
    }
}

impl<P: Simulated> Imu for Defective<P> {
    type BusError = NoAnswer;
    const NAME: &'static str = P::NAME;
    const CLOCK: SensorClock = P::CLOCK;

    fn scales() -> Scales {
        P::scales()
    }

    async fn set_up(&mut self) -> Result<(), SourceError<NoAnswer>> {
        self.part.set_up().await
    }

    async fn is_set_up(&mut self) -> Result<bool, SourceError<NoAnswer>> {
        if self.failing > 0 {
            self.failing -= 1;
            return Err(SourceError::Bus(NoAnswer));
        }
        let set_up = self.part.is_set_up().await;
        if set_up.is_err() && self.defect == Defect::NoRetry {
            self.failing = 2;
        }
        if self.defect == Defect::Blind { set_up.map(|_| true) } else { set_up }
    }

    async fn read(&mut self, batch: &mut Batch) -> Result<(), SourceError<NoAnswer>> {
        self.part.read(batch).await?;
        batch.overrun &= self.defect != Defect::NoOverrun;
        for frame in &mut batch.frames {
            match self.defect {
                Defect::Exchanged => frame.accel.swap(0, 1),
                Defect::Swapped => frame.gyro = frame.gyro.map(i16::swap_bytes),
                Defect::NoClock => {
                    let counts = u64::from(P::CLOCK.period_ns) * 1000 / u64::from(P::CLOCK.count_ps);
                    self.stamp = (self.stamp + counts as u32) & (u32::MAX >> (32 - P::CLOCK.bits));
                    frame.stamp = self.stamp;
                }
                Defect::AnyTemperature => frame.temperature = frame.temperature.or(Some(i16::MIN)),
                _ => {}
            }
        }
        Ok(())
    }

    async fn wait_ms(&mut self, ms: u32) {
        self.part.wait_ms(ms).await;
    }
}

/// Names of the faults that reveal a defect of a driver.
fn found<P: Simulated>(defect: Defect, clean: &HashMap<u64, [f32; AXES]>) -> Vec<&'static str> {
    let is_fine = |fault: &&Fault| {
        let row = assess(Defective::<P>::source(defect), fault, clean);
        row.is_ok_and(|row| row.miscounted.abs() <= MISCOUNTED)
    };
    let short = FAULTS.iter().filter(|fault| fault.lasts_us < 25e6);
    short.filter(|fault| !is_fine(fault)).map(|fault| fault.name).collect()
}

fn assert_defects_are_detected<P: Simulated>() {
    let clean = undisturbed::<P>();
    assert_eq!(found::<P>(Defect::None, &clean), [""; 0]);
    for (defect, shows) in [
        (Defect::NoRetry, "one transfer fails"),
        (Defect::Exchanged, "sensor resets"),
        (Defect::Swapped, "sensor resets"),
        (Defect::NoClock, "FIFO not read for 1 s"),
        (Defect::Blind, "sensor resets"),
        (Defect::NoOverrun, "FIFO not read for 1 s"),
        (Defect::AnyTemperature, "no temperature for 3 s"),
    ] {
        let found = found::<P>(defect, &clean);
        assert!(found.contains(&shows), "{defect:?} is found by {found:?} only");
    }
}

#[test]
fn detects_defects_of_all_drivers() {
    for_every_part!(assert_defects_are_detected());
}
