// Faults of sensor, bus, line, chip and flash at random moments: each is recovered from within a stated time.

import { writeFileSync } from 'node:fs';

import { Board, STORE } from './board.js';
import { flashImage } from './elf.js';
import { CODES, codes, folder, fos, imageFrame } from './host.js';
import { update } from './loop.js';
import { Fault, Part } from './part.js';
import { decode } from './telemetry.js';

/// Rows of the log that the model is fitted to, at most half of them; later temperatures are out of its range.
const FITTED = 55000;

/// Samples without a flag that show a recovery: 0.5 s.
const CLEAN = 100;

/// An instruction that jumps to itself; the firmware's handler of unexpected exceptions has one.
const HANG = 0xe7fe;

/// Ticks miscounted after a sensor was absent for 1 s: one because it samples at other instants, and one because the time of its
/// first sample is known to a sample. One in a hundred moments costs both.
const AGAIN = 2;

/** Faults: name; how it begins and ends; how long it lasts, s; recovered within so many seconds after its end; at most so many
 *  ticks without a sample, and wrong by at most so many ticks; or `restart` if the chip starts again and its ticks with it. A part that
 *  is set up again samples at other instants, which is the one tick that every fault may cost. */
function kinds(images, random) {
  const part = (fault, value) => ({
    begin: (board) => board.part.fault(board.nanos, fault, value),
    end: (board) => board.part.fault(board.nanos, Fault.none, 0),
  });
  const line = (bytes) => ({ begin: (board) => board.receive(bytes()) });
  /// Something that happens once, in the middle of a long burst.
  const glitch = (what) => ({
    begin: (board) => {
      board.miso = (byte) => {
        if (board.burst === 40) {
          what(board);
          board.miso = (byte) => byte;
        }
        return byte;
      };
    },
  });
  const noise = (count) => Array.from({ length: count }, () => Math.floor(256 * random()));
  const frame = () => [0, ...imageFrame(images.model)];
  const restarts = (begin) => ({ begin, restart: true });
  const spoil = (board, from, to) => board.flash.bytes.subarray(from, to).set(noise(to - from));
  const middle = (STORE.start + STORE.end) / 2;
  return [
    ['a transfer is not answered', part(Fault.nack, 1), 0, 0.1, 0],
    ['no transfer is answered', part(Fault.unanswered, 1e9), 1, 2.5, 450, AGAIN],
    ['data line high', part(Fault.stuckHigh, 1), 1, 2.5, 450, AGAIN],
    ['data line low', part(Fault.stuckLow, 1), 1, 2.5, 450, AGAIN],
    ['data line shorted to the other', {
      begin: (board) => (board.miso = (_, mosi) => mosi),
      end: (board) => (board.miso = (byte) => byte),
    }, 1, 2.5, 450, AGAIN],
    ['a burst ends early', part(Fault.cut, 20), 0, 1.5, 32],
    ['a bit in 2000 bytes flips', part(Fault.flip, 2000), 1, 2.5, 100],
    ['chip select rises within a burst', glitch((board) => board.part.deselect()), 0, 1.5, 32],
    ['the part sees eight clock pulses too many', glitch((board) => board.part.exchange(0)), 0, 2.5, 250, 128],
    ['another part answers', part(Fault.identity, 0x24), 1, 0.1, 0],
    ['the part resets itself', part(Fault.reset, 1), 0, 1.5, 60],
    ['the part resets itself and answers as another for 1 s', {
      begin: (board) => {
        board.part.fault(board.nanos, Fault.identity, 0x24);
        board.part.fault(board.nanos, Fault.reset, 1);
      },
      end: part().end,
    }, 1, 2.5, 450, AGAIN],
    ['the part resets itself and holds no register for 1 s', {
      begin: (board) => {
        board.part.fault(board.nanos, Fault.forgetful, 1);
        board.part.fault(board.nanos, Fault.reset, 1);
      },
      end: part().end,
    }, 1, 2.5, 450, AGAIN],
    ['codes stand still', part(Fault.frozen, 1), 1, 1.5, 200],
    ['no temperature', part(Fault.noTemperature, 1), 1, 0.15, 0],
    ['FIFO stays empty', part(Fault.silent, 1), 1, 2, 300, 5],
    ['FIFO runs over', part(Fault.overrun, 1), 0, 1.5, 20],
    ['clock of the part 3 % fast', part(Fault.ppm, 30000), 5, 0.1, 0],
    ['clock of the part drifts by 0.2 %/s', part(Fault.drift, 2000), 10, 0.1, 0],
    ['the chip stands still for 1 s', { begin: (board) => board.pause(1) }, 0, 1.5, 130],
    ['noise on the line to the chip', line(() => noise(500)), 0, 0.1, 0],
    ['framing errors and breaks on the line', line(() => noise(200).map((byte) => byte | 0x500)), 0, 0.1, 0],
    ['a flood on the line, longer than every buffer', line(() => noise(90000).map((byte) => byte || 1)), 1, 0.1, 0],
    ['an image with a changed bit', line(() => frame().map((byte, at) => (at === 50 ? byte ^ 4 : byte))), 0, 0.1, 0],
    ['an image that breaks off', line(() => frame().slice(0, 200)), 0, 0.1, 0],
    ['a frame that holds no image', line(() => [0, ...imageFrame(images.none)]), 0, 1.5, 0],
    ['an image that the hub refuses', line(() => [0, ...imageFrame(images.foreign)]), 0, 1.5, 0],
    ['an update', line(frame), 0, 1.5, 0],
    ['code hangs with interrupts off', restarts((board) => {
      const at = board.translation.code.indexOf(HANG);
      board.chip.core.PC = 0x10000000 + 2 * at;
      board.chip.core.PM = true;
      board.chip.core.waiting = false;
    }), 2.1, 2, 0],
    ['power of the chip fails', restarts((board) => board.switchOn()), 0, 2, 0],
    ['power fails while an image is stored', restarts((board) => {
      board.receive(frame());
      board.run(0.006 + 0.003 * random());
      board.switchOn();
    }), 0, 2, 0],
    ['the slot in use is spoilt, and power fails', restarts((board) => {
      const half = random() < 0.5;
      spoil(board, half ? STORE.start : middle, half ? middle : STORE.end);
      board.switchOn();
    }), 0, 2, 0],
    ['both slots are spoilt, and power fails; an update', restarts((board) => {
      spoil(board, STORE.start, STORE.end);
      board.switchOn();
      board.run(0.5);
      board.receive(frame());
    }), 0, 3, 0],
  ].map(([name, how, seconds, within, lost, miscounted = 1]) => ({ name, seconds, within, lost, miscounted, end: () => {}, ...how }));
}

