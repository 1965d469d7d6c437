// A hidden effect: firmware sends a log of it, `fos` finds it, the grown model goes back over the line, and the bias is gone.

import { writeFileSync } from 'node:fs';

import { Board } from './board.js';
import { flashImage } from './elf.js';
import { codes, columns, compareBits, expectedTelemetry, folder, fos, imageFrame } from './host.js';
import { Part } from './part.js';

const RATE_HZ = 200;

/** Sends an image and waits for the flash to hold it. */
export function update(board, image) {
  // the chip may have been switched on just now
  board.run(0.3 - Math.min(0.3, board.chip.clock.nanos / 1e9));
  const { changes } = board.flash;
  board.receive([0, ...imageFrame(image)]);
  board.run(2, () => board.flash.changes > changes);
  if (board.flash.changes === changes) {
    throw new Error('the image was not stored');
  }
  board.run(0.2);
}

/** RMS of the means over 1 s, about their mean. */
function slow(values) {
  const means = [];
  for (let at = 0; at + RATE_HZ <= values.length; at += RATE_HZ) {
    const second = values.slice(at, at + RATE_HZ).filter((value) => !Number.isNaN(value));
    if (second.length > 0) {
      means.push(second.reduce((sum, value) => sum + value, 0) / second.length);
    }
  }
  const mean = means.reduce((sum, value) => sum + value, 0) / means.length;
  return Math.sqrt(means.reduce((sum, value) => sum + (value - mean) ** 2, 0) / means.length);
}

export function loop(minutes = '8') {
  const at = folder();
  const [log, evaluation] = [Number(minutes), Number(minutes) / 2];
  fos('simulate', '--case', at('case'), '--effect', 'thermal_lag:tau_s=60', '--size', '120', '--seed', '8');
  const reference = at('case/reference.parquet');
  fos('fit', reference, '--axis', 'gx', '-o', at('study.json'));
  fos('export', at('study.json'), '--image', at('first.fosm'));
  const rows = (of) => Math.round(of * 60 * RATE_HZ);
  const explain = codes(at('case/log.parquet'), at('log.csv'), rows(log));
  const later = codes(at('case/evaluation.parquet'), at('evaluation.csv'), rows(evaluation));
  const played = new Int16Array(explain.length + 2 * later.length);
  played.set(explain);
  played.set(later, explain.length);
  played.set(later, explain.length + later.length);

  const part = new Part('bmi323', played);
  const board = new Board(flashImage(process.env.FOS_FIRMWARE), part);
  /// Runs until the part has played so many rows.
  const play = (until) => board.run(Infinity, () => part.tick() >= until);
  /// Restarts the chip; from here on the samples are those of one hub with one image.
  const restart = () => {
    board.switchOn();
    board.sent = [];
    return part.delivered().length;
  };
  const check = (image, from) => {
    const expected = expectedTelemetry(image, part.delivered(from), at('codes'));
    console.log(`${compareBits(board.sent, expected)} bytes of telemetry as the host computes them`);
  };
  const recorded = (name) => {
    writeFileSync(at(`${name}.stream`), Uint8Array.from(board.sent));
    process.stdout.write(fos('record', at(`${name}.stream`), '-o', at(`${name}.parquet`)).split('\n')[0] + '\n');
    return at(`${name}.parquet`);
  };

  update(board, at('first.fosm'));
  let from = restart();
  play(rows(log));
  check(at('first.fosm'), from);
  const explained = recorded('explained');
  const answer = fos('diagnose', explained, '--reference', reference, '--axis', 'gx');
  process.stdout.write(answer.split('\n')[0] + '\n');
  if (!answer.startsWith('gx_rads: Most likely missing: thermal lag')) {
    throw new Error('the hidden effect is not named');
  }
  board.sent = [];
  play(rows(log + evaluation));
  const before = recorded('before');

  process.stdout.write(fos('add', at('study.json'), 'thermal_lag', '--from', explained, '--reference', reference, '--evaluate-on', before));
  fos('export', at('study.json'), '--image', at('grown.fosm'));
  update(board, at('grown.fosm'));
  from = restart();
  play(rows(log + 2 * evaluation));
  check(at('grown.fosm'), from);
  const after = recorded('after');

  const of = (file) => slow(columns(file, `${file}.csv`)('innovation_gx_rads')) * 206264.8;
  const [was, is] = [of(before), of(after)];
  console.log(`RMS of the 1-s means of the innovations: ${was.toFixed(1)} °/h with the first image, ${is.toFixed(1)} °/h with the grown one (−${(100 - (100 * is) / was).toFixed(0)} %)`);
  if (!(is < 0.8 * was)) {
    throw new Error('the bias is not gone');
  }
}
