//! Streams with stamps of their own: memory, samples in, samples for the hub out.

use core::ffi::c_void;

use fos_core::align::{Counts, Refused};

use super::place::{Place, exclusive, make_in, shared};
use super::{fos_si_sample, fos_status};
use crate::streams::{Periods, StampedSample, StreamCounts, Streams};

/// Samples of gyros and of accelerometers that are queued: a batch must go in.
pub const FOS_STREAMS_DEPTH: usize = 64;
/// Bytes that are enough for streams on every target: for memory that is reserved when compiling.
pub const FOS_STREAMS_BYTES: usize = 3584;
/// An alignment that is enough for streams on every target, in bytes.
pub const FOS_STREAMS_ALIGN: usize = 8;

/// Gyros, accelerometers and a thermometer, each with stamps of its own, as samples of one sensor for
/// fos_hub_update_si(). It lives in memory of the caller's, as a hub does.
///
/// The gyros lead: every sample of theirs is one for the hub. The accelerometers are interpolated between their two
/// neighbours, and missing where a sample is lost; the temperature is the newest that is not of later, and missing where
/// it is older than three of its periods. What is missing is NaN, which the hub says. `skipped` is what the stamps say;
/// a sample that came faster than the period, because another client asked for a faster rate, is passed over and
/// counted. Streams may come in any order between them and in any batches; the samples are the same. Where a clock is set
/// back, which is certain after 8 samples, the sample says FOS_FAULT_RESET and has the 7 before as skipped.
///
/// Stamps are ns of one clock, whatever it is; an offset between clocks is the caller's to add.
pub struct fos_streams {
    streams: Streams<FOS_STREAMS_DEPTH>,
}

#[cfg(feature = "defmt")]
impl defmt::Format for fos_streams {
    fn format(&self, f: defmt::Formatter<'_>) {
        self.streams.format(f);
    }
}

/// Nominal periods, ns.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_stream_periods {
    /// Of the gyros: that of the hub's scales. Not 0.
    pub gyro_ns: u64,
    /// Of the accelerometers. Not 0.
    pub accel_ns: u64,
    /// Of the thermometer; 0 if there is none.
    pub temperature_ns: u64,
}

/// What did not go into a sample as it came; each stays at its highest value.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_stream_count {
    /// Stamps that did not increase.
    pub refused: u32,
    /// Samples with a value that is not finite.
    pub not_finite: u32,
    /// Samples that a full queue lost, or a clock that was set back.
    pub dropped: u32,
    /// Times that the clock was set back.
    pub set_back: u32,
    /// Samples given, or passed over, without a value of this stream; of the gyros see `not_finite`.
    pub missing: u32,
}

/// The same of all streams.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_stream_counts {
    /// Of the gyros.
    pub gyro: fos_stream_count,
    /// Of the accelerometers.
    pub accel: fos_stream_count,
    /// Of the thermometer.
    pub temperature: fos_stream_count,
    /// Samples of the gyros that came faster than their period.
    pub passed_over: u32,
}

const _: () = {
    assert!(size_of::<fos_streams>() <= FOS_STREAMS_BYTES && align_of::<fos_streams>() <= FOS_STREAMS_ALIGN);
    // c/layout.c has the same numbers
    assert!(size_of::<fos_stream_periods>() == 24 && align_of::<fos_stream_periods>() == 8);
    assert!(size_of::<fos_stream_counts>() == 64 && align_of::<fos_stream_counts>() == 4);
};

impl fos_stream_periods {
    fn to_periods(self) -> Result<Periods, fos_status> {
        let Self { gyro_ns, accel_ns, temperature_ns } = self;
        let all = [gyro_ns, accel_ns, temperature_ns];
        if gyro_ns == 0 || accel_ns == 0 || all.iter().any(|period| i64::try_from(*period).is_err()) {
            return Err(fos_status::Argument);
        }
        Ok(Periods { gyro_ns, accel_ns, temperature_ns })
    }
}

impl From<Counts> for fos_stream_count {
    fn from(counts: Counts) -> Self {
        let Counts { refused, not_finite, dropped, set_back, missing } = counts;
        Self { refused, not_finite, dropped, set_back, missing }
    }
}

/// Bytes that streams take, at most FOS_STREAMS_BYTES.
#[unsafe(no_mangle)]
pub extern "C" fn fos_streams_size() -> usize {
    size_of::<fos_streams>()
}

/// Alignment that streams take, in bytes, at most FOS_STREAMS_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn fos_streams_align() -> usize {
    align_of::<fos_streams>()
}

/// Makes streams without a sample in `memory` of `size` bytes; what was there before does not matter. `*out` is then at
/// the start of `memory`. `periods` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `periods` or `out`.
/// - FOS_STATUS_NO_ROOM: `size` is less than fos_streams_size().
/// - FOS_STATUS_ARGUMENT: a period is more than INT64_MAX, one that must not be 0 is, or no memory at `memory` can have
///   `size` bytes.
///
/// After any other status than FOS_STATUS_OK `*out` is NULL, where `out` itself can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_init(
    memory: *mut c_void,
    size: usize,
    periods: *const fos_stream_periods,
    out: *mut *mut fos_streams,
) -> fos_status {
    // SAFETY: `out` leads to a pointer and `memory` to `size` bytes, as the header asks
    unsafe {
        make_in(memory, size, out, |place| {
            // SAFETY: `periods` leads to periods that are not being changed, as the header asks
            let periods = shared(periods)?.to_periods()?;
            // a constant: it is set in place and not copied over the stack
            place.put(const { fos_streams { streams: Streams::without_periods() } });
            // SAFETY: they were made just now
            exclusive(memory.cast::<fos_streams>())?.streams.set_periods(&periods);
            Ok(())
        })
    }
}

