// The boot ROM, as far as firmware uses it: a table of functions, found by two letters (RP2040 data sheet, 2.8.3), and the
// start. Each function breaks into the emulator, which does its work on the flash, and returns.

import { ERASE, PAGE } from './flash.js';

const FUNCTION_TABLE = 0x40;
const LOOKUP = 0x20;
const FUNCTIONS = 0x100;

/// The second stage in flash: 252 bytes and their checksum. The ROM runs it at the end of the RAM.
const STAGE_2 = 256;
const STAGE_2_AT = 0x20041f00;

/// Typical times of a W25Q16JV (its data sheet, 9.6), s.
const ERASE_S = 0.045;
const PROGRAM_S = 0.0004;

/// Functions by their letters in the table; arguments are the registers r0 to r3.
const functions = {
  IF: (board) => board.connected(),
  EX: (board) => board.xip(false),
  RE: (board, [offset, bytes]) => {
    for (let at = offset; at < offset + bytes; at += ERASE) {
      board.flashStep(() => board.flash.erase(at), ERASE_S);
    }
  },
  RP: (board, [offset, from, bytes]) => {
    for (let done = 0; done < bytes; done += PAGE) {
      const page = board.ram(from + done, PAGE);
      board.flashStep(() => board.flash.program(offset + done, page), PROGRAM_S);
    }
  },
  FC: () => {},
  CX: (board) => board.xip(true),
  C4: (board, [to, from, bytes]) => board.copy(to, from, bytes),
  MC: (board, [to, from, bytes]) => board.copy(to, from, bytes),
};

/** Puts the ROM into the chip of a board, and the start of its processor behind the ROM's own code. */
export function boot(board) {
  const { chip } = board;
  const rom = new DataView(chip.bootrom.buffer);
  const names = Object.keys(functions);
  // "Mu", 1, version 2
  rom.setUint32(0x10, 0x0201754d, true);
  rom.setUint16(0x14, FUNCTION_TABLE, true);
  rom.setUint16(0x18, LOOKUP | 1, true);
  // lookup(r0: table, r1: letters): ldrh r2, [r0]; cmp r2, #0; beq end; adds r0, #4; cmp r2, r1; bne lookup; subs r0, #2;
  // ldrh r0, [r0]; bx lr; end: movs r0, #0; bx lr
  const lookup = [0x8802, 0x2a00, 0xd005, 0x3004, 0x428a, 0xd1f9, 0x3802, 0x8800, 0x4770, 0x2000, 0x4770];
  lookup.forEach((code, index) => rom.setUint16(LOOKUP + 2 * index, code, true));
  names.forEach((name, index) => {
    rom.setUint16(FUNCTION_TABLE + 4 * index, name.charCodeAt(0) | (name.charCodeAt(1) << 8), true);
    rom.setUint16(FUNCTION_TABLE + 4 * index + 2, (FUNCTIONS + 4 * index) | 1, true);
    // bkpt #index; bx lr
    rom.setUint16(FUNCTIONS + 4 * index, 0xbe00 | index, true);
    rom.setUint16(FUNCTIONS + 4 * index + 2, 0x4770, true);
  });
  chip.onBreak = (code) => {
    const at = chip.core.PC - 2;
    if (at < FUNCTIONS || at >= FUNCTIONS + 4 * names.length) {
      throw new Error(`breakpoint or undefined instruction at 0x${at.toString(16)}`);
    }
    functions[names[code]](board, chip.core.registers);
  };
  const stage2 = chip.flash.subarray(0, STAGE_2);
  if (checksum(stage2.subarray(0, 252)) !== new DataView(stage2.buffer, stage2.byteOffset).getUint32(252, true)) {
    throw new Error('the checksum of the second boot stage is wrong: the chip would not start');
  }
  chip.sram.set(stage2, STAGE_2_AT - 0x20000000);
  chip.core.SP = STAGE_2_AT;
  chip.core.LR = 0;
  chip.core.PC = STAGE_2_AT;
}

/// CRC-32 with the most significant bit first, from all ones, not inverted (2.8.1.3.1).
function checksum(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte << 24;
    for (let bit = 0; bit < 8; bit++) {
      crc = crc < 0 ? (crc << 1) ^ 0x04c11db7 : crc << 1;
    }
  }
  return crc >>> 0;
}
