// Power fails while an image is stored: the chip restarts with the image before or with the new one. The flash changes only when
// a sector is erased or a page programmed, so these states, and those of a change that power interrupts, are all that there are.

import { Board, STORE } from './board.js';
import { flashImage } from './elf.js';
import { codes, folder, fos } from './host.js';
import { generator } from './faults.js';
import { update } from './loop.js';
import { Part } from './part.js';
import { decode } from './telemetry.js';

/// Bit of a validity: the axis has no model.
const NOT_MODELLED = 1024;

/** Starts the chip with this content of the store, and returns the axes that its model has. */
function modelAfterStart(board, store) {
  board.flash.bytes.set(store, STORE.start);
  board.switchOn();
  board.sent = [];
  const whole = () => decode(board.sent.slice(0, board.sent.lastIndexOf(0) + 1)).samples;
  board.run(5, () => board.sent.length > 1000);
  const [sample] = whole();
  if (!sample) {
    throw new Error('the chip does not start');
  }
  return sample.validity.flatMap((flags, axis) => (flags & NOT_MODELLED ? [] : ['ax', 'ay', 'az', 'gx', 'gy', 'gz'][axis])).join();
}

/** A change of flash that power interrupts: some of its bits have changed. */
function torn(before, after, random, index) {
  const state = before.slice();
  const changed = before.flatMap((byte, at) => (byte === after[at] ? [] : [at]));
  // in turn: the first bytes and some bits of the next; any bits, few to many
  const share = (index + 1) / 9;
  const reached = changed[Math.floor(random() * changed.length)];
  for (const at of changed) {
    let mask = 0;
    for (let bit = 0; bit < 8; bit++) {
      mask |= Number(random() < share) << bit;
    }
    if (index % 2 === 0) {
      mask = at < reached ? 0xff : at === reached ? mask : 0;
    }
    state[at] = before[at] ^ (mask & (before[at] ^ after[at]));
  }
  return state;
}

export function power(variants = '8', seed = '1') {
  const at = folder();
  const random = generator(Number(seed));
  fos('simulate', at('log.parquet'), '--minutes', '10', '--seed', '3', '--at-rest');
  const [old, fresh] = ['gx', 'gy'].map((axis) => {
    fos('fit', at('log.parquet'), '--axis', axis, '-o', at(`${axis}.json`));
    fos('export', at(`${axis}.json`), '--image', at(axis));
    return at(axis);
  });
  const board = new Board(flashImage(process.env.FOS_FIRMWARE), new Part('bmi323', codes(at('log.parquet'), at('log.csv'))));
  const store = () => [...board.flash.bytes.subarray(STORE.start, STORE.end)];
  let changes = [];
  board.aroundFlash = (change) => {
    const before = store();
    change();
    changes.push({ before, after: store(), cycles: board.chip.core.cycles });
  };
  // updates until one erases a sector: the longest there is
  const isErase = ({ before, after }) => after.some((byte, index) => byte & ~before[index]);
  for (let count = 0; !changes.some(isErase) || count % 2 !== 0; count++) {
    changes = [];
    update(board, count % 2 === 0 ? old : fresh);
    if (count > 100) {
      throw new Error('no update erases a sector');
    }
  }
  const cycles = changes.at(-1).cycles - changes[0].cycles;
  console.log(`${changes.length} changes of flash in ${cycles} cycles, ${changes.filter(isErase).length} of them erase a sector`);

  const found = {};
  let states = 0;
  let repaired = 0;
  board.aroundFlash = (change) => {
    repaired++;
    change();
  };
  const start = (state, place) => {
    states++;
    const model = modelAfterStart(board, state);
    found[model] = (found[model] ?? 0) + 1;
    if (model !== 'gx' && model !== 'gy') {
      throw new Error(`${place}: the chip starts with ${model || 'no model'}`);
    }
    return model;
  };
  changes.forEach(({ before, after }, index) => {
    start(before, `before change ${index}`);
    for (let variant = 0; variant < Number(variants); variant++) {
      start(torn(before, after, random, variant), `within change ${index}`);
    }
    // the torn state is no obstacle to the next update
    update(board, fresh);
    if (start(Uint8Array.from(store()), `after an update after change ${index}`) !== 'gy') {
      throw new Error(`change ${index} interrupted: the next update is lost`);
    }
  });
  const last = start(changes.at(-1).after, 'after the last change');
  console.log(`${states} starts: ${Object.entries(found).map(([model, count]) => `${count} with the model of ${model}`).join(', ')}`);
  console.log(`they and the updates between changed the flash ${repaired} times; after the last change the model is that of ${last}`);
}
