"""The board: chip, sensor on I2C, serial line. Time is in cycles of 64 MHz; an instruction takes one."""

import heapq
import itertools
import struct

from core import AT_RETURN, AT_WFE, Core
from flash import STORE, UICR, Nvmc
from gpio import Gpiote, Port
from peripheral import Peripheral, Ppi
from timers import CYCLES, Clock, Rtc, Timer, Watchdog
from twim import Twim
from uarte import Uarte

PERIPHERALS = {
    0x4000_0000: Clock, 0x4000_2000: Uarte, 0x4000_3000: Twim, 0x4000_6000: Gpiote, 0x4000_8000: Timer, 0x4000_9000: Timer,
    0x4000_C000: Peripheral, 0x4001_0000: Watchdog, 0x4001_1000: Rtc, 0x4001_E000: Nvmc, 0x4001_F000: Ppi,
}
PORTS = {0x5000_0000: Port, 0x5000_0300: Port}
# Pins of the firmware (fos-embedded/examples/nrf52840), two of port 0 and two of port 1.
SDA, SCL = 26, 27
INT1, COMPUTING = 3, 4
# Interval at which INT1 is looked at, s.
LOOK_S = 250e-6
# Build code of a chip whose access port must be opened by the firmware.
BUILD_CODE = b"0FAA"


def program(path):
    """Contents of the flash from address 0 to the pages of the model images, from an ELF file."""
    with open(path, "rb") as file:
        elf = file.read()
    flash = bytearray(b"\xff" * STORE)
    start, size, count = struct.unpack_from("<I", elf, 28)[0], *struct.unpack_from("<HH", elf, 42)
    for at in range(start, start + size * count, size):
        kind, offset, _, address, length = struct.unpack_from("<IIIII", elf, at)
        if kind == 1 and length:
            flash[address:address + length] = elf[offset:offset + length]
    return bytes(flash)


