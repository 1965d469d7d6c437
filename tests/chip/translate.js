// Translates code in flash to JavaScript, so that an hour of samples takes minutes. The emulator's processor remains the
// reference: whatever is not plain arithmetic on RAM and flash is left to it, instruction by instruction, and so is each
// instruction near an event of the clock. `.ci/chip core` runs both side by side.

const FLASH = 0x10000000;
const FLASH_BYTES = 2 * 1024 * 1024;
const RAM = 0x20000000;
const RAM_BYTES = 264 * 1024;

/// Longest sequence that is translated as one function, and the number of times that it is run by the emulator before.
const LONGEST = 32;
const OFTEN = 1000;

const [SP, LR, PC] = [13, 14, 15];

/** A sequence of instructions being translated. */
class Sequence {
  constructor(start) {
    this.start = start;
    this.lines = [];
    this.cycles = 0;
    this.used = new Set();
    this.written = new Set();
    this.temporaries = 0;
    this.loops = false;
    // until an instruction sets them, the processor object holds the flags
    this.result = null;
    this.carry = null;
    this.overflow = null;
  }

  /** The local variable of a register. */
  read(register) {
    this.used.add(register);
    return `r${register}`;
  }

  write(register, value) {
    this.used.add(register);
    this.written.add(register);
    this.lines.push(`r${register}=${value};`);
  }

  temporary(value) {
    const name = `t${this.temporaries++}`;
    this.lines.push(`const ${name}=${value};`);
    return name;
  }

  /** N and Z of a result. */
  negativeZero(result) {
    this.result = result;
  }

  /** Expressions of the flags. */
  n() {
    return this.result ? `${this.result}<0` : 'core.N';
  }
  z() {
    return this.result ? `${this.result}===0` : 'core.Z';
  }
  c() {
    return this.carry ?? 'core.C';
  }
  v() {
    return this.overflow ?? 'core.V';
  }

  condition(code) {
    const all = [
      () => this.z(),
      () => this.c(),
      () => this.n(),
      () => this.v(),
      () => `${this.c()}&&!(${this.z()})`,
      () => `(${this.n()})===(${this.v()})`,
      () => `(${this.n()})===(${this.v()})&&!(${this.z()})`,
    ];
    const holds = all[code >> 1]();
    return code & 1 ? `!(${holds})` : holds;
  }

  flags() {
    // all are read before one is written
    const pairs = [];
    if (this.result) {
      pairs.push(`core.N=${this.n()};core.Z=${this.z()};`);
    }
    if (this.carry) {
      pairs.push(`core.C=${this.carry};`);
    }
    if (this.overflow) {
      pairs.push(`core.V=${this.overflow};`);
    }
    return pairs.join('');
  }

  /** Leaves the sequence; `@` stands for the registers that are written back. */
  leave(pc, cycles, interpret = false) {
    const total = `base+${cycles}`;
    return `{@${this.flags()}R[15]=${pc};return ${interpret ? `~(${total})` : total};}`;
  }
}

const signed = (value, bits) => (value << (32 - bits)) >> (32 - bits);

