//! Frames a model image for a device that receives it over the line of its telemetry.
//!
//! ```text
//! cargo run -p fos-embedded --example image_frame -- model.fosm >/dev/ttyUSB0
//! ```

use std::error::Error;
use std::io::Write as _;

use fos_embedded::telemetry::encode_image;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("usage: image_frame MODEL.fosm")?;
    let image = std::fs::read(path)?;
    let mut buffer = vec![0; image.len() + image.len() / 254 + 6];
    let frame = encode_image(&image, &mut buffer).ok_or("the buffer is too short")?;
    // the first zero ends whatever is on the line
    let mut line = std::io::stdout();
    line.write_all(&[0])?;
    line.write_all(frame)?;
    Ok(line.flush()?)
}
