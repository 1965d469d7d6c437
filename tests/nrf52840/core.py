"""The processor: unicorn's Cortex-M4 with FPU, and what unicorn lacks: counts of instructions, WFE, exceptions, NVIC.

Interrupts do not preempt each other: all have the same priority in the firmware, and another one ends the test.
"""

import ctypes
import os

from unicorn import Uc, arm_const as arm
from unicorn import UC_ARCH_ARM, UC_HOOK_CODE, UC_MODE_MCLASS, UC_MODE_THUMB, UC_PROT_ALL, UC_PROT_EXEC, UC_PROT_READ, UC_PROT_WRITE
from unicorn.unicorn_py3.unicorn import uclib

FLASH_BYTES = 1024 * 1024
RAM = 0x2000_0000
RAM_BYTES = 256 * 1024
# Return address of an exception handler, in place of EXC_RETURN, which unicorn does not give to its caller.
RETURN = 0x0800_0000
AT_LIMIT, AT_WFE, AT_RETURN = range(3)

STACKED = [arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2, arm.UC_ARM_REG_R3, arm.UC_ARM_REG_R12, arm.UC_ARM_REG_LR,
           arm.UC_ARM_REG_PC, arm.UC_ARM_REG_XPSR]
STACKED_FLOATS = [arm.UC_ARM_REG_D0 + n for n in range(8)]
# Bytes of a frame with room for floats.
FRAME = 0x68

SYSTEM = 0xE000_E000
ISER, ICER, ISPR, ICPR, IPR, AIRCR, CPACR = 0x100, 0x180, 0x200, 0x280, 0x400, 0xD0C, 0xD88


class Counter(ctypes.Structure):
    _fields_ = [("executed", ctypes.c_uint64), ("limit", ctypes.c_uint64), ("waiting", ctypes.c_uint32), ("event", ctypes.c_uint32),
                ("in_block", ctypes.c_uint32), ("ended", ctypes.c_uint32), ("flash_bytes", ctypes.c_uint32),
                ("flash", ctypes.c_void_p), ("stop", ctypes.c_void_p)]


