//! Streams with separate timestamps: memory, samples in, samples for the hub out.

use core::ffi::c_void;

use fos_core::align::{Counts, Refused};

use super::place::{Place, exclusive, make_in, shared};
use super::{fos_si_sample, fos_status};
use crate::streams::{Periods, StampedSample, StreamCounts, Streams};

/// Capacity of the queues of gyros and accelerometers, samples each; a batch must fit.
pub const FOS_STREAMS_DEPTH: usize = 64;
/// Bytes that suffice for streams on every target, for memory reserved at compile time.
pub const FOS_STREAMS_BYTES: usize = 3584;
/// Alignment that suffices for streams on every target, in bytes.
pub const FOS_STREAMS_ALIGN: usize = 8;

/// Resamples gyros, accelerometers and a thermometer with separate timestamps to samples of one sensor, for
/// fos_hub_update_si(). The streams live in memory of the caller, like a hub.
///
/// The gyros lead: every gyro sample becomes a sample of the hub. Accelerometers are interpolated between their two
/// neighbours, and missing where a sample was lost. The temperature is the newest at or before the gyro sample, and missing
/// if older than three of its periods. Missing values are NaN, which the hub flags. `skipped` follows from the timestamps. A
/// sample that came faster than the period, because another client requested a faster rate, is passed over and counted.
/// Streams may arrive in any order between streams and in any batches, with the same result. When the clock was set back,
/// which is detected after 8 samples, the next sample has FOS_FAULT_RESET and the 7 rejected ones as skipped.
///
/// Timestamps are in ns of one clock with any origin; the caller corrects offsets between clocks.
pub struct fos_streams {
    streams: Streams<FOS_STREAMS_DEPTH>,
}

#[cfg(feature = "defmt")]
impl defmt::Format for fos_streams {
    fn format(&self, f: defmt::Formatter<'_>) {
        self.streams.format(f);
    }
}

/// Nominal periods of the streams, ns.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_stream_periods {
    /// Period of the gyros, equal to that of the hub's scales; not 0.
    pub gyro_ns: u64,
    /// Period of the accelerometers; not 0.
    pub accel_ns: u64,
    /// Period of the thermometer; 0 if there is none.
    pub temperature_ns: u64,
}

/// Counts of one stream: samples that did not enter a sample of the hub unchanged. Each saturates.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_stream_count {
    /// Samples rejected because their timestamp did not increase.
    pub refused: u32,
    /// Samples with a value that is not finite.
    pub not_finite: u32,
    /// Samples dropped because the queue was full or the clock was set back.
    pub dropped: u32,
    /// Number of times the clock was set back.
    pub set_back: u32,
    /// Samples returned or passed over without a value of this stream; 0 for the gyros, see `not_finite`.
    pub missing: u32,
}

/// Counts of all streams.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_stream_counts {
    /// Counts of the gyros.
    pub gyro: fos_stream_count,
    /// Counts of the accelerometers.
    pub accel: fos_stream_count,
    /// Counts of the thermometer.
    pub temperature: fos_stream_count,
    /// Gyro samples passed over because they came faster than the period.
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

/// Size of streams in bytes, at most FOS_STREAMS_BYTES.
#[unsafe(no_mangle)]
pub extern "C" fn fos_streams_size() -> usize {
    size_of::<fos_streams>()
}

/// Alignment of streams in bytes, at most FOS_STREAMS_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn fos_streams_align() -> usize {
    align_of::<fos_streams>()
}

/// Creates empty streams in `memory` of `size` bytes, whose contents are overwritten. `*out` then points to the start of
/// `memory`. `periods` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `periods` or `out`.
/// - FOS_STATUS_NO_ROOM: `size` is less than fos_streams_size().
/// - FOS_STATUS_ARGUMENT: a period exceeds INT64_MAX, the period of gyros or accelerometers is 0, or `size` is impossible at
///   that address.
///
/// After any status other than FOS_STATUS_OK `*out` is NULL, if `out` itself is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_init(
    memory: *mut c_void,
    size: usize,
    periods: *const fos_stream_periods,
    out: *mut *mut fos_streams,
) -> fos_status {
    // SAFETY: `out` points to a pointer and `memory` to `size` bytes, as the header requires
    unsafe {
        make_in(memory, size, out, |place| {
            // SAFETY: `periods` points to periods that are not modified meanwhile, as the header requires
            let periods = shared(periods)?.to_periods()?;
            // a constant: set in place and not copied over the stack
            place.put(const { fos_streams { streams: Streams::without_periods() } });
            // SAFETY: created in the line above
            exclusive(memory.cast::<fos_streams>())?.streams.set_periods(&periods);
            Ok(())
        })
    }
}

