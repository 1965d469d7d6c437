// The translated code against the emulator's own processor: the same state after every millisecond.

import { Board } from './board.js';
import { flashImage } from './elf.js';
import { Part } from './part.js';

export function core(seconds = '2') {
  const boards = [true, false].map((translates) => {
    const board = new Board(flashImage(process.env.FOS_FIRMWARE), new Part('bmi323'));
    board.translates = translates;
    return board;
  });
  const state = ({ chip }) => JSON.stringify([
    [...chip.core.registers.subarray(0, 15)], chip.core.PC & ~1, chip.core.cycles, chip.core.N, chip.core.Z, chip.core.waiting, Math.round(chip.clock.nanos),
  ]);
  for (let millisecond = 1; millisecond <= Number(seconds) * 1000; millisecond++) {
    boards.forEach((board) => board.step(millisecond * 1e6));
    const [translated, own] = boards.map(state);
    if (translated !== own || Buffer.compare(boards[0].chip.sram, boards[1].chip.sram) !== 0) {
      throw new Error(`after ${millisecond} ms the translated code differs:\n${translated}\n${own}`);
    }
  }
  console.log(`translated code and the emulator's processor agree for ${seconds} s`);
}