class Core:
    """`flash` is the program from address 0 on, up to the pages that the program may write, which are a device of the board."""

    def __init__(self, flash):
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        self.flash = (ctypes.c_uint8 * len(flash)).from_buffer_copy(flash)
        self.ram = (ctypes.c_uint8 * RAM_BYTES)()
        self.memory = memoryview(self.ram).cast("B")
        self.uc.mem_map_ptr(0, len(flash), UC_PROT_READ | UC_PROT_EXEC, ctypes.addressof(self.flash))
        self.uc.mem_map_ptr(RAM, RAM_BYTES, UC_PROT_READ | UC_PROT_WRITE, ctypes.addressof(self.ram))
        self.uc.mem_map(RETURN, 0x1000, UC_PROT_ALL)
        self.uc.mem_write(RETURN, b"\x00\xbf" * 2)  # NOP
        self.uc.mmio_map(SYSTEM, 0x1000, self.read_system, None, self.write_system, None)
        stop = ctypes.cast(uclib.uc_emu_stop, ctypes.c_void_p)
        self.counter = Counter(flash_bytes=len(flash), flash=ctypes.addressof(self.flash), stop=stop)
        library = ctypes.CDLL(os.environ["FOS_COUNT"])
        hook = ctypes.c_size_t()
        uclib.uc_hook_add(self.uc._uch, ctypes.byref(hook), UC_HOOK_CODE, ctypes.cast(library.count, ctypes.c_void_p),
                          ctypes.addressof(self.counter), ctypes.c_uint64(1), ctypes.c_uint64(0))
        # called when an interrupt may have become pending
        self.changed = lambda: None
        self.reset()

    def reset(self):
        """State after a reset, with zeros in RAM. The translated code remains, which makes starts fast."""
        ctypes.memset(self.ram, 0, RAM_BYTES)
        for register in (*range(arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R0 + 13), arm.UC_ARM_REG_LR, arm.UC_ARM_REG_PRIMASK, arm.UC_ARM_REG_FPSCR):
            self.uc.reg_write(register, 0)
        counter = self.counter
        counter.executed = counter.limit = counter.waiting = counter.event = counter.in_block = 0
        self.system = {}
        self.enabled = self.pended = self.lines = 0
        self.active = None
        self.reset_requested = False
        self.uc.reg_write(arm.UC_ARM_REG_SP, int.from_bytes(bytes(self.flash[:4]), "little"))
        self.pc = int.from_bytes(bytes(self.flash[4:8]), "little") & ~1

    def run(self):
        """Runs until the limit of the counter, WFE, or the end of an exception handler; returns which."""
        self.uc.emu_start(self.pc | 1, 0xFFFF_FFFF)
        self.pc = self.uc.reg_read(arm.UC_ARM_REG_PC) & ~1
        return self.counter.ended

    def waiting(self):
        """Number of the interrupt that is to be taken next, enabled interrupts provided; None without one."""
        ready = self.pended & self.enabled
        if ready == 0 or self.active is not None:
            return None
        return (ready & -ready).bit_length() - 1

    def masked(self):
        return self.uc.reg_read(arm.UC_ARM_REG_PRIMASK) & 1 != 0

    def enter(self, number):
        """Pushes a frame and goes to the handler of an interrupt."""
        uc = self.uc
        uc.reg_write(arm.UC_ARM_REG_PC, self.pc | 1)
        sp = uc.reg_read(arm.UC_ARM_REG_SP)
        frame = (sp - FRAME) & ~7
        values = [uc.reg_read(register) for register in STACKED]
        values[6] = self.pc
        self.words(frame, values)
        self.frame = (sp, [uc.reg_read(register) for register in STACKED_FLOATS], uc.reg_read(arm.UC_ARM_REG_FPSCR))
        uc.reg_write(arm.UC_ARM_REG_SP, frame)
        uc.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
        self.pended &= ~(1 << number)
        self.active = number
        self.counter.event = 1
        vector = 4 * (16 + number)
        self.pc = int.from_bytes(bytes(self.flash[vector:vector + 4]), "little") & ~1

    def leave(self):
        """Takes the frame from the stack at the end of a handler."""
        uc = self.uc
        sp, floats, fpscr = self.frame
        frame = uc.reg_read(arm.UC_ARM_REG_SP)
        if frame != (sp - FRAME) & ~7:
            raise RuntimeError("a handler leaves another stack than it found")
        values = [int.from_bytes(self.memory[at:at + 4], "little") for at in range(frame - RAM, frame - RAM + 32, 4)]
        for register, value in zip(STACKED, values):
            uc.reg_write(register, value)
        for register, value in zip(STACKED_FLOATS, floats):
            uc.reg_write(register, value)
        uc.reg_write(arm.UC_ARM_REG_FPSCR, fpscr)
        uc.reg_write(arm.UC_ARM_REG_SP, sp)
        self.pc = values[6] & ~1
        number, self.active = self.active, None
        self.pended |= self.lines & 1 << number
        self.counter.event = 1

    def words(self, address, values):
        self.memory[address - RAM:address - RAM + 4 * len(values)] = b"".join(value.to_bytes(4, "little") for value in values)

    def line(self, number, high):
        """Level of the interrupt line of a peripheral."""
        bit = 1 << number
        if high and not self.lines & bit:
            self.pended |= bit
        self.lines = self.lines | bit if high else self.lines & ~bit
        self.changed()

    def read_system(self, uc, offset, size, _):
        for base, value in ((ISER, self.enabled), (ICER, self.enabled), (ISPR, self.pended), (ICPR, self.pended)):
            if base <= offset < base + 8:
                return value >> 8 * (offset - base) & 0xFFFF_FFFF
        return self.system.get(offset, 0)

    def write_system(self, uc, offset, size, value, _):
        for base in (ISER, ICER, ISPR, ICPR):
            if base <= offset < base + 8:
                bits = value << 8 * (offset - base)
                self.enabled |= bits if base == ISER else 0
                self.enabled &= ~bits if base == ICER else ~0
                self.pended |= bits if base == ISPR else 0
                self.pended &= ~bits if base == ICPR else ~0
                self.pended |= self.lines
                return self.changed()
        if IPR <= offset < IPR + 0x40 and value != 0:
            raise NotImplementedError("interrupts of different priority")
        if offset == AIRCR and value & 4:
            self.reset_requested = True
        self.system[offset] = value
        self.changed()