/// Sets the periods from the next sample on, after the requested rate of a stream has changed. `gyro_ns` must remain the
/// period of the hub's scales. `periods` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `periods`.
/// - FOS_STATUS_ARGUMENT: a period is invalid, as for fos_streams_init(); the periods are unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_set_periods(
    streams: *mut fos_streams,
    periods: *const fos_stream_periods,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: streams that are in no other call, as the header requires
        let streams = unsafe { exclusive(streams) }?;
        // SAFETY: periods that are not modified meanwhile, as the header requires
        streams.streams.set_periods(&unsafe { shared(periods) }?.to_periods()?);
        Ok(())
    })())
}

/// Adds a gyro sample: angular rate x, y, z, rad/s. Call fos_streams_next() afterwards until it returns
/// FOS_STATUS_NOT_KNOWN: a full queue drops its oldest sample.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_TAKEN: the timestamp does not increase, and the sample is rejected; or a value is not finite, and the
///   sample remains with the gyros missing. fos_streams_counts() distinguishes the two.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which points to three values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_gyro(
    streams: *mut fos_streams,
    stamp_ns: i64,
    value: *const f32,
) -> fos_status {
    // SAFETY: streams that are in no other call and three values that are not modified meanwhile, as the header requires
    unsafe { push(streams, value, |streams, value| streams.push_gyro(stamp_ns, value)) }
}

/// Adds an accelerometer sample: specific force x, y, z, m/s^2.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_TAKEN: the timestamp does not increase, or a value is not finite.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which points to three values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_accel(
    streams: *mut fos_streams,
    stamp_ns: i64,
    value: *const f32,
) -> fos_status {
    // SAFETY: streams that are in no other call and three values that are not modified meanwhile, as the header requires
    unsafe { push(streams, value, |streams, value| streams.push_accel(stamp_ns, value)) }
}

/// Adds a temperature of the sensor, degrees Celsius. Add it before the gyro samples that it applies to.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_TAKEN: the timestamp does not increase, or the value is not finite.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_temperature(
    streams: *mut fos_streams,
    stamp_ns: i64,
    celsius: f32,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: streams that are in no other call, as the header requires
        let streams = unsafe { exclusive(streams) }?;
        taken(streams.streams.push_temperature(stamp_ns, celsius))
    })())
}

/// Returns the next sample for fos_hub_update_si() and its timestamp, that of the gyros, once no later value can change it
/// or the queue of the gyros is full.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_KNOWN: no further sample is ready; `*sample` and `*stamp_ns` are unchanged.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. No sample is removed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_next(
    streams: *mut fos_streams,
    sample: *mut fos_si_sample,
    stamp_ns: *mut i64,
) -> fos_status {
    // SAFETY: the header requires the conditions of `give`
    unsafe { give(streams, sample, stamp_ns, Streams::next) }
}

/// Returns the next sample with the values available, without waiting for the accelerometers: at the end, or before a long
/// sleep. Otherwise the same as fos_streams_next().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_KNOWN: there is no further sample; `*sample` and `*stamp_ns` are unchanged.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. No sample is removed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_flush(
    streams: *mut fos_streams,
    sample: *mut fos_si_sample,
    stamp_ns: *mut i64,
) -> fos_status {
    // SAFETY: the header requires the conditions of `give`
    unsafe { give(streams, sample, stamp_ns, Streams::flush) }
}

/// Counts of rejected, missing, dropped and passed-over samples since fos_streams_init().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `counts`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_streams_counts(
    streams: *const fos_streams,
    counts: *mut fos_stream_counts,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: streams that are in no other call, as the header requires
        let streams = unsafe { shared(streams) }?;
        // SAFETY: `counts` points to memory for counts, as the header requires
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
/// `streams` satisfies the conditions of [`exclusive`], and `value` those of [`shared`] for three values.
unsafe fn push(
    streams: *mut fos_streams,
    value: *const f32,
    push: impl FnOnce(&mut Streams<FOS_STREAMS_DEPTH>, [f32; 3]) -> Push,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: guaranteed by the caller
        let streams = unsafe { exclusive(streams) }?;
        // SAFETY: guaranteed by the caller; an array has the alignment of its values
        let value = *unsafe { shared(value.cast::<[f32; 3]>()) }?;
        taken(push(&mut streams.streams, value))
    })())
}

/// # Safety
///
/// `streams` satisfies the conditions of [`exclusive`], and the others those of [`Place::new`].
unsafe fn give(
    streams: *mut fos_streams,
    sample: *mut fos_si_sample,
    stamp_ns: *mut i64,
    next: impl FnOnce(&mut Streams<FOS_STREAMS_DEPTH>) -> Option<StampedSample>,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: guaranteed by the caller
        let streams = unsafe { exclusive(streams) }?;
        // SAFETY: guaranteed by the caller
        let sample = unsafe { Place::new(sample) }?;
        // SAFETY: guaranteed by the caller
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
