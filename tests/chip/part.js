// The sensor: a register model of fos-parts (tests/parts), behind its C interface.

import koffi from 'koffi';

/// Numbers of the faults (tests/parts/src/faults.rs).
export const Fault = {
  none: 0, nack: 1, stuckHigh: 2, stuckLow: 3, cut: 4, flip: 5, identity: 6, frozen: 7, noTemperature: 8, silent: 9,
  forgetful: 10, reset: 11, overrun: 12, ppm: 13, drift: 14, unanswered: 16,
};

/// Columns of a row of `delivered`: tick, six codes, temperature, and whether it was read.
const COLUMNS = 9;
export const READ = 1;

let library;

function load(path) {
  const parts = koffi.load(path);
  koffi.opaque('Part');
  return {
    new: parts.func('Part *parts_new(str name, uint8_t address, const int16_t *log, size_t rows)'),
    free: parts.func('void parts_free(Part *part)'),
    select: parts.func('void parts_spi_select(Part *part, uint8_t mode)'),
    exchange: parts.func('uint8_t parts_spi_exchange(Part *part, uint8_t byte)'),
    deselect: parts.func('void parts_spi_deselect(Part *part)'),
    advance: parts.func('void parts_advance_to(Part *part, uint64_t ns)'),
    fault: parts.func('bool parts_fault(Part *part, uint32_t fault, double value)'),
    delivered: parts.func('size_t parts_delivered(const Part *part, size_t from, _Out_ int32_t *rows, size_t capacity)'),
    tick: parts.func('uint64_t parts_tick(const Part *part)'),
  };
}

export class Part {
  /**
   * @param {string} name of the part
   * @param {Int16Array=} log rows of seven codes: accelerometers at ±4 g, gyros at ±500 °/s, temperature; generated if absent
   */
  constructor(name, log) {
    library ??= load(process.env.FOS_PARTS);
    this.part = library.new(name, 0x68, log ?? null, log ? log.length / 7 : 0);
    if (!this.part) {
      throw new Error(`there is no model of ${name}`);
    }
  }

  free() {
    library.free(this.part);
  }

  /** Selects the part at a time since power-on, ns, in an SPI mode. */
  select(nanos, mode) {
    library.advance(this.part, Math.round(nanos));
    library.select(this.part, mode);
  }

  exchange(byte) {
    return library.exchange(this.part, byte);
  }

  deselect() {
    library.deselect(this.part);
  }

  /** Begins a fault at a time, ns. */
  fault(nanos, fault, value) {
    library.advance(this.part, Math.round(nanos));
    if (!library.fault(this.part, fault, value)) {
      throw new Error(`there is no fault ${fault}`);
    }
  }

  tick() {
    return Number(library.tick(this.part));
  }

  /** Rows of codes that went into the FIFO, from row `from` on. */
  delivered(from = 0) {
    const rows = [];
    const chunk = new Int32Array(4096 * COLUMNS);
    for (;;) {
      const count = library.delivered(this.part, from + rows.length, chunk, 4096);
      for (let row = 0; row < count; row++) {
        rows.push(chunk.slice(row * COLUMNS, (row + 1) * COLUMNS));
      }
      if (count < 4096) {
        return rows;
      }
    }
  }
}
