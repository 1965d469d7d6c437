"""UARTE: the serial line. A byte takes ten bits; a buffer is sent at its end."""

from collections import deque

from peripheral import Peripheral

STARTRX, STOPRX, STARTTX, STOPTX = 0x000, 0x004, 0x008, 0x00C
RXDRDY, ENDRX, ENDTX, ERROR, RXTO, RXSTARTED, TXSTARTED, TXSTOPPED = 0x108, 0x110, 0x120, 0x124, 0x144, 0x14C, 0x150, 0x158
ERRORSRC, ENABLE, BAUDRATE, RXD, TXD = 0x480, 0x500, 0x524, 0x534, 0x544
OVERRUN = 1
BAUD = {0x1000_0000: 1_000_000, 0x0F00_0000: 921_600, 0x01D6_0000: 115_200}
# Bytes that the receiver holds without a buffer.
FIFO = 6


class Uarte(Peripheral):
    SHORTCUTS = {5: (ENDRX, STARTRX), 6: (ENDRX, STOPRX)}

    def __init__(self, *place):
        super().__init__(*place)
        self.arriving = deque()
        self.held = deque()
        self.into = None
        self.errors = 0

    def cycles(self, count):
        return count * 10 * 64_000_000 // BAUD[self.registers[BAUDRATE]]

    def task(self, offset):
        board = self.board
        if offset == STARTTX:
            address, length = self.buffer(TXD)

            def sent():
                board.sent += board.core.memory[address:address + length]
                self.registers[TXD + 8] = length
                self.event(ENDTX)

            self.event(TXSTARTED)
            board.schedule(board.now + self.cycles(length), sent)
        elif offset == STARTRX:
            self.into = [*self.buffer(RXD), 0]
            self.event(RXSTARTED)
            while self.held and self.into:
                self.take(self.held.popleft())
        elif offset in (STOPRX, STOPTX):
            raise NotImplementedError("the firmware never stops the line")

    def receive(self, data):
        """Bytes from the other end of the line."""
        idle = not self.arriving
        self.arriving.extend(data)
        if idle and data:
            self.board.schedule(self.board.now + self.cycles(1), self.arrive)

    def arrive(self):
        byte = self.arriving.popleft()
        if self.arriving:
            self.board.schedule(self.board.now + self.cycles(1), self.arrive)
        if self.registers[ENABLE] != 8:
            return
        if self.into:
            self.take(byte)
        elif len(self.held) < FIFO:
            self.held.append(byte)
        else:
            self.errors |= OVERRUN
            self.event(ERROR)

    def take(self, byte):
        address, length, done = self.into
        self.board.core.memory[address + done] = byte
        self.into[2] = done + 1
        self.event(RXDRDY)
        if done + 1 == length:
            self.into = None
            self.registers[RXD + 8] = length
            self.event(ENDRX)

    def computed(self, offset):
        return self.errors if offset == ERRORSRC else None

    def stored(self, offset, value):
        if offset == ERRORSRC:
            self.errors &= ~value
