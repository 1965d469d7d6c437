//! A day of sensor time through hub and store, with random faults and model updates: no drift, no leak, and a device
//! restarted from its flash gives the same output as one that ran without interruption.

mod models;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

use fos_core::image::encode;
use fos_core::{AxisModel, FittedOn, Info, Input, Model, Quantity, Range, Source, Term, Transform, u, y};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::hub::{Motion, Output};
use fos_embedded::raw::{Faults, RawSample};
use fos_embedded::store::ModelStore;
use fos_testkit::flash::{Flash, PAGE, PAGES};
use models::{PHYSICAL, Random, SCALES, SIX, SPREAD, STOCHASTIC, TestHub, limits, parameters};

/// Counts the allocations and the held bytes per thread, so that parallel tests do not matter.
struct Counting;

thread_local! {
    static ALLOCATED: Cell<u64> = const { Cell::new(0) };
    static HELD_BYTES: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: forwards to the system allocator; the counters do not affect it
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED.set(ALLOCATED.get() + 1);
        HELD_BYTES.set(HELD_BYTES.get().wrapping_add(layout.size()));
        // SAFETY: guaranteed by the caller
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // a thread may free more than it allocated, if it received memory of another
        HELD_BYTES.set(HELD_BYTES.get().wrapping_sub(layout.size()));
        // SAFETY: guaranteed by the caller
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const TICKS_PER_SECOND: u64 = 200;

/// Longest lag of the model, samples.
const DEPTH: u64 = 2;

/// Time constant of its low-passes, s.
const TAU_S: f32 = 0.5;

/// Samples after which a restarted hub without low-passes gives the same output bit for bit: the longest lag plus the
/// delay of the remainder.
const BITWISE_AFTER: u64 = DEPTH + 1;

/// Tolerance with low-passes, relative to the noise and absolute: the last bits of the low-passes may differ for ever (the
/// rounding of the carried part depends on its history), and so may those of an accelerometer's 9.81 m/s².
const TOLERANCE: [f32; 2] = [1e-5, 2e-6];

/// Samples after which a restarted hub with low-passes is within the tolerance: ln(4.4/10⁻⁶) time constants, because the
/// inputs' share in the prediction is at most 0.5·4.4 and 0.2·11.
const SETTLED_AFTER: u64 = BITWISE_AFTER + (15.3 * TAU_S * TICKS_PER_SECOND as f32) as u64;

/// True if an update has low-passes: every other one.
fn has_low_passes(number: u32) -> bool {
    !number.is_multiple_of(2)
}

/// Store with room for the image and its overhead.
type Store = ModelStore<Blocking<Flash>, 2048>;

fn store(flash: Flash) -> Store {
    ModelStore::new(Blocking(flash), 0..(PAGES * PAGE) as u32).unwrap_or_else(|_| panic!("a range"))
}

/// Six axes over temperature and a long memory of the remainder; every update has different coefficients.
fn image(number: u32) -> Vec<u8> {
    let change = (number % 1000) as f32 * 1e-4;
    let [first, second, product] = STOCHASTIC;
    let stochastic =
        [Term::new(first.coefficient - change, &[y(1)]), second, product, Term::new(0.2, &[u(2, 0)])];
    let quantity = |index, centre, scale, transform| Input {
        source: Source::Quantity(index),
        transform,
        centre,
        scale,
        source_range: Range::new(-2.0, 2.0),
        range: Range::new(-2.0, 2.0),
    };
    let transform =
        if has_low_passes(number) { Transform::LowPass { tau_s: TAU_S } } else { Transform::Identity };
    let inputs = [
        quantity(0, 25.0, 10.0, transform),
        quantity(1, 3.3, 0.1, Transform::Identity),
        Input {
            source: Source::Remainder(3),
            range: Range::new(-5.0, 5.0),
            source_range: Range::new(-5.0, 5.0),
            ..quantity(0, 0.0, 1.0, transform)
        },
    ];
    let axes = SIX.map(|axis| AxisModel {
        parameters: parameters(axis),
        physical: &PHYSICAL,
        stochastic: &stochastic,
    });
    let model = Model {
        period_s: SCALES.period_s,
        fitted_on: FittedOn::Raw,
        stillness: Some(limits()),
        calibration: None,
        quantities: &[Quantity::Temperature, Quantity::Supply],
        inputs: &inputs,
        axes: &axes,
    };
    let provenance = format!("update {number}");
    let info = Info { quantities: "temp_c °C\nsupply_v V", provenance: &provenance, ..Info::default() };
    encode(&model, &info, &mut [0; 2048]).expect("it fits").to_vec()
}

/// Deliberate defect of the device.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Defect {
    None,
    /// A missing sample is not counted after a fault.
    Miscounts,
    /// The store reports success without storing an update.
    Forgets,
    /// A restart loads the image before the newest.
    Stale,
    /// Every sample leaks a little memory.
    Leaks,
}

