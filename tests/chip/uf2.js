// The firmware in the form that a Pico's drive takes: blocks of 512 bytes with 256 of flash each.
// https://github.com/microsoft/uf2

import { writeFileSync } from 'node:fs';

import { flashImage } from './elf.js';

const FLASH = 0x10000000;
const PAYLOAD = 256;
const FAMILY_PRESENT = 0x2000;
const RP2040 = 0xe48bff56;

export function uf2(file) {
  const image = flashImage(process.env.FOS_FIRMWARE);
  const count = Math.ceil(image.length / PAYLOAD);
  const blocks = Buffer.alloc(512 * count);
  for (let block = 0; block < count; block++) {
    const at = 512 * block;
    const header = [0x0a324655, 0x9e5d5157, FAMILY_PRESENT, FLASH + PAYLOAD * block, PAYLOAD, block, count, RP2040];
    header.forEach((word, index) => blocks.writeUInt32LE(word, at + 4 * index));
    blocks.set(image.subarray(PAYLOAD * block, PAYLOAD * (block + 1)), at + 32);
    blocks.writeUInt32LE(0x0ab16f30, at + 508);
  }
  writeFileSync(file, blocks);
  console.log(`${file}: ${image.length} bytes of flash`);
}
