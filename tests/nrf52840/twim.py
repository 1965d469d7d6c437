"""TWIM: bytes between EasyDMA and the sensor, each at its time."""

from peripheral import Peripheral

STARTRX, STARTTX, STOP, SUSPEND, RESUME = 0x000, 0x008, 0x014, 0x01C, 0x020
STOPPED, ERROR, SUSPENDED, RXSTARTED, TXSTARTED, LASTRX, LASTTX = 0x104, 0x124, 0x148, 0x14C, 0x150, 0x15C, 0x160
ERRORSRC, ENABLE, FREQUENCY, RXD, TXD, ADDRESS = 0x4C4, 0x500, 0x524, 0x534, 0x544, 0x588
ANACK, DNACK = 2, 4
HZ = {0x0198_0000: 100_000, 0x0400_0000: 250_000, 0x0640_0000: 400_000}


class Twim(Peripheral):
    SHORTCUTS = {7: (LASTTX, STARTRX), 8: (LASTTX, SUSPEND), 9: (LASTTX, STOP), 10: (LASTRX, STARTTX), 12: (LASTRX, STOP)}

    def __init__(self, *place):
        super().__init__(*place)
        # a later one ends the transfer before
        self.transfer = 0

    def after(self, bits, what):
        """Does something after the time of so many bits, unless the transfer ends before."""
        transfer = self.transfer
        board = self.board
        stretch = board.part.stretch_ns() * 64 // 1000 if bits >= 9 else 0

        def due():
            if transfer == self.transfer and not board.scl_held and board.sda_clocks == 0:
                board.part.advance(board.ns)
                what()

        board.schedule(board.now + bits * 64_000_000 // HZ[self.registers[FREQUENCY]] + stretch, due)

    def task(self, offset):
        if self.registers[ENABLE] != 6:
            raise RuntimeError("TWIM is not enabled")
        if offset in (STARTRX, STARTTX):
            self.transfer += 1
            reads = offset == STARTRX
            self.after(10, lambda: self.address(reads))
        elif offset == STOP:
            self.transfer += 1
            self.after(1, self.stop)
        elif offset == SUSPEND:
            self.event(SUSPENDED)

    def stop(self):
        self.board.part.stop()
        self.board.pin()
        self.event(STOPPED)

    def address(self, reads):
        pointer = RXD if reads else TXD
        self.registers[pointer + 8] = 0
        if not self.board.part.start(self.registers[ADDRESS], reads):
            return self.fail(ANACK)
        self.event(RXSTARTED if reads else TXSTARTED)
        buffer = self.buffer(pointer)
        if buffer[1]:
            self.after(9, lambda: self.byte(reads, *buffer, 0))

    def byte(self, reads, address, length, done):
        memory = self.board.core.memory
        last = done + 1 == length
        if reads:
            memory[address + done] = self.board.part.read(not last)
        elif not self.board.part.write(memory[address + done]):
            return self.fail(DNACK)
        self.registers[(RXD if reads else TXD) + 8] = done + 1
        if last:
            self.event(LASTRX if reads else LASTTX)
        else:
            self.after(9, lambda: self.byte(reads, address, length, done + 1))

    def fail(self, reason):
        self.errors = reason
        self.event(ERROR)

    errors = 0

    def computed(self, offset):
        return self.errors if offset == ERRORSRC else None

    def stored(self, offset, value):
        if offset == ERRORSRC:
            self.errors &= ~value