#[derive(Default)]
struct Findings {
    /// Ticks sent; `counted` are those counted by the hub.
    ticks: u64,
    counted: u32,
    samples: u64,
    faults: u64,
    updates: u32,
    cuts: u32,
    operations: usize,
    erased: [u32; PAGES],
    restarts: u32,
    /// Compared restarts and samples: restarts at a tick at which the first hub restarts too; others without low-passes; others
    /// with low-passes.
    compared: [(u32, u64); 3],
    /// Measured samples until the outputs of a restarted hub permanently equalled those of the other: without low-passes,
    /// with low-passes.
    settled: [u64; 2],
    /// Allocations of the device's code.
    allocated: u64,
    /// Held bytes of the whole run, after a tenth of it and at the end.
    held_bytes: [usize; 2],
    seconds: f64,
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hours = self.ticks as f64 / (3600 * TICKS_PER_SECOND) as f64;
        let most = self.erased.iter().max().unwrap_or(&0);
        let [early, late] = self.held_bytes;
        write!(
            f,
            "{hours:.2} h of sensor time; {} of {} ticks counted, {} samples, {} of them with faults; {} model updates ({} \
             interrupted), {} flash operations, at most {most} erases per page; {} restarts, of which compared: {} at a model \
             update, identical bit for bit over {} samples; {} at other times without low-passes, identical bit for bit \
             after at most {} samples (stated: {BITWISE_AFTER}), over {}; {} with low-passes, within the tolerance after at \
             most {} (stated: {SETTLED_AFTER}), over {}; {} bytes of state, {} allocations; heap: {early} bytes after a \
             tenth of the run, {late} at the end; run time {:.0} s",
            self.counted,
            self.ticks,
            self.samples,
            self.faults,
            self.updates,
            self.cuts,
            self.operations,
            self.restarts,
            self.compared[0].0,
            self.compared[0].1,
            self.compared[1].0,
            self.settled[0],
            self.compared[1].1,
            self.compared[2].0,
            self.settled[1],
            self.compared[2].1,
            size_of::<TestHub>() + size_of::<Store>(),
            self.allocated,
            self.seconds
        )
    }
}

/// Random events of the sensor.
struct World {
    random: Random,
    samples: u64,
    held: Option<RawSample>,
    stuck: u32,
    cold: u32,
    supply: f32,
    clock_off_us: u64,
}

impl World {
    /// True once in `n`.
    fn once_in(&mut self, n: u32) -> bool {
        self.random.next() > 1.0 - 2.0 / n as f32
    }

    fn up_to(&mut self, n: u32) -> u32 {
        (0.5 * (1.0 + self.random.next()) * n as f32) as u32
    }