class Board:
    def __init__(self, program, part):
        self.program, self.part = program, part
        self.store = bytearray(b"\xff" * (1024 * 1024 - STORE))
        self.uicr = bytearray(b"\xff" * 0x1000)
        self.sent = bytearray()
        # instructions of every sample
        self.samples = []
        # instructions before the latest start, and cycles in which the flash was busy
        self.executed_before = self.busy = 0
        self.offset = 0
        self.core = None
        self.starts = {"power": 0, "software": 0, "watchdog": 0}
        # the sensor holds SCL low
        self.scl_held = False
        # clocks until the sensor releases SDA, which it holds low
        self.sda_clocks = 0
        self.switch_on()

    @property
    def now(self):
        return self.core.counter.executed + self.offset

    @property
    def ns(self):
        return self.now * 1000 // 64

    @property
    def awake(self):
        """Cycles in which the processor executed instructions or waited for the flash."""
        return self.executed_before + self.core.counter.executed + self.busy

    def switch_on(self, cause="power"):
        """Starts the chip; flash, sensor and time continue."""
        self.starts[cause] += 1
        if self.core:
            self.offset += self.core.counter.executed
            self.executed_before += self.core.counter.executed
            self.core.reset()
        else:
            self.core = Core(self.program)
            self.core.changed = self.limit
            self.map()
        self.queue, self.order = [], itertools.count()
        self.asleep = self.bitten = False
        self.end = self.now
        self.ppi = None
        blocks = {base: kind(self, base, base >> 12 & 0x3F) for base, kind in (PERIPHERALS | PORTS).items()}
        self.blocks = blocks
        self.ppi, self.nvmc, self.line = blocks[0x4001_F000], blocks[0x4001_E000], blocks[0x4000_2000]
        self.level, self.rose = False, None
        self.look()

    # what the processor reads and writes

    def map(self):
        uc = self.core.uc
        for base in (0x4000_0000, 0x5000_0000):
            uc.mmio_map(base, 0x20000, self.read, base, self.write, base)
        factory = bytearray(0x1000)
        factory[0x104:0x108] = BUILD_CODE
        uc.mem_map(0x1000_0000, 0x1000, 1)
        uc.mem_write(0x1000_0000, bytes(factory))
        for base, memory in ((UICR, self.uicr), (STORE, self.store)):
            uc.mmio_map(base, len(memory), self.read_memory, memory, self.write_memory, memory)

    def block(self, address):
        base = address & ~0xFFF
        if base == 0x5000_0000:
            base += 0x300 if address & 0xFFF >= 0x800 or 0x300 <= address & 0xFFF < 0x500 else 0
        return self.blocks.get(base)

    def read(self, uc, offset, size, base):
        block = self.block(base + offset)
        if block is None:
            raise NotImplementedError(f"reads 0x{base + offset:08x}")
        return block.read(base + offset - block.base)

    def write(self, uc, offset, size, value, base):
        block = self.block(base + offset)
        if block is None:
            raise NotImplementedError(f"writes 0x{base + offset:08x}")
        block.write(base + offset - block.base, value)
        self.limit()

    def task(self, address):
        block = self.block(address)
        block.write(address - block.base, 1)

    def read_memory(self, uc, offset, size, memory):
        return int.from_bytes(memory[offset:offset + size], "little")

    def write_memory(self, uc, offset, size, value, memory):
        self.nvmc.program(memory, offset, size, value)
        self.limit()

    # pins

    def lines(self):
        """Levels of port 0: SDA has a pull-up resistor."""
        return int(self.sda_clocks == 0) << SDA

    def look(self):
        """Passes a change of INT1 to the chip."""
        self.schedule(self.now + int(LOOK_S * CYCLES), self.look)
        self.pin()

    def pin(self):
        self.part.advance(self.ns)
        level = self.part.interrupt()
        if level != self.level:
            self.level = level
            self.rose = self.now if level else self.rose
            self.blocks[0x5000_0300].input = level << INT1
            self.blocks[0x4000_6000].edge(1, INT1, level)

    def output(self, port, changed, high):
        if port is self.blocks[0x5000_0000] and changed >> SCL & 1 and not high:
            self.sda_clocks = max(0, self.sda_clocks - 1)
        if port is self.blocks[0x5000_0300] and changed >> COMPUTING & 1:
            if high:
                self.began = self.core.counter.executed
            else:
                self.samples.append(self.core.counter.executed - self.began)

    # time

    def schedule(self, when, what):
        heapq.heappush(self.queue, (when, next(self.order), what))

    def stall(self, seconds):
        """Lets time pass while the processor waits."""
        cycles = int(seconds * CYCLES)
        self.offset += cycles
        self.busy += cycles

    def limit(self):
        """Ends the run of the processor at the next event, or now if an interrupt can be taken."""
        core, counter = self.core, self.core.counter
        due = min(self.queue[0][0], self.end) if self.queue else self.end
        waiting = core.waiting() is not None
        counter.waiting = waiting
        stops = core.reset_requested or waiting and not core.masked()
        counter.limit = counter.executed if stops else max(counter.executed, due - self.offset)

    def run(self, seconds, done=lambda: False):
        """Runs for a time, or until `done()`, which is looked at with every event."""
        end = self.now + int(seconds * CYCLES)
        while self.now < end and not done():
            self.end = end
            self.step()

    def step(self):
        core, counter = self.core, self.core.counter
        while self.queue and self.queue[0][0] <= self.now:
            heapq.heappop(self.queue)[2]()
        if core.reset_requested or self.bitten:
            return self.switch_on("watchdog" if self.bitten else "software")
        number = core.waiting()
        if number is not None and not core.masked():
            self.asleep = False
            core.enter(number)
        if self.asleep:
            self.offset += max(0, min(self.queue[0][0], self.end) - self.now)
            return None
        self.limit()
        ended = core.run()
        if ended == AT_RETURN:
            core.leave()
        elif ended == AT_WFE:
            core.pc += 2
            counter.executed += 1
            self.asleep = counter.event == 0
            counter.event = 0
        return None
