"""Firmware on an emulated nRF52840: .ci/chip builds what this needs and calls it."""

import sys

from bits import bits
from faults import faults
from power import power


def m4f(minutes="10"):
    bits(minutes)
    faults()
    power()


def gate():
    bits("0.5")
    faults()
    power("4")


if __name__ == "__main__":
    what, *options = sys.argv[1:]
    {"bits": bits, "faults": faults, "gate": gate, "m4f": m4f, "power": power}[what](*options)