    fn sample(&mut self) -> RawSample {
        self.samples += 1;
        let mut raw = self.random.at_rest();
        // ±4 K, with a period of 100 s
        let turn = (self.samples / 10 % 2000) as i16;
        raw.temperature = Some(if turn < 1000 { turn } else { 2000 - turn } * 2 - 1000);
        if self.once_in(800) {
            // one in 20 exceeds every limit
            raw.skipped = if self.once_in(20) { 1 + self.up_to(2000) } else { 1 + self.up_to(30) };
            raw.faults |= Faults::GAP;
        }
        if self.once_in(1500) {
            raw.gyro[self.samples as usize % 3] = i16::MIN;
            raw.accel[self.samples as usize % 3] = i16::MAX;
        }
        if self.once_in(2000) {
            raw.skipped = 1 + self.up_to(5);
            raw.faults |= Faults::BUS | Faults::GAP;
        }
        if self.once_in(5000) {
            raw.skipped = 10;
            raw.faults |= Faults::RESET | Faults::OVERRUN | Faults::GAP;
        }
        if self.stuck == 0 && self.once_in(4000) {
            (self.stuck, self.held) = (5 + self.up_to(60), Some(raw));
        }
        if let (Some(held), true) = (self.held, self.stuck > 0) {
            self.stuck -= 1;
            (raw.accel, raw.gyro) = (held.accel, held.gyro);
            raw.faults |= Faults::STUCK;
        }
        if self.cold == 0 && self.once_in(4000) {
            self.cold = 1 + self.up_to(600);
        }
        if self.cold > 0 {
            self.cold -= 1;
            raw.temperature = None;
            raw.faults |= Faults::TEMPERATURE;
        }
        if self.once_in(3000) {
            self.supply = [3.3, 3.35, f32::NAN, 9.0][self.samples as usize % 4];
        }
        raw
    }
}

/// The second hub, and the stage of its convergence to the first.
struct Twin {
    hub: TestHub,
    stage: Stage,
    /// Ticks of the first hub before the second started.
    ticks: u32,
}

enum Stage {
    /// Waiting for missing samples, where both begin a stillness window.
    Gap,
    /// Waiting until the histories of both hold only measurements.
    Measured,
    /// Number of samples since then.
    Settling(u64),
    /// Started at the same tick as the first: compared at once.
    Twins,
}

/// Compares two outputs, bit for bit or within the tolerance. Alarms are compared only if both started at once, because the
/// axes are monitored in turn.
fn differ(one: &Output, other: &Output, alarms: bool, bit_for_bit: bool) -> bool {
    let values = |output: &Output| output.corrected().into_iter().chain(output.innovation());
    let [relative, absolute] = TOLERANCE;
    let mut pairs = values(one).zip(values(other)).zip(SPREAD.into_iter().cycle());
    let alike = pairs.all(|((one, other), spread)| {
        one.to_bits() == other.to_bits()
            || !bit_for_bit && (one - other).abs() <= relative * spread + absolute
    });
    !alike
        || (one.validity(), one.still) != (other.validity(), other.still)
        // the rate covers the last 10 s of each
        || one.faults - Faults::RATE != other.faults - Faults::RATE
        || alarms && one.drift != other.drift
}

fn loaded(image: &[u8], supply: f32) -> Result<TestHub, String> {
    let mut hub = TestHub::new(SCALES);
    hub.load(image).map_err(|error| error.to_string())?;
    hub.give(Quantity::Supply, supply);
    Ok(hub)
}

