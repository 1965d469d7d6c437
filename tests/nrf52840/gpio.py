"""Pins: GPIO and GPIOTE. Inputs are set by the board."""

from peripheral import Peripheral


class Port(Peripheral):
    OUT, OUTSET, OUTCLR, IN = 0x504, 0x508, 0x50C, 0x510

    def __init__(self, *place):
        super().__init__(*place)
        self.input = 0

    def computed(self, offset):
        levels = self.input | (self.board.lines() if self.base == 0x5000_0000 else 0)
        return {self.IN: levels, self.OUTSET: self.registers[self.OUT], self.OUTCLR: self.registers[self.OUT]}.get(offset)

    def stored(self, offset, value):
        out = self.registers[self.OUT]
        if offset in (self.OUTSET, self.OUTCLR):
            changed = value & ~out if offset == self.OUTSET else value & out
            self.registers[self.OUT] = out ^ changed
            if changed:
                self.board.output(self, changed, offset == self.OUTSET)

    def update(self):
        """No interrupts."""


class Gpiote(Peripheral):
    IN, CONFIG = 0x100, 0x510
    EVENT, RISING, FALLING = 1, 1, 2

    def edge(self, port, pin, rises):
        """Passes a change of a pin to the channels that watch it."""
        for channel in range(8):
            config = self.registers[self.CONFIG + 4 * channel]
            watches = config & 3 == self.EVENT and (config >> 8 & 31, config >> 13 & 1) == (pin, port)
            if watches and config >> 16 & (self.RISING if rises else self.FALLING):
                self.event(self.IN + 4 * channel)
