// Programs on the host, and files between them and the board.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { READ } from './part.js';

/// Scales of the codes that a part plays (tests/parts): ±4 g, ±500 °/s, 1/512 K from 23 °C.
const ACCEL_MPS2 = (4 / 32768) * 9.80665;
const GYRO_RADS = ((500 / 32768) * Math.PI) / 180;
export const CODES = [ACCEL_MPS2, ACCEL_MPS2, ACCEL_MPS2, GYRO_RADS, GYRO_RADS, GYRO_RADS, 1 / 512];
const COLUMNS = ['ax_mps2', 'ay_mps2', 'az_mps2', 'gx_rads', 'gy_rads', 'gz_rads', 'temp_c'];
const ZERO_C = 23;

/** A folder for files, removed at the end of the program. */
export function folder() {
  const path = mkdtempSync(join(tmpdir(), 'fos-chip-'));
  process.on('exit', () => rmSync(path, { recursive: true }));
  return (name) => join(path, name);
}

/** Runs `fos` and returns what it prints. */
export function fos(...options) {
  return execFileSync(process.env.FOS_HOST_FIT, options, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });
}

/** Columns of a log, of any format that `fos` reads. */
export function columns(log, file) {
  fos('convert', log, '-o', file);
  const [header, ...rows] = readFileSync(file, 'utf8').trimEnd().split('\n');
  const names = header.split(',');
  const values = rows.map((row) => row.split(','));
  return (name) => {
    const at = names.indexOf(name);
    return Float64Array.from(values, (row) => (row[at] === '' ? NaN : Number(row[at])));
  };
}

/** The first `rows` rows of a log as codes for a part. */
export function codes(log, file, rows = Infinity) {
  const column = columns(log, file);
  const axes = COLUMNS.map(column);
  const count = Math.min(rows, axes[0].length);
  const clip = (code) => Math.max(-32768, Math.min(32767, Math.round(code)));
  const all = new Int16Array(count * CODES.length);
  axes.forEach((values, axis) => {
    const zero = axis === 6 ? ZERO_C : 0;
    for (let row = 0; row < count; row++) {
      all[row * CODES.length + axis] = clip((values[row] - zero) / CODES[axis]);
    }
  });
  return all;
}

/** Telemetry that a hub on the host sends for rows that a part delivered, with a model image or `-`. */
export function expectedTelemetry(image, delivered, file) {
  const rows = delivered.filter((row) => row[8] === READ);
  const bytes = Buffer.alloc(rows.length * 18);
  rows.forEach((row, index) => {
    bytes.writeUInt32LE(index === 0 ? 0 : row[0] - rows[index - 1][0] - 1, index * 18);
    row.slice(1, 8).forEach((code, axis) => bytes.writeInt16LE(code, index * 18 + 4 + 2 * axis));
  });
  writeFileSync(file, bytes);
  execFileSync(process.env.FOS_FIRMWARE_TELEMETRY, ['rp2040', image, file, `${file}.telemetry`], { stdio: ['ignore', 'ignore', 'inherit'] });
  return readFileSync(`${file}.telemetry`);
}

/** Frame in which an image goes over the line. */
export function imageFrame(image) {
  return execFileSync(process.env.FOS_IMAGE_FRAME, [image]);
}

/** Fails unless the board sent what the host computes from the codes: the same bytes, as far as they have been sent. */
export function compareBits(sent, expected) {
  const differs = sent.findIndex((byte, index) => byte !== expected[index]);
  if (differs >= 0) {
    throw new Error(`byte ${differs} of ${sent.length} differs from what the host computes`);
  }
  // the last poll may still be on its way
  if (sent.length < expected.length - 32 * 100) {
    throw new Error(`${expected.length - sent.length} bytes were not sent`);
  }
  return sent.length;
}