/// Runs a device for `ticks`; returns an error on the first violation.
fn soak(ticks: u64, defect: Defect) -> Result<Findings, String> {
    let begun = Instant::now();
    let held_before = HELD_BYTES.get();
    let held_bytes = || HELD_BYTES.get().wrapping_sub(held_before);
    let mut found = Findings::default();
    let mut world = World {
        random: Random(24),
        samples: 0,
        held: None,
        stuck: 0,
        cold: 0,
        supply: 3.3,
        clock_off_us: 1 << 40,
    };
    let mut device = store(Flash::new());
    let (mut newest, mut before) = (image(0), None::<Vec<u8>>);
    poll_once(device.store(&newest)).expect("done at once").map_err(|error| format!("{error:?}"))?;
    let mut hub = loaded(&newest, world.supply)?;
    let (mut twin, mut in_use): (Option<Twin>, u32) = (None, 0);

    while found.ticks < ticks {
        if found.held_bytes[0] == 0 && found.ticks > ticks / 10 {
            found.held_bytes[0] = held_bytes();
        }
        let raw = world.sample();
        let mut given = raw;
        if defect == Defect::Miscounts && !raw.faults.is_empty() {
            given.skipped = given.skipped.saturating_sub(1);
        }
        let motion =
            [None, None, Some(Motion::Still), Some(Motion::Moving)][world.samples as usize / 10_000 % 4];
        found.ticks += 1 + u64::from(raw.skipped);
        found.samples += 1;
        found.faults += u64::from(!raw.faults.is_empty());
        if world.once_in(10_000) {
            world.clock_off_us = (1 << 40) + u64::from(world.up_to(1 << 24)) * 1000;
        }
        let clock_us = world.samples.is_multiple_of(10).then_some(found.ticks * 5000 + world.clock_off_us);

        let mut step = |hub: &mut TestHub| {
            let allocated = ALLOCATED.get();
            hub.set_motion(motion);
            hub.give(Quantity::Supply, world.supply);
            let output = *hub.update(&given);
            if defect == Defect::Leaks {
                black_box(Box::leak(Box::new([1_u8; 64])));
            }
            if let Some(clock_us) = clock_us {
                hub.clock(clock_us);
            }
            found.allocated += ALLOCATED.get() - allocated;
            output
        };
        let output = step(&mut hub);
        found.counted = output.tick.wrapping_add(1);
        if found.counted != found.ticks as u32 {
            return Err(format!("{} ticks counted of {} sent", found.counted, found.ticks));
        }
        if !output.corrected().iter().all(|value| value.is_finite()) {
            return Err(format!("not finite: {output:?}"));
        }
        if let Some(Twin { hub: other, stage, ticks }) = &mut twin {
            let expected = output;
            let output = step(other);
            if output.tick != expected.tick.wrapping_sub(*ticks) {
                return Err(format!("the restarted hub counts {} ticks", output.tick));
            }
            // depends on the update in use
            let with_low_passes = has_low_passes(in_use);
            let limit = if with_low_passes { SETTLED_AFTER } else { BITWISE_AFTER };
            let differs = differ(
                &output,
                &expected,
                matches!(stage, Stage::Twins),
                !with_low_passes || matches!(stage, Stage::Twins),
            );
            match stage {
                Stage::Gap if raw.skipped > 0 => *stage = Stage::Measured,
                Stage::Measured => {
                    let measured =
                        |output: &Output| output.validity().iter().all(|validity| validity.is_valid());
                    if measured(&output) && measured(&expected) {
                        *stage = Stage::Settling(0);
                    }
                }
                Stage::Gap => {}
                Stage::Settling(since) => {
                    *since += 1;
                    if differs {
                        let settled = &mut found.settled[usize::from(with_low_passes)];
                        *settled = (*settled).max(*since);
                        if *since > limit {
                            return Err(format!("after {since} samples {output:?} instead of {expected:?}"));
                        }
                    } else if *since > limit {
                        let (restarts, samples) = &mut found.compared[1 + usize::from(with_low_passes)];
                        *restarts += u32::from(*since == limit + 1);
                        *samples += 1;
                    }
                }
                Stage::Twins => {
                    if differs {
                        return Err(format!("restarted at the same tick {output:?} instead of {expected:?}"));
                    }
                    found.compared[0].1 += 1;
                }
            }
        }

        if world.once_in(15_000) {
            // the power may fail while an update is stored
            let number = found.updates + 1;
            let next = image(number);
            let mut flash = device.release().0;
            if number.is_multiple_of(4) {
                flash.power = Some((1 + world.up_to(6) as usize, number as usize / 4 % 3));
            }
            device = store(flash);
            let stored = if defect == Defect::Forgets && number == 3 {
                true
            } else {
                let allocated = ALLOCATED.get();
                let stored = poll_once(device.store(&next)).expect("done at once").is_ok();
                found.allocated += ALLOCATED.get() - allocated;
                stored
            };
            let mut flash = device.release().0;
            let cut = matches!(flash.power, Some((0, _)));
            flash.power = None;
            device = store(flash);
            found.updates = number;
            found.cuts += u32::from(cut);
            if !stored && !cut {
                return Err(format!("update {number} was refused"));
            }
            let found_image =
                poll_once(device.load()).expect("done at once").ok().flatten().map(<[u8]>::to_vec);
            if found_image.as_deref() == Some(&next) {
                before = Some(std::mem::replace(&mut newest, next));
                in_use = number;
            } else if stored || found_image.as_deref() != Some(&newest) {
                return Err(format!("update {number} is not in the flash"));
            }
            let previous = poll_once(device.load_previous()).expect("done at once").ok().flatten();
            if !(previous == before.as_deref() || cut) {
                return Err(format!("the image before update {number} is gone"));
            }
            hub.load(&newest).map_err(|error| error.to_string())?;
            twin = Some(Twin {
                hub: loaded(&newest, world.supply)?,
                stage: Stage::Twins,
                ticks: found.ticks as u32,
            });
            found.restarts += 1;
            found.compared[0].0 += 1;
        } else if world.once_in(15_000) {
            let newest =
                poll_once(device.load()).expect("done at once").ok().flatten().ok_or("nothing is stored")?;
            let image = before.as_deref().filter(|_| defect == Defect::Stale).unwrap_or(newest);
            twin = Some(Twin {
                hub: loaded(image, world.supply)?,
                stage: Stage::Gap,
                ticks: found.ticks as u32,
            });
            found.restarts += 1;
        }
    }
    let flash = device.release().0;
    (found.operations, found.erased) = (flash.operations, flash.erased);
    found.held_bytes[1] = held_bytes();
    found.seconds = begun.elapsed().as_secs_f64();
    Ok(found)
}

