//! gzip members, concatenated as gzip does; trailing zeros, left by tapes and block devices, are ignored.

use std::io::{self, BufRead, Read};

use flate2::bufread::GzDecoder;

/// Reader of the concatenated contents of all members.
pub(super) struct Members<R> {
    member: Option<GzDecoder<R>>,
}

impl<R: BufRead> Members<R> {
    pub(super) fn new(input: R) -> Self {
        Self { member: Some(GzDecoder::new(input)) }
    }
}

impl<R: BufRead> Read for Members<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = self.member.as_mut().filter(|_| !buffer.is_empty()) {
            let read = member.read(buffer)?;
            if read > 0 {
                return Ok(read);
            }
            self.member = self.member.take().map(GzDecoder::into_inner).map(next).transpose()?.flatten();
        }
        Ok(0)
    }
}

/// Decoder of the next member, if there is one.
fn next<R: BufRead>(mut input: R) -> io::Result<Option<GzDecoder<R>>> {
    loop {
        let bytes = input.fill_buf()?;
        let zeros = bytes.iter().take_while(|&&byte| byte == 0).count();
        match bytes.get(zeros) {
            None if bytes.is_empty() => return Ok(None),
            // the begin of a member; the decoder checks whether it is one
            Some(0x1f) => {
                input.consume(zeros);
                return Ok(Some(GzDecoder::new(input)));
            }
            Some(byte) => {
                let text = format!(
                    "after the end of the gzip data comes something else, beginning with {byte:#04x}"
                );
                return Err(io::Error::new(io::ErrorKind::InvalidData, text));
            }
            None => input.consume(zeros),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    fn packed(text: &str) -> Vec<u8> {
        let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(text.as_bytes()).unwrap();
        packed.finish().unwrap()
    }

    /// Decompressed from buffers of several lengths, into pieces of `piece` bytes.
    fn unpacked(bytes: &[u8], piece: usize) -> Result<String, String> {
        let mut unpacked = Vec::new();
        for buffer in [1, 2, 7, 4096] {
            let mut members = Members::new(io::BufReader::with_capacity(buffer, bytes));
            let (mut text, mut read) = (Vec::new(), vec![0; piece]);
            loop {
                match members.read(&mut read).map_err(|error| error.to_string())? {
                    0 => break,
                    n => text.extend(&read[..n]),
                }
            }
            unpacked.push(String::from_utf8(text).unwrap());
        }
        unpacked.dedup();
        assert_eq!(unpacked.len(), 1);
        Ok(unpacked.remove(0))
    }

    #[test]
    fn concatenates_members_and_ignores_trailing_zeros() {
        let (one, two) = (packed("one\n"), packed("two\n"));
        for piece in [1, 3, 100] {
            assert_eq!(unpacked(&[&*one, &two].concat(), piece).unwrap(), "one\ntwo\n");
            // used to be rejected as an invalid header
            assert_eq!(unpacked(&[&*one, &[0; 5000]].concat(), piece).unwrap(), "one\n");
            assert_eq!(unpacked(&[&*one, &[0; 512], &two, &[0]].concat(), piece).unwrap(), "one\ntwo\n");
            assert_eq!(unpacked(&packed(""), piece).unwrap(), "");
        }
    }

    #[test]
    fn rejects_other_data_after_the_members() {
        let one = packed("one\n");
        for (tail, says) in [
            (&b"hello"[..], "beginning with 0x68"),
            (b"\0\0x", "beginning with 0x78"),
            (b"\x1f", "end of file"),
            (b"\x1f\x00 is no member", "header"),
        ] {
            let message = unpacked(&[&*one, tail].concat(), 10).unwrap_err();
            assert!(message.contains(says), "{tail:?}: {message}");
        }
    }
}