/** Adds an instruction; returns the address of the next one, or null at the end of the sequence. */
function add(to, at, opcode, opcode2) {
  const low = opcode & 7;
  const middle = (opcode >> 3) & 7;
  const high = (opcode >> 6) & 7;
  const top = (opcode >> 8) & 7;
  const imm5 = (opcode >> 6) & 31;
  const imm8 = opcode & 0xff;
  const next = at + 2;
  const interpret = () => {
    to.lines.push(to.leave(at, to.cycles, true));
    return null;
  };
  const bail = to.leave(at, to.cycles, true);
  const done = (cycles = 1, following = next) => {
    to.cycles += cycles;
    return following;
  };
  const logic = (register, value) => {
    const result = to.temporary(`(${value})|0`);
    to.write(register, result);
    to.negativeZero(result);
    return done();
  };
  const subtract = (register, left, right, borrow = null) => {
    const [a, b] = [to.temporary(left), to.temporary(right)];
    const carry = borrow && to.temporary(`(${borrow})?0:1`);
    const result = to.temporary(borrow ? `(${a}-${b}-${carry})|0` : `(${a}-${b})|0`);
    if (register !== null) {
      to.write(register, result);
    }
    to.negativeZero(result);
    to.carry = borrow ? `(${a}>>>0)>=(${b}>>>0)+${carry}` : `(${a}>>>0)>=(${b}>>>0)`;
    to.overflow = `((${a}^${b})&(${a}^${result}))<0`;
    return done();
  };
  const sum = (register, left, right, carryIn = null) => {
    const [a, b] = [to.temporary(left), to.temporary(right)];
    const carry = carryIn ? to.temporary(`(${carryIn})?1:0`) : '0';
    const result = to.temporary(`(${a}+${b}+${carry})|0`);
    if (register !== null) {
      to.write(register, result);
    }
    to.negativeZero(result);
    to.carry = `(${a}>>>0)+(${b}>>>0)+${carry}>4294967295`;
    to.overflow = `(~(${a}^${b})&(${a}^${result}))<0`;
    return done();
  };
  /// Shifts set the carry, which may be the one before.
  const shifted = (register, value, carry) => {
    const bit = carry === null ? to.carry : to.temporary(carry);
    const result = to.temporary(`(${value})|0`);
    to.write(register, result);
    to.negativeZero(result);
    to.carry = bit;
    return done();
  };
  const load = (register, address, bytes, extend = '') => {
    const a = to.temporary(`(${address})|0`);
    const index = bytes === 4 ? '>>2' : bytes === 2 ? '>>1' : '';
    const i = to.temporary(`(${a}-${RAM})>>>0`);
    const j = to.temporary(`(${a}-${FLASH})>>>0`);
    const width = 8 * bytes;
    to.used.add(register);
    to.written.add(register);
    to.lines.push(
      `if(${i}<${RAM_BYTES})r${register}=ram${width}[${i}${index}]${extend};` +
        `else if(${j}<${FLASH_BYTES})r${register}=flash${width}[${j}${index}]${extend};else ${bail}`,
    );
    return done(2);
  };
  const store = (register, address, bytes) => {
    const i = to.temporary(`((${address})-${RAM})>>>0`);
    const index = bytes === 4 ? '>>2' : bytes === 2 ? '>>1' : '';
    to.lines.push(`if(${i}<${RAM_BYTES})ram${8 * bytes}[${i}${index}]=${to.read(register)};else ${bail}`);
    return done(2);
  };
  const list = (mask) => [0, 1, 2, 3, 4, 5, 6, 7].filter((register) => mask & (1 << register));
  /// A place in RAM for so many words.
  const words = (address, count) => {
    const i = to.temporary(`((${address})-${RAM})>>>0`);
    to.lines.push(`if(${i}>${RAM_BYTES - 4 * count})${bail}`);
    return to.temporary(`${i}>>2`);
  };
  /// The sequence runs once more, as long as no event is due.
  const again = (taken, target) => {
    to.loops = true;
    to.lines.push(
      `if(${taken}){${to.flags()}base+=${to.cycles + 2};if(base<limit)continue;@R[15]=${target};return base;}`,
    );
  };
  const jump = (address, cycles) => {
    const target = to.temporary(address);
    to.lines.push(`if((${target}>>>28)===15)${bail}`);
    to.lines.push(to.leave(`${target}&~1`, to.cycles + cycles));
    return null;
  };

  switch (opcode >> 11) {
    case 0b00000:
      return imm5
        ? shifted(low, `${to.read(middle)}<<${imm5}`, `(${to.read(middle)}&${1 << (32 - imm5)})!==0`)
        : logic(low, to.read(middle));
    case 0b00001:
      return shifted(
        low,
        imm5 ? `${to.read(middle)}>>>${imm5}` : '0',
        `((${to.read(middle)}>>>${imm5 ? imm5 - 1 : 31})&1)!==0`,
      );
    case 0b00010:
      return shifted(
        low,
        `${to.read(middle)}>>${imm5 || 31}`,
        `((${to.read(middle)}>>>${imm5 ? imm5 - 1 : 31})&1)!==0`,
      );
    case 0b00011: {
      const operand = opcode & (1 << 10) ? `${high}` : to.read(high);
      return opcode & (1 << 9) ? subtract(low, to.read(middle), operand) : sum(low, to.read(middle), operand);
    }
    case 0b00100:
      return logic(top, `${imm8}`);
    case 0b00101:
      return subtract(null, to.read(top), `${imm8}`);
    case 0b00110:
      return sum(top, to.read(top), `${imm8}`);
    case 0b00111:
      return subtract(top, to.read(top), `${imm8}`);
    case 0b01000: {
      const [rm, rd] = [(opcode >> 3) & 15, (opcode & 7) | ((opcode >> 4) & 8)];
      const value = (register) => (register === PC ? `${at + 4}` : to.read(register));
      switch (opcode >> 8) {
        case 0b01000100:
          if (rd === PC) {
            return interpret();
          }
          to.write(rd, rd === SP ? `(r13+${value(rm)})&~3` : `(${value(rd)}+${value(rm)})|0`);
          return done();
        case 0b01000101:
          return subtract(null, value(rd), value(rm));
        case 0b01000110:
          if (rd === PC) {
            return jump(`${value(rm)}&~1`, 2);
          }
          to.write(rd, rd === SP ? `${value(rm)}&~3` : value(rm));
          return done();
        case 0b01000111:
          if (opcode & 7) {
            return interpret();
          }
          if (opcode & 0x80) {
            const target = to.temporary(value(rm));
            to.write(LR, `${(at + 2) | 1}`);
            to.lines.push(to.leave(`${target}&~1`, to.cycles + 2));
            return null;
          }
          return jump(value(rm), 2);
      }
      const [d, m] = [to.read(low), to.read(middle)];
      switch ((opcode >> 6) & 15) {
        case 0b0000:
          return logic(low, `${d}&${m}`);
        case 0b0001:
          return logic(low, `${d}^${m}`);
        case 0b0010: {
          const by = to.temporary(`${m}&255`);
          return shifted(low, `${by}<32?${d}<<${by}:0`, `${by}===0?${to.c()}:${by}>32?false:((${d}>>>(32-${by}))&1)!==0`);
        }
        case 0b0011: {
          const by = to.temporary(`${m}&255`);
          return shifted(low, `${by}<32?${d}>>>${by}:0`, `${by}===0?${to.c()}:${by}>32?false:((${d}>>>(${by}-1))&1)!==0`);
        }
        case 0b0100: {
          const by = to.temporary(`${m}&255`);
          return shifted(low, `${d}>>(${by}<32?${by}:31)`, `${by}===0?${to.c()}:((${d}>>(${by}<32?${by}-1:31))&1)!==0`);
        }
        case 0b0101:
          return sum(low, d, m, to.c());
        case 0b0110:
          return subtract(low, d, m, to.c());
        case 0b0111:
          return interpret();
        case 0b1000: {
          to.negativeZero(to.temporary(`${d}&${m}`));
          return done();
        }
        case 0b1001:
          return subtract(low, '0', m);
        case 0b1010:
          return subtract(null, d, m);
        case 0b1011:
          return sum(null, d, m);
        case 0b1100:
          return logic(low, `${d}|${m}`);
        case 0b1101:
          return logic(low, `Math.imul(${d},${m})`);
        case 0b1110:
          return logic(low, `${d}&~${m}`);
        default:
          return logic(low, `~${m}`);
      }
    }
    case 0b01001:
      return load(top, `${((at + 4) & ~3) + 4 * imm8}`, 4);
    case 0b01010:
    case 0b01011: {
      const address = `${to.read(middle)}+${to.read(high)}`;
      switch ((opcode >> 9) & 7) {
        case 0:
          return store(low, address, 4);
        case 1:
          return store(low, address, 2);
        case 2:
          return store(low, address, 1);
        case 3:
          return load(low, address, 1, '<<24>>24');
        case 4:
          return load(low, address, 4);
        case 5:
          return load(low, address, 2);
        case 6:
          return load(low, address, 1);
        default:
          return load(low, address, 2, '<<16>>16');
      }
    }
    case 0b01100:
      return store(low, `${to.read(middle)}+${4 * imm5}`, 4);
    case 0b01101:
      return load(low, `${to.read(middle)}+${4 * imm5}`, 4);
    case 0b01110:
      return store(low, `${to.read(middle)}+${imm5}`, 1);
    case 0b01111:
      return load(low, `${to.read(middle)}+${imm5}`, 1);
    case 0b10000:
      return store(low, `${to.read(middle)}+${2 * imm5}`, 2);
    case 0b10001:
      return load(low, `${to.read(middle)}+${2 * imm5}`, 2);
    case 0b10010:
      return store(top, `${to.read(SP)}+${4 * imm8}`, 4);
    case 0b10011:
      return load(top, `${to.read(SP)}+${4 * imm8}`, 4);
    case 0b10100:
      to.write(top, `${((at + 4) & ~3) + 4 * imm8}`);
      return done();
    case 0b10101:
      to.write(top, `(${to.read(SP)}+${4 * imm8})|0`);
      return done();
    case 0b10110:
    case 0b10111:
      break;
    case 0b11000: {
      const registers = list(imm8);
      const place = words(to.read(top), registers.length);
      registers.forEach((register, index) => to.lines.push(`ram32[${place}+${index}]=${to.read(register)};`));
      if (!(imm8 & (1 << top))) {
        to.write(top, `(${to.read(top)}+${4 * registers.length})|0`);
      }
      return done(1 + registers.length);
    }
    case 0b11001: {
      const registers = list(imm8);
      const from = to.temporary(to.read(top));
      const i = to.temporary(`(${from}-${RAM})>>>0`);
      const j = to.temporary(`(${from}-${FLASH})>>>0`);
      // tables of constants are in flash
      const end = 4 * registers.length;
      to.lines.push(`if(${i}>${RAM_BYTES - end}&&${j}>${FLASH_BYTES - end})${bail}`);
      const [words, place] = [to.temporary(`${i}<${RAM_BYTES}?ram32:flash32`), to.temporary(`(${from}&0xffffff)>>2`)];
      if (!(imm8 & (1 << top))) {
        to.write(top, `(${from}+${end})|0`);
      }
      registers.forEach((register, index) => to.write(register, `${words}[${place}+${index}]`));
      return done(1 + registers.length);
    }
    case 0b11010:
    case 0b11011: {
      const code = (opcode >> 8) & 15;
      if (code >= 14) {
        return interpret();
      }
      const target = at + 4 + 2 * signed(imm8, 8);
      const taken = to.condition(code);
      if (target === to.start) {
        again(taken, target);
      } else {
        to.lines.push(`if(${taken})${to.leave(target, to.cycles + 2)}`);
      }
      return done();
    }
    case 0b11100: {
      const target = at + 4 + 2 * signed(opcode & 0x7ff, 11);
      if (target !== to.start) {
        return done(2, target);
      }
      again('true', target);
      return null;
    }
    case 0b11110: {
      if ((opcode2 & 0xd000) === 0xd000) {
        const sign = (opcode >> 10) & 1;
        const [i1, i2] = [1 ^ sign ^ ((opcode2 >> 13) & 1), 1 ^ sign ^ ((opcode2 >> 11) & 1)];
        const offset = (sign << 24) | (i1 << 23) | (i2 << 22) | ((opcode & 0x3ff) << 12) | ((opcode2 & 0x7ff) << 1);
        to.write(LR, `${(at + 4) | 1}`);
        return done(3, at + 4 + signed(offset, 25));
      }
      // barriers
      if (opcode === 0xf3bf && opcode2 >= 0x8f40 && opcode2 <= 0x8f6f) {
        return done(3, at + 4);
      }
      return interpret();
    }
    default:
      return interpret();
  }

  // miscellaneous
  if (opcode >> 7 === 0b101100000 || opcode >> 7 === 0b101100001) {
    const by = 4 * (opcode & 0x7f);
    to.write(SP, `(${to.read(SP)}${opcode & 0x80 ? '-' : '+'}${by})|0`);
    return done();
  }
  switch (opcode >> 6) {
    case 0b1011001000:
      to.write(low, `${to.read(middle)}<<16>>16`);
      return done();
    case 0b1011001001:
      to.write(low, `${to.read(middle)}<<24>>24`);
      return done();
    case 0b1011001010:
      to.write(low, `${to.read(middle)}&65535`);
      return done();
    case 0b1011001011:
      to.write(low, `${to.read(middle)}&255`);
      return done();
    case 0b1011101000: {
      const m = to.temporary(to.read(middle));
      to.write(low, `(${m}<<24)|((${m}&65280)<<8)|((${m}>>>8)&65280)|(${m}>>>24)`);
      return done();
    }
  }
  if (opcode >> 9 === 0b1011010) {
    const registers = [...list(imm8), ...(opcode & 0x100 ? [LR] : [])];
    const place = words(`${to.read(SP)}-${4 * registers.length}`, registers.length);
    registers.forEach((register, index) => to.lines.push(`ram32[${place}+${index}]=${to.read(register)};`));
    to.write(SP, `(${to.read(SP)}-${4 * registers.length})|0`);
    // the emulator does not count the link register
    return done(1 + list(imm8).length);
  }
  if (opcode >> 9 === 0b1011110) {
    const registers = list(imm8);
    const returns = (opcode & 0x100) !== 0;
    const count = registers.length + (returns ? 1 : 0);
    const place = words(to.read(SP), count);
    const target = returns && to.temporary(`ram32[${place}+${registers.length}]`);
    if (returns) {
      to.lines.push(`if((${target}>>>28)===15)${bail}`);
    }
    registers.forEach((register, index) => to.write(register, `ram32[${place}+${index}]`));
    to.write(SP, `(${to.read(SP)}+${4 * count})|0`);
    if (returns) {
      to.lines.push(to.leave(`${target}&~1`, to.cycles + 3 + registers.length));
      return null;
    }
    return done(1 + registers.length);
  }
  if (opcode === 0xbf00) {
    return done();
  }
  return interpret();
}