/// Violations that show only over a whole run.
fn violations(found: &Findings) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut must = |holds: bool, what: String| wrong.extend((!holds).then_some(what));
    must(found.faults > 0 && found.updates > 3 && found.cuts > 0, "too little happened".to_owned());
    must(found.compared.iter().all(|(restarts, _)| *restarts > 0), "nothing was compared".to_owned());
    must(found.allocated == 0, format!("the device's code allocates, {} times", found.allocated));
    // a full page is replaced and one image moved; an interrupted update takes room, and a repair may erase
    let images_per_page = (PAGE / (image(999).len() + 64)) as u32;
    let turns = (found.updates + 1) / (images_per_page - 1) + 2 * found.cuts + PAGES as u32;
    let erased: u32 = found.erased.iter().sum();
    must(erased <= turns, format!("{erased} erases, at most {turns}: {:?}", found.erased));
    let [early, late] = found.held_bytes;
    // there may be a second image, in a vector with spare capacity
    must(late <= early + 2048, format!("memory grows: {early} bytes, then {late}"));
    wrong
}

fn check(found: &Findings) {
    println!("soak: {found}");
    assert_eq!(violations(found), [""; 0], "{found}");
}

#[test]
fn ten_minutes_of_faults_and_updates_leave_no_trace() {
    check(&soak(600 * TICKS_PER_SECOND, Defect::None).expect("a sound unit"));
}

#[test]
#[ignore = "a day of sensor time, in release: .ci/trust soak runs it"]
fn a_day_of_faults_and_updates_leaves_no_trace() {
    check(&soak(24 * 3600 * TICKS_PER_SECOND, Defect::None).expect("a sound unit"));
}

#[test]
fn detects_miscounts_lost_updates_stale_images_and_leaks() {
    let mut found = Vec::new();
    for (defect, message, what) in [
        (Defect::Miscounts, "ticks counted", "a hub whose counter is off by one after a fault"),
        (Defect::Forgets, "is not in the flash", "a store that loses one update"),
        (Defect::Stale, "instead of", "a restart from the second-newest image"),
    ] {
        match soak(3600 * TICKS_PER_SECOND, defect) {
            Err(error) => assert!(error.contains(message), "{defect:?}: {error}"),
            Ok(findings) => panic!("{defect:?} is not found: {findings}"),
        }
        found.push(what);
    }
    let leaking = violations(&soak(3600 * TICKS_PER_SECOND, Defect::Leaks).expect("it runs"));
    assert!(leaking.iter().any(|wrong| wrong.contains("allocates")), "{leaking:?}");
    assert!(leaking.iter().any(|wrong| wrong.contains("memory grows")), "{leaking:?}");
    found.push("a leak of 64 bytes per sample");
    println!("detected: {}", found.join(", "));
}