/** A seeded generator of numbers in [0, 1) (mulberry32). */
export function generator(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let value = Math.imul(state ^ (state >>> 15), 1 | state);
    value = (value + Math.imul(value ^ (value >>> 7), 61 | value)) ^ value;
    return ((value ^ (value >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** Tick of the part at which a sample was taken: that of the latest row with its codes. */
function tickOfPart(board, { measured }) {
  const recent = board.part.delivered(Math.max(0, board.rows - 2000));
  board.rows = Math.max(0, board.rows - 2000) + recent.length;
  const codes = measured.map((value, axis) => Math.round(value / CODES[axis]));
  const row = recent.findLast((row) => codes.every((code, axis) => row[1 + axis] === code));
  if (!row) {
    throw new Error('a sample has codes that the part did not deliver');
  }
  return row[0];
}

/** Lets one fault happen; returns what it did. */
function happen(board, kind, random) {
  board.run(random());
  board.run(0.2);
  const whole = board.sent.lastIndexOf(0) + 1;
  const before = decode(board.sent.slice(0, whole)).samples.at(-1);
  const offset = before.tick - tickOfPart(board, before);
  board.sent = board.sent.slice(whole);
  kind.begin(board);
  board.run(kind.seconds);
  kind.end(board);
  const ended = board.nanos;
  const heard = [];
  let clean = 0;
  let recovered = null;
  let last = kind.restart ? null : before.tick;
  let lost = 0;
  let damaged = 0;
  const look = () => {
    const end = board.sent.lastIndexOf(0) + 1;
    const decoded = decode(board.sent.slice(0, end));
    board.sent = board.sent.slice(end);
    damaged += decoded.damaged;
    for (const sample of decoded.samples) {
      const next = last !== null && sample.tick === last + 1;
      if (last !== null && sample.tick > last) {
        lost += sample.tick - last - 1;
      }
      last = sample.tick;
      heard.push(sample);
      const fine = next && sample.validity.every((flags) => flags === 0);
      if (!fine || clean === 0) {
        recovered = board.nanos;
      }
      clean = fine ? clean + 1 : 0;
    }
  };
  while (clean < CLEAN && board.nanos - ended < 20e9) {
    board.run(0.05);
    look();
  }
  if (clean < CLEAN) {
    throw new Error(`${kind.name}: not recovered within 20 s`);
  }
  const after = heard.at(-1);
  const miscounted = kind.restart ? 0 : after.tick - tickOfPart(board, after) - offset;
  return { seconds: Math.max(0, recovered - ended) / 1e9, lost: kind.restart ? 0 : lost, damaged, miscounted };
}

export function faults(moments = '2', seed = '1', only = '') {
  const at = folder();
  const random = generator(Number(seed));
  const { images, played } = prepare(at);
  const board = new Board(flashImage(process.env.FOS_FIRMWARE), new Part('bmi323', played));
  board.rows = 0;
  update(board, images.model);
  update(board, images.model);
  board.run(5);
  let failed = false;
  console.log('| fault | lasts, s | valid again after, s | ticks without a sample | damaged frames | ticks miscounted |\n|---|---|---|---|---|---|');
  for (const kind of kinds(images, random).filter(({ name }) => name.includes(only))) {
    const worst = { seconds: 0, lost: 0, damaged: 0, miscounted: 0 };
    for (let moment = 0; moment < Number(moments); moment++) {
      const found = happen(board, kind, random);
      for (const [name, value] of Object.entries(found)) {
        worst[name] = Math.max(worst[name], Math.abs(value));
      }
      board.run(4 * random());
    }
    const met = worst.seconds <= kind.within && worst.lost <= kind.lost && worst.miscounted <= kind.miscounted;
    failed ||= !met;
    const lost = kind.restart ? 'counts from 0' : `${worst.lost} (${kind.lost})`;
    const cells = [kind.name, kind.seconds || '–', `${worst.seconds.toFixed(2)} (${kind.within})`, lost, worst.damaged, `${worst.miscounted} (${kind.miscounted})`];
    console.log(`| ${cells.join(' | ')} |${met ? '' : ' MISSED'}`);
  }
  if (failed) {
    throw new Error('a fault took longer than stated, or cost more samples');
  }
}

/** Images: one that the hub runs, one for another sampling rate, and bytes that are none; and the codes of the first. */
function prepare(at) {
  const image = (name, rate) => {
    const log = at(`${name}.parquet`);
    fos('simulate', log, '--minutes', '10', '--rate', rate, '--seed', '3', '--at-rest');
    fos('fit', log, '--axis', 'all', '--degree', '2', '--memory', 'none', '--input', 'temp_c', '-o', at(`${name}.json`));
    fos('export', at(`${name}.json`), '--image', at(name));
    return at(name);
  };
  const images = { model: image('model', '200'), foreign: image('foreign', '100'), none: at('none') };
  writeFileSync(images.none, 'no image');
  return { images, played: codes(at('model.parquet'), at('model.csv'), FITTED) };
}
