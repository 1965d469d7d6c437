// Frames of telemetry, as docs of fos-embedded::telemetry describe them: postcard and its CRC-32 in COBS, ended by a zero.

const table = Uint32Array.from({ length: 256 }, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; bit++) {
    crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  }
  return crc;
});

function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc = table[(crc ^ byte) & 0xff] ^ (crc >>> 8);
  }
  return ~crc >>> 0;
}

/** Content of a COBS frame without its zero; null if it is damaged. */
function unstuff(frame) {
  const content = [];
  for (let at = 0; at < frame.length; ) {
    const block = frame[at];
    if (at + block > frame.length) {
      return null;
    }
    content.push(...frame.slice(at + 1, at + block));
    at += block;
    if (block < 0xff && at < frame.length) {
      content.push(0);
    }
  }
  return content;
}

/** A sample of a frame's content, or null for a start frame. */
function sample(content) {
  const view = new DataView(Uint8Array.from(content).buffer);
  let at = 0;
  const varint = () => {
    let value = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = view.getUint8(at++);
      value += (byte & 0x7f) * 2 ** shift;
      if (byte < 0x80) {
        return value;
      }
    }
  };
  const floats = () => Array.from({ length: varint() }, () => view.getFloat32((at += 4) - 4, true));
  if (varint() === 0) {
    return null;
  }
  const tick = varint();
  const still = view.getUint8(at++) === 1;
  const [measured, quantities, innovations] = [floats(), floats(), floats()];
  const validity = Array.from({ length: varint() }, varint);
  return { tick, still, measured, quantities, innovations, validity };
}

/** Samples in a stream, with the number of damaged frames; what follows the last zero is not looked at. */
export function decode(stream) {
  const samples = [];
  let damaged = 0;
  let starts = 0;
  let begin = 0;
  for (;;) {
    const end = stream.indexOf(0, begin);
    if (end < 0) {
      return { samples, damaged, starts };
    }
    const frame = stream.slice(begin, end);
    begin = end + 1;
    if (frame.length === 0) {
      continue;
    }
    const content = unstuff(frame);
    const crc = content?.splice(-4).reduceRight((value, byte) => value * 256 + byte, 0);
    if (!content || crc32(content) !== crc) {
      damaged++;
      continue;
    }
    const one = sample(content);
    if (one) {
      samples.push(one);
    } else {
      starts++;
    }
  }
}
