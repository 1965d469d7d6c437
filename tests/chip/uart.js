// The chip's UART (an Arm PL011) with its two FIFOs of 32 bytes, at the speed of its line; the emulator's own sends at once and
// its interrupt never ends. RP2040 data sheet, 4.2.

const [DR, RSR, FR, IBRD, FBRD, LCR_H, CR, IFLS, IMSC, RIS, MIS, ICR, DMACR] = [
  0x00, 0x04, 0x18, 0x24, 0x28, 0x2c, 0x30, 0x34, 0x38, 0x3c, 0x40, 0x44, 0x48,
];
const DEPTH = 32;
/// Fill levels at which the FIFOs interrupt, by the field of IFLS.
const LEVELS = [4, 8, 16, 24, 28];
const TX = 1 << 5;
const RX = 1 << 4;
const RX_TIMEOUT = 1 << 6;
const OVERRUN = 1 << 11;
/// A start bit, eight of data, a stop bit.
const BITS = 10;

/** Replaces the registers of `uart`; bytes sent go to `onByte`. Returns a function that puts bytes on the line to the chip. */
export function modelUart(uart, clock, onByte) {
  const registers = { [IBRD]: 0, [FBRD]: 0, [LCR_H]: 0, [CR]: 0x300, [IFLS]: 0x12, [IMSC]: 0, [DMACR]: 0 };
  const sending = [];
  const received = [];
  const arriving = [];
  let raw = 0;
  let overrun = false;
  let busy = false;

  const bitNanos = () =>
    (16e9 * (registers[IBRD] + registers[FBRD] / 64)) / uart.rp2040.clkPeri;
  const enabled = () => (registers[CR] & 1) !== 0;
  const interrupt = () => uart.rp2040.setInterrupt(uart.irq, (raw & registers[IMSC]) !== 0);

  const shift = clock.createAlarm(() => {
    const byte = sending.shift();
    busy = sending.length > 0;
    if (sending.length === LEVELS[registers[IFLS] & 7]) {
      raw |= TX;
      interrupt();
    }
    if (busy) {
      shift.schedule(BITS * bitNanos());
    }
    onByte(byte);
  });
  const timeout = clock.createAlarm(() => {
    if (received.length > 0) {
      raw |= RX_TIMEOUT;
      interrupt();
    }
  });
  const arrive = clock.createAlarm(() => {
    const value = arriving.shift();
    if (arriving.length > 0) {
      arrive.schedule(BITS * bitNanos());
    }
    if (!enabled()) {
      return;
    }
    if (received.length === DEPTH) {
      overrun = true;
      return;
    }
    received.push(value | (overrun ? OVERRUN : 0));
    overrun = false;
    if (received.length >= LEVELS[(registers[IFLS] >> 3) & 7]) {
      raw |= RX;
      interrupt();
    }
    timeout.schedule(32 * bitNanos());
  });

  uart.readUint32 = (offset) => {
    switch (offset) {
      case DR: {
        const value = received.shift() ?? 0;
        if (received.length < LEVELS[(registers[IFLS] >> 3) & 7]) {
          raw &= ~RX;
        }
        if (received.length === 0) {
          raw &= ~RX_TIMEOUT;
        }
        interrupt();
        return value;
      }
      case RSR:
        return 0;
      case FR:
        return (
          (busy ? 1 << 3 : 0) |
          (received.length === 0 ? 1 << 4 : 0) |
          (sending.length >= DEPTH ? 1 << 5 : 0) |
          (received.length === DEPTH ? 1 << 6 : 0) |
          (sending.length === 0 ? 1 << 7 : 0)
        );
      case RIS:
        return raw;
      case MIS:
        return raw & registers[IMSC];
      default:
        if (offset in registers) {
          return registers[offset];
        }
        throw new Error(`UART: read of register 0x${offset.toString(16)}`);
    }
  };
  uart.writeUint32 = (offset, value) => {
    switch (offset) {
      case DR:
        if (enabled() && sending.length < DEPTH) {
          sending.push(value & 0xff);
          if (!busy) {
            busy = true;
            shift.schedule(BITS * bitNanos());
          }
        }
        break;
      case RSR:
        break;
      case ICR:
        // as written, not combined with what is read
        raw &= ~uart.rawWriteValue;
        interrupt();
        break;
      default:
        if (!(offset in registers)) {
          throw new Error(`UART: write of register 0x${offset.toString(16)}`);
        }
        registers[offset] = value;
        interrupt();
    }
  };
  return (values) => {
    const idle = arriving.length === 0;
    for (const value of values) {
      arriving.push(value);
    }
    if (idle && arriving.length > 0) {
      arrive.schedule(BITS * bitNanos());
    }
  };
}
