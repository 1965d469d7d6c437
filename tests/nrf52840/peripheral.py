"""What all peripherals of the chip have in common: tasks, events, shortcuts, interrupts; and PPI, which connects them."""

from collections import defaultdict

SHORTS, INTEN, INTENSET, INTENCLR = 0x200, 0x300, 0x304, 0x308


class Peripheral:
    # tasks that an event triggers if its bit of SHORTS is set: bit → (event, task)
    SHORTCUTS = {}

    def __init__(self, board, base, interrupt):
        self.board, self.base, self.interrupt = board, base, interrupt
        self.registers = defaultdict(int)
        self.events = defaultdict(int)

    def task(self, offset):
        """Does what a task does."""

    def stored(self, offset, value):
        """Reacts to a value that was written to a register."""

    def computed(self, offset):
        """Value of a register that is not what was written to it; None for all others."""
        return None

    def read(self, offset):
        if 0x100 <= offset < 0x200:
            return self.events[offset]
        value = self.computed(offset)
        if value is not None:
            return value
        return self.registers[INTEN if offset in (INTENSET, INTENCLR) else offset]

    def write(self, offset, value):
        if offset < 0x100:
            if value & 1:
                self.task(offset)
        elif offset < 0x200:
            self.events[offset] = value & 1
        elif offset in (INTENSET, INTENCLR):
            mask = self.registers[INTEN]
            self.registers[INTEN] = mask | value if offset == INTENSET else mask & ~value
        else:
            self.registers[offset] = value
            self.stored(offset, value)
        self.update()

    def event(self, offset):
        """Generates an event."""
        self.events[offset] = 1
        for bit, (event, task) in self.SHORTCUTS.items():
            if event == offset and self.registers[SHORTS] >> bit & 1:
                self.task(task)
        self.board.ppi.event(self.base + offset)
        self.update()

    def update(self):
        mask = self.registers[INTEN]
        high = any(on and mask >> (offset - 0x100) // 4 & 1 for offset, on in self.events.items())
        self.board.core.line(self.interrupt, high)

    def buffer(self, pointer):
        """Address and length of a buffer of EasyDMA, which reaches RAM only."""
        address, length = self.registers[pointer], self.registers[pointer + 4]
        if length and not 0x2000_0000 <= address <= 0x2004_0000 - length:
            raise RuntimeError(f"EasyDMA at 0x{address:08x} is outside the RAM")
        return address - 0x2000_0000, length


class Ppi(Peripheral):
    CHEN, CHENSET, CHENCLR, CHANNELS, GROUPS, FORKS = 0x500, 0x504, 0x508, 0x510, 0x800, 0x910

    def event(self, address):
        for channel in range(20):
            if self.registers[self.CHEN] >> channel & 1 and self.registers[self.CHANNELS + 8 * channel] == address:
                for task in (self.registers[self.CHANNELS + 8 * channel + 4], self.registers[self.FORKS + 4 * channel]):
                    if task:
                        self.board.task(task)

    def task(self, offset):
        channels = self.registers[self.GROUPS + 4 * (offset // 8)]
        enabled = self.registers[self.CHEN]
        self.registers[self.CHEN] = enabled & ~channels if offset & 4 else enabled | channels

    def computed(self, offset):
        return self.registers[self.CHEN] if offset in (self.CHENSET, self.CHENCLR) else None

    def stored(self, offset, value):
        if offset == self.CHENSET:
            self.registers[self.CHEN] |= value
        elif offset == self.CHENCLR:
            self.registers[self.CHEN] &= ~value

    def update(self):
        """No interrupts."""
