"""Time: TIMER, RTC, WDT, and the oscillators of CLOCK."""

from peripheral import Peripheral

CYCLES = 64_000_000
LFCLK = 32_768


class Timer(Peripheral):
    """Timer or counter; compare events only as a counter."""

    START, STOP, COUNT, CLEAR, CAPTURE, COMPARE, MODE, PRESCALER, CC = 0x000, 0x004, 0x008, 0x00C, 0x040, 0x140, 0x504, 0x510, 0x540
    SHORTCUTS = {n: (0x140 + 4 * n, 0x00C) for n in range(6)}

    def __init__(self, *place):
        super().__init__(*place)
        self.value = 0
        # cycle at which it was started
        self.since = None

    def now(self):
        if self.registers[self.MODE] or self.since is None:
            return self.value
        # 16 MHz, divided by a power of two
        return self.value + ((self.board.now - self.since) // 4 >> self.registers[self.PRESCALER]) & 0xFFFF_FFFF

    def task(self, offset):
        if offset == self.START:
            self.since = self.board.now
        elif offset == self.STOP:
            self.value, self.since = self.now(), None
        elif offset == self.CLEAR:
            self.value, self.since = 0, self.since and self.board.now
        elif offset == self.COUNT and self.registers[self.MODE]:
            self.value += 1
            for n in range(6):
                if self.value == self.registers[self.CC + 4 * n]:
                    self.event(self.COMPARE + 4 * n)
        elif self.CAPTURE <= offset < self.CAPTURE + 0x18:
            self.registers[self.CC + offset - self.CAPTURE] = self.now()


class Rtc(Peripheral):
    START, CLEAR, OVERFLOW, COMPARE, COUNTER, CC = 0x000, 0x008, 0x104, 0x140, 0x504, 0x540
    TURN = 1 << 24

    def __init__(self, *place):
        super().__init__(*place)
        self.since = None
        self.version = {}

    def ticks(self):
        return 0 if self.since is None else (self.board.now - self.since) * LFCLK // CYCLES

    def arm(self, event, value):
        """Generates an event whenever the counter reaches a value."""
        self.version[event] = version = self.version.get(event, 0) + 1
        if self.since is None:
            return
        now = self.ticks()
        due = now + ((value - now) % self.TURN or self.TURN)

        def reached():
            if version == self.version[event]:
                self.arm(event, value)
                self.event(event)

        self.board.schedule(self.since - (-due * CYCLES // LFCLK), reached)

    def task(self, offset):
        if offset in (self.START, self.CLEAR):
            self.since = self.board.now
            self.arm(self.OVERFLOW, 0)
            for n in range(4):
                self.arm(self.COMPARE + 4 * n, self.registers[self.CC + 4 * n])

    def computed(self, offset):
        return self.ticks() % self.TURN if offset == self.COUNTER else None

    def stored(self, offset, value):
        if self.CC <= offset < self.CC + 0x10:
            self.arm(self.COMPARE + offset - self.CC, value)


class Watchdog(Peripheral):
    START, RUNSTATUS, CRV, RR, RELOAD = 0x000, 0x400, 0x504, 0x600, 0x6E52_4635

    def __init__(self, *place):
        super().__init__(*place)
        self.version = 0

    def task(self, offset):
        if offset == self.START:
            self.registers[self.RUNSTATUS] = 1
            self.reload()

    def reload(self):
        self.version += 1
        version = self.version

        def late():
            if version == self.version:
                self.board.bitten = True

        self.board.schedule(self.board.now + (self.registers[self.CRV] + 1) * CYCLES // LFCLK, late)

    def stored(self, offset, value):
        if offset == self.RR and value == self.RELOAD and self.registers[self.RUNSTATUS]:
            self.reload()


class Clock(Peripheral):
    """The processor waits for its oscillators in a loop, which is skipped: 0.36 ms for that of 32 MHz, 250 ms for that of 32 kHz."""

    STARTS = {0x000: (0x100, 360e-6), 0x008: (0x104, 0.25)}

    def task(self, offset):
        if offset in self.STARTS:
            event, seconds = self.STARTS[offset]
            self.board.stall(seconds)
            self.event(event)