/// Other periods, from the next sample on: what a stream was asked for has changed. `gyro_ns` is to stay the period of the
/// hub's scales. `periods` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `periods`.
/// - FOS_STATUS_ARGUMENT: as of fos_streams_init(); the periods are as before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_set_periods(
    streams: *mut fos_streams,
    periods: *const fos_stream_periods,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: streams that are in no other call, as the header asks
        let streams = unsafe { exclusive(streams) }?;
        // SAFETY: periods that are not being changed, as the header asks
        streams.streams.set_periods(&unsafe { shared(periods) }?.to_periods()?);
        Ok(())
    })())
}

/// Takes a sample of the gyros: rate x, y, z, rad/s. Call fos_streams_next() after it until there is nothing more: a full
/// queue loses its oldest sample.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_TAKEN: its stamp does not increase, and nothing was done; or a value is not finite, and the sample is
///   there without gyros. fos_streams_counts() says which.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which leads to three.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_gyro(
    streams: *mut fos_streams,
    stamp_ns: i64,
    value: *const f32,
) -> fos_status {
    // SAFETY: streams that are in no other call and three values that are not being changed, as the header asks
    unsafe { push(streams, value, |streams, value| streams.push_gyro(stamp_ns, value)) }
}

/// Takes a sample of the accelerometers: specific force x, y, z, m/s^2.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_TAKEN: its stamp does not increase, or a value is not finite.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which leads to three.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_accel(
    streams: *mut fos_streams,
    stamp_ns: i64,
    value: *const f32,
) -> fos_status {
    // SAFETY: streams that are in no other call and three values that are not being changed, as the header asks
    unsafe { push(streams, value, |streams, value| streams.push_accel(stamp_ns, value)) }
}

/// Takes a temperature of the sensor, degrees Celsius; before the samples of the gyros that it is for.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_TAKEN: its stamp does not increase, or it is not finite.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_temperature(
    streams: *mut fos_streams,
    stamp_ns: i64,
    celsius: f32,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: streams that are in no other call, as the header asks
        let streams = unsafe { exclusive(streams) }?;
        taken(streams.streams.push_temperature(stamp_ns, celsius))
    })())
}

/// The next sample for fos_hub_update_si(), and its stamp, that of the gyros; as soon as nothing that may still come can
/// change it, or the queue of the gyros is full.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_KNOWN: there is nothing more yet; `*sample` and `*stamp_ns` are as before.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. Nothing is taken out.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_next(
    streams: *mut fos_streams,
    sample: *mut fos_si_sample,
    stamp_ns: *mut i64,
) -> fos_status {
    // SAFETY: what `give` asks is what the header asks
    unsafe { give(streams, sample, stamp_ns, Streams::next) }
}

/// As fos_streams_next(), with what there is, without waiting for the accelerometers: for the end, or before a long sleep.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_KNOWN: there is nothing more; `*sample` and `*stamp_ns` are as before.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. Nothing is taken out.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_flush(
    streams: *mut fos_streams,
    sample: *mut fos_si_sample,
    stamp_ns: *mut i64,
) -> fos_status {
    // SAFETY: what `give` asks is what the header asks
    unsafe { give(streams, sample, stamp_ns, Streams::flush) }
}

/// What was refused, missing, lost or passed over since fos_streams_init().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `counts`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_counts(
    streams: *const fos_streams,
    counts: *mut fos_stream_counts,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: streams that are in no other call, as the header asks
        let streams = unsafe { shared(streams) }?;
        // SAFETY: `counts` leads to memory for counts, as the header asks
        let place = unsafe { Place::new(counts) }?;
        let StreamCounts { gyro, accel, temperature, passed_over } = streams.streams.counts();
        let [gyro, accel, temperature] = [gyro, accel, temperature].map(Into::into);
        place.put(fos_stream_counts { gyro, accel, temperature, passed_over });
        Ok(())
    })())
}

type Push = Result<(), Refused>;

/// # Safety
///
/// As of [`exclusive`] for `streams`, and as of [`shared`] for three values.
unsafe fn push(
    streams: *mut fos_streams,
    value: *const f32,
    push: impl FnOnce(&mut Streams<FOS_STREAMS_DEPTH>, [f32; 3]) -> Push,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: the caller's promise
        let streams = unsafe { exclusive(streams) }?;
        // SAFETY: the caller's promise; an array is aligned as its values are
        let value = *unsafe { shared(value.cast::<[f32; 3]>()) }?;
        taken(push(&mut streams.streams, value))
    })())
}

/// # Safety
///
/// As of [`exclusive`] for `streams`, and as of [`Place::new`] for the others.
unsafe fn give(
    streams: *mut fos_streams,
    sample: *mut fos_si_sample,
    stamp_ns: *mut i64,
    next: impl FnOnce(&mut Streams<FOS_STREAMS_DEPTH>) -> Option<StampedSample>,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: the caller's promise
        let streams = unsafe { exclusive(streams) }?;
        // SAFETY: the caller's promise
        let sample = unsafe { Place::new(sample) }?;
        // SAFETY: the caller's promise
        let stamp_ns = unsafe { Place::new(stamp_ns) }?;
        let stamped = next(&mut streams.streams).ok_or(fos_status::NotKnown)?;
        sample.put((&stamped.sample).into());
        stamp_ns.put(stamped.stamp_ns);
        Ok(())
    })())
}

fn taken(pushed: Push) -> Result<(), fos_status> {
    pushed.map_err(|_| fos_status::NotTaken)
}
