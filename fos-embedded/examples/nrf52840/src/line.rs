//! The serial line as a stream that never waits.

use embassy_nrf::buffered_uarte::{BufferedUarteTx, Error};
use embedded_io::Write;

/// Takes what the buffer of the line has room for. A frame that does not fit is cut, and the receiver counts it as damaged.
pub struct Line(pub BufferedUarteTx<'static>);

impl embedded_io::ErrorType for Line {
    type Error = Error;
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        self.0.try_write(bytes)
    }

    fn flush(&mut self) -> Result<(), Error> {
        Ok(())
    }
}
