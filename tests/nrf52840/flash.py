"""NVMC: flash that the program may write, the pages of the model images and UICR. The processor waits while it changes."""

from peripheral import Peripheral

PAGE = 4096
STORE = 1024 * 1024 - 4 * PAGE
UICR = 0x1000_1000
# Times by the product specification, s.
WRITE_S, ERASE_S = 41e-6, 85e-3


class Nvmc(Peripheral):
    READY, CONFIG, ERASEPAGE = 0x400, 0x504, 0x508
    WRITES, ERASES = 1, 2

    def __init__(self, *place):
        super().__init__(*place)
        # called before every change
        self.before = lambda: None
        self.changes = 0

    def computed(self, offset):
        return 1 if offset in (self.READY, 0x408) else None

    def stored(self, offset, value):
        if offset == self.ERASEPAGE:
            if self.registers[self.CONFIG] != self.ERASES or value % PAGE or not STORE <= value < STORE + 4 * PAGE:
                raise RuntimeError(f"page 0x{value:x} is erased without permission")
            self.changing(ERASE_S)
            self.board.store[value - STORE:value - STORE + PAGE] = b"\xff" * PAGE

    def program(self, memory, offset, size, value):
        """A store of the processor to flash: it can only clear bits."""
        if self.registers[self.CONFIG] != self.WRITES or size != 4 or offset % 4:
            raise RuntimeError(f"flash is written without permission, {size} bytes at 0x{offset:x}")
        self.changing(WRITE_S)
        before = int.from_bytes(memory[offset:offset + 4], "little")
        memory[offset:offset + 4] = (before & value).to_bytes(4, "little")

    def changing(self, seconds):
        self.before()
        self.changes += 1
        self.board.stall(seconds)