const translations = new WeakMap();

/** Functions for the code of a flash, made when it has run often. */
export class Translation {
  /** The translation of an image, shared by all boards with it. */
  static of(image) {
    if (!translations.has(image)) {
      translations.set(image, new Translation(image));
    }
    return translations.get(image);
  }

  /** @param {Uint8Array} image contents of the flash from its start */
  constructor(image) {
    this.code = new Uint16Array(image.buffer, image.byteOffset, image.length >> 1);
    this.functions = new Array(this.code.length).fill(null);
    this.runs = new Uint16Array(this.code.length);
  }

  /** Runs translated code for at most `left` cycles, up to an instruction that is for the emulator; returns the cycles spent. */
  run(memory, core, left) {
    const { functions, runs } = this;
    const { R } = memory;
    let spent = 0;
    for (;;) {
      const index = (R[PC] - FLASH) >>> 1;
      if (index >= functions.length) {
        return spent;
      }
      let translated = functions[index];
      if (translated === null) {
        if (++runs[index] < OFTEN) {
          return spent;
        }
        translated = this.translate(R[PC] & ~1);
        functions[index] = translated;
      }
      const limit = left - spent - translated.most;
      if (limit <= 0) {
        return spent;
      }
      const cycles = translated(memory, core, limit);
      if (cycles < 0) {
        return spent + ~cycles;
      }
      spent += cycles;
    }
  }

