// Contents of the flash from an ELF file: its loaded segments at their physical addresses.

import { readFileSync } from 'node:fs';

const FLASH = 0x10000000;
const LOAD = 1;

const images = new Map();

/** Contents of the flash; the same array for the same file. */
export function flashImage(path) {
  if (!images.has(path)) {
    images.set(path, read(path));
  }
  return images.get(path);
}

function read(path) {
  const file = readFileSync(path);
  const [table, size, count] = [file.readUInt32LE(28), file.readUInt16LE(42), file.readUInt16LE(44)];
  const image = [];
  for (let header = table; header < table + size * count; header += size) {
    const [type, offset, , address, bytes] = [0, 4, 8, 12, 16].map((at) => file.readUInt32LE(header + at));
    if (type === LOAD && bytes > 0) {
      image.push({ at: address - FLASH, bytes: file.subarray(offset, offset + bytes) });
    }
  }
  const flash = new Uint8Array(Math.max(...image.map(({ at, bytes }) => at + bytes.length))).fill(0xff);
  image.forEach(({ at, bytes }) => flash.set(bytes, at));
  return flash;
}
