// A board: the emulated chip with its flash, a sensor on its SPI bus, and a serial line.

import { RP2040 } from 'rp2040js';

import { ERASE, Flash } from './flash.js';
import { boot } from './rom.js';
import { Translation, memoryOf } from './translate.js';
import { modelUart } from './uart.js';

/// Pins of the firmware (fos-embedded/examples/rp2040).
const SELECT = 17;
const COMPUTING = 15;

const FLASH_BYTES = 2 * 1024 * 1024;
/// Sectors of the model images, as in the firmware.
export const STORE = { start: FLASH_BYTES - 4 * ERASE, end: FLASH_BYTES };

export class Board {
  /**
   * @param {Uint8Array} image contents of the flash from its start
   * @param {object} part the sensor: `select(nanos, mode)`, `exchange(byte) → byte`, `deselect()`
   */
  constructor(image, part) {
    const bytes = new Uint8Array(FLASH_BYTES).fill(0xff);
    bytes.set(image);
    this.translation = Translation.of(image);
    this.flash = new Flash(bytes);
    this.part = part;
    /// Time at which the chip was switched on, ns; the sensor's time does not start again with the chip.
    this.epoch = 0;
    /// Bytes that the chip sent.
    this.sent = [];
    /// Cycles of every sample: GPIO15 was high.
    this.perSample = [];
    /// Bytes since the chip select fell.
    this.burst = 0;
    /// Resets by the watchdog.
    this.resets = 0;
    this.translates = true;
    /// Called around every change of the flash, as `(change) => change()`.
    this.aroundFlash = (change) => change();
    this.switchOn();
  }

  /** Time since the board was made, ns. */
  get nanos() {
    return this.epoch + this.chip.clock.nanos;
  }

  /** Starts the chip; the flash and the sensor go on as they are. */
  switchOn() {
    this.epoch = this.chip ? this.nanos : 0;
    const chip = new RP2040();
    this.chip = chip;
    chip.logger = logger(chip);
    chip.flash.set(this.flash.bytes);
    // from here on the chip's own, so that reads of it need no way around
    this.flash.bytes = chip.flash.subarray(0, FLASH_BYTES);
    this.memory = memoryOf(chip);
    this.xipOn = true;
    boot(this);
    this.connectSensor();
    const [uart] = chip.uart;
    this.receive = modelUart(uart, chip.clock, (byte) => this.onByte(byte));
    let rise = 0;
    chip.gpio[COMPUTING].addListener((level) => {
      if (level === 1) {
        rise = chip.core.cycles;
      } else if (rise > 0) {
        this.perSample.push(chip.core.cycles - rise);
      }
    });
    const ssi = chip.peripherals[0x18000];
    const write = ssi.writeUint32.bind(ssi);
    ssi.writeUint32 = (offset, value) => {
      // its enable register: the second boot stage switches execution from flash on
      if (offset === 8) {
        this.xip((value & 1) !== 0);
      }
      write(offset, value);
    };
    // XIP_CTRL, which the emulator lacks: no stream from flash is under way
    chip.peripherals[0x14000] = { readUint32: () => 0, writeUint32Atomic() {} };
    const watchdog = chip.peripherals[0x40058];
    watchdog.onWatchdogTrigger = () => {
      this.watchdogBit = true;
      // once: the emulator's would go off again at the same time, for ever
      watchdog.alarm.enable = false;
    };
  }

  connectSensor() {
    const { chip, part } = this;
    const [spi] = chip.spi;
    let answer = 0;
    const done = chip.clock.createAlarm(() => spi.completeTransmit(answer));
    spi.onTransmit = (byte) => {
      this.burst++;
      answer = this.miso(part.exchange(byte), byte);
      done.schedule(8e9 / spi.clockFrequency);
    };
    chip.gpio[SELECT].addListener((level) => {
      if (level === 0) {
        this.burst = 0;
        part.select(this.nanos, spi.spiMode);
      } else {
        part.deselect();
      }
    });
  }

  /** A byte as it arrives from the sensor, while the chip sends `mosi`. */
  miso(byte) {
    return byte;
  }

  onByte(byte) {
    this.sent.push(byte);
  }

  /** Lets time pass while the processor stands still. */
  pause(seconds) {
    this.chip.clock.tick(seconds * 1e9);
  }

  /** Runs for `seconds`, or until `done()`; the chip sleeps from event to event. */
  run(seconds, done = () => false) {
    const end = this.nanos + seconds * 1e9;
    while (this.nanos < end && !done()) {
      // `done` is looked at once in a millisecond
      this.step(Math.min(end, this.nanos + 1e6));
    }
  }

  /** Runs up to a time, ns. */
  step(end) {
    const { chip, memory, translation } = this;
    const { core, clock } = chip;
    const until = end - this.epoch;
    while (clock.nanosCounter < until) {
      const event = clock.nextAlarm !== null && clock.nextAlarm.nanos < until ? clock.nextAlarm.nanos : until;
      if (core.waiting) {
        clock.tick(event - clock.nanosCounter);
      } else {
        const nanos = 1e9 / chip.clkSys;
        if (this.translates && this.xipOn && !core.interruptsUpdated) {
          const spent = translation.run(memory, core, (event - clock.nanosCounter) / nanos);
          core.cycles += spent;
          clock.nanosCounter += spent * nanos;
        }
        if (!this.xipOn && core.PC >>> 24 === 0x10) {
          throw new Error(`code in flash runs while the flash is busy: 0x${core.PC.toString(16)}`);
        }
        clock.nanosCounter += core.executeInstruction() * nanos;
        if (clock.nextAlarm !== null && clock.nextAlarm.nanos <= clock.nanosCounter) {
          clock.tick(0);
        }
      }
      if (this.watchdogBit) {
        this.watchdogBit = false;
        this.resets++;
        return this.switchOn();
      }
    }
  }

  // what the ROM needs

  connected() {}

  xip(on) {
    this.xipOn = on;
  }

  ram(at, bytes) {
    return this.chip.sram.subarray(at - 0x20000000, at - 0x20000000 + bytes);
  }

  copy(to, from, bytes) {
    for (let index = 0; index < bytes; index++) {
      this.chip.writeUint8(to + index, this.chip.readUint8(from + index));
    }
    this.chip.core.registers[0] = to;
  }

  flashStep(change, seconds) {
    if (this.xipOn) {
      throw new Error('the flash is changed while code may run from it');
    }
    this.aroundFlash(change);
    this.chip.clock.tick(seconds * 1e9);
  }
}

/** What the emulator reports of a chip: errors end the run; the instruction SEV, which it only reports, sets the event. */
function logger(chip) {
  return {
    debug() {},
    warn() {},
    info(_, message) {
      if (message === 'SEV') {
        chip.core.eventRegistered = true;
      }
    },
    error(name, message) {
      throw new Error(`${name}: ${message}`);
    },
  };
}
