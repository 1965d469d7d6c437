"""The sensor: a register model of fos-parts (tests/parts), behind its C interface."""

import ctypes
import os

# Numbers of the faults (tests/parts/src/faults.rs).
NONE, NACK, STUCK_HIGH, STUCK_LOW, FLIP, RESET, PIN, UNANSWERED, STRETCH = 0, 1, 2, 3, 5, 11, 15, 16, 17

COLUMNS = 9
READ = 1


class Part:
    def __init__(self, name, address, codes):
        """`codes` are rows of seven, or None for generated ones."""
        self.library = library = ctypes.CDLL(os.environ["FOS_PARTS"])
        library.parts_new.restype = ctypes.c_void_p
        for name_, restype in (("parts_i2c_start", ctypes.c_bool), ("parts_i2c_write", ctypes.c_bool), ("parts_i2c_read", ctypes.c_uint8),
                               ("parts_stretch_ns", ctypes.c_uint64), ("parts_interrupt", ctypes.c_bool), ("parts_tick", ctypes.c_uint64),
                               ("parts_delivered", ctypes.c_size_t)):
            getattr(library, name_).restype = restype
        rows = codes and (ctypes.c_int16 * (7 * len(codes)))(*(code for row in codes for code in row))
        pointer = library.parts_new(name.encode(), ctypes.c_uint8(address), rows, ctypes.c_size_t(len(codes or ())))
        if not pointer:
            raise ValueError(f"no part {name}")
        self.pointer = ctypes.c_void_p(pointer)

    def start(self, address, reads):
        return self.library.parts_i2c_start(self.pointer, ctypes.c_uint8(address), ctypes.c_bool(reads))

    def write(self, byte):
        return self.library.parts_i2c_write(self.pointer, ctypes.c_uint8(byte))

    def read(self, acknowledge):
        return self.library.parts_i2c_read(self.pointer, ctypes.c_bool(acknowledge))

    def stop(self):
        self.library.parts_i2c_stop(self.pointer)

    def stretch_ns(self):
        return self.library.parts_stretch_ns(self.pointer)

    def advance(self, ns):
        self.library.parts_advance_to(self.pointer, ctypes.c_uint64(ns))

    def interrupt(self):
        return self.library.parts_interrupt(self.pointer, ctypes.c_uint8(1))

    def fault(self, fault, value):
        self.library.parts_fault(self.pointer, ctypes.c_uint32(fault), ctypes.c_double(value))

    def tick(self):
        return self.library.parts_tick(self.pointer)

    def delivered(self, first=0):
        """Rows of tick, six codes, temperature, and 1 if the row was read."""
        capacity = 65_536
        block = (ctypes.c_int32 * (COLUMNS * capacity))()
        rows = []
        while True:
            count = self.library.parts_delivered(self.pointer, ctypes.c_size_t(first + len(rows)), block, ctypes.c_size_t(capacity))
            rows += [tuple(block[at:at + COLUMNS]) for at in range(0, COLUMNS * count, COLUMNS)]
            if count < capacity:
                return rows
