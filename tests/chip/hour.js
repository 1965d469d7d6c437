// An hour of six axes: the same bits as on the host, and what a sample costs.

import { Board } from './board.js';
import { flashImage } from './elf.js';
import { codes, compareBits, expectedTelemetry, folder, fos } from './host.js';
import { update } from './loop.js';
import { Part } from './part.js';

export function hour(minutes = '60') {
  const at = folder();
  fos('simulate', at('log.parquet'), '--minutes', minutes, '--seed', '11');
  fos('fit', at('log.parquet'), '--axis', 'all', '--degree', '2', '--memory', 'none', '--input', 'temp_c', '-o', at('study.json'));
  fos('export', at('study.json'), '--image', at('image.fosm'));
  const part = new Part('bmi323', codes(at('log.parquet'), at('log.csv')));
  const board = new Board(flashImage(process.env.FOS_FIRMWARE), part);
  update(board, at('image.fosm'));
  board.switchOn();
  board.sent = [];
  board.perSample = [];
  const [from, began, start] = [part.delivered().length, board.nanos, Date.now()];
  const spent = process.cpuUsage();
  board.run(Number(minutes) * 60);
  const wall = (Date.now() - start) / 1000;
  const processor = process.cpuUsage(spent).user / 1e6;
  const expected = expectedTelemetry(at('image.fosm'), part.delivered(from), at('codes'));
  const bytes = compareBits(board.sent, expected);
  const cycles = board.perSample.sort((a, b) => a - b);
  const seconds = (board.nanos - began) / 1e9;
  console.log(`${cycles.length} samples in ${seconds.toFixed(0)} s; ${bytes} bytes of telemetry as the host computes them; ${wall.toFixed(0)} s of wall time, ${processor.toFixed(0)} s of processor time`);
  console.log(`cycles of a sample: median ${cycles[cycles.length >> 1]}, worst ${cycles.at(-1)}`);
  console.log(`awake ${((100 * board.chip.core.cycles) / (seconds * board.chip.clkSys)).toFixed(2)} % of the time at ${board.chip.clkSys / 1e6} MHz`);
}