  /** A function for the instructions from an address on: `(memory, core, limit)` returns the cycles spent; negative, their
   *  complement, if the next instruction is for the emulator. It has `most`, the cycles of one pass; a loop ends after `limit`. */
  translate(start) {
    const to = new Sequence(start);
    const seen = new Set();
    let at = start;
    while (at !== null) {
      const index = (at - FLASH) >> 1;
      if (seen.size === LONGEST || seen.has(at) || index < 0 || index >= this.code.length) {
        to.lines.push(to.leave(at, to.cycles));
        break;
      }
      seen.add(at);
      at = add(to, at, this.code[index], this.code[index + 1] ?? 0);
    }
    const back = [...to.written].map((register) => `R[${register}]=r${register};`).join('');
    const body = to.lines.join('\n').replaceAll('@', back);
    const needed = ['ram8', 'ram16', 'ram32', 'flash8', 'flash16', 'flash32'].filter((name) => body.includes(name));
    const source =
      `const R=memory.R${needed.map((name) => `,${name}=memory.${name}`).join('')};let base=0;` +
      [...to.used].map((register) => `let r${register}=R[${register}];`).join('') +
      (to.loops ? `for(;;){${body}}` : body);
    const translated = new Function('memory', 'core', 'limit', source);
    translated.most = to.cycles + 8;
    return translated;
  }
}

/** Views of a chip's memory for translated code. */
export function memoryOf(chip) {
  const views = (bytes) => [8, 16, 32].map((width) => {
    const View = { 8: Uint8Array, 16: Uint16Array, 32: Int32Array }[width];
    return new View(bytes.buffer, bytes.byteOffset, bytes.length / (width / 8));
  });
  const [ram8, ram16, ram32] = views(chip.sram);
  const [flash8, flash16, flash32] = views(chip.flash);
  return { R: new Int32Array(chip.core.registers.buffer), ram8, ram16, ram32, flash8, flash16, flash32 };
}
