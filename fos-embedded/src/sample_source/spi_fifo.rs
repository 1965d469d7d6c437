//! Frames of 16 bytes from a FIFO on SPI.

use embedded_hal_async::spi::{Operation, SpiDevice};

use super::{Batch, MAX_SAMPLES};

/// Bytes of a frame: accelerometers, gyros, temperature, time.
pub(super) const FRAME: usize = 16;

/// Frames per transfer: 0.1 ms at 10 MHz.
const FRAMES: usize = 8;

/// Most dummy bytes before the data.
const MAX_DUMMY: usize = 1;

/// Reads `batch.left` frames, as many as fit into the batch, and passes each to `take`. `command` is the first byte on the
/// bus, followed by `dummy` bytes without meaning.
pub(super) async fn read_frames<S: SpiDevice>(
    spi: &mut S,
    command: u8,
    dummy: usize,
    batch: &mut Batch,
    mut take: impl FnMut(&[u8; FRAME], &mut Batch),
) -> Result<(), S::Error> {
    let command = [command];
    for _ in 0..MAX_SAMPLES / FRAMES {
        let frames = usize::from(batch.left).min(batch.room()).min(FRAMES);
        let mut bytes = [0; MAX_DUMMY + FRAMES * FRAME];
        let bytes = bytes.get_mut(..dummy.saturating_add(frames * FRAME)).unwrap_or_default();
        if frames == 0 {
            break;
        }
        let mut burst = [Operation::Write(&command), Operation::Read(bytes)];
        spi.transaction(&mut burst).await?;
        batch.left = batch.left.saturating_sub(frames as u16);
        for frame in bytes.get(dummy..).unwrap_or_default().as_chunks().0 {
            take(frame, batch);
        }
    }
    Ok(())
}

/// Returns true if nothing drove the line at the end of a frame: all bytes of its temperature and time are the same ones or
/// zeros.
pub(super) fn is_released(end: &[u8]) -> bool {
    end.iter().all(|byte| *byte == 0) || end.iter().all(|byte| *byte == 0xff)
}
