"""Six axes: the bits of the host, and what a sample costs."""

import os
import time

from board import CYCLES, Board, program
from host import at, codes, compare, expected, fos, six_axes, update
from part import Part
from timers import Timer

PART, ADDRESS = "lsm6dsv16x", 0x6A


def bits(minutes="10"):
    seconds = 60 * float(minutes)
    log = at("log.parquet")
    fos("simulate", log, "--minutes", minutes, "--seed", "11")
    image = six_axes(log, "image")
    part = Part(PART, ADDRESS, codes(log))
    board = Board(program(os.environ["FOS_FIRMWARE"]), part)
    update(board, image)
    # without power or image in RAM, from the flash
    board.switch_on()
    board.sent.clear()
    first = len(part.delivered())
    spent, started = time.process_time(), board.now
    board.samples.clear()
    board.run(0.3)
    settled, awake_from = board.now, board.awake
    board.run(seconds)
    share = (board.awake - awake_from) / (board.now - settled)
    sent = compare(board.sent, expected(image, part.delivered(first)))
    stamp(board)
    costs = sorted(board.samples)
    if len(costs) < 0.99 * 200 * seconds or board.starts["watchdog"]:
        raise AssertionError(f"{len(costs)} samples in {seconds:.0f} s, {board.starts}")
    print(f"{len(costs)} samples in {(board.now - started) / CYCLES:.0f} s; {sent} bytes of telemetry as the host computes them; {time.process_time() - spent:.0f} s of processor time")
    print(f"instructions of a sample: median {costs[len(costs) // 2]}, worst {costs[-1]}")
    print(f"awake {100 * share:.2f} % of the time at 64 MHz, one instruction per cycle")


def stamp(board):
    """Fails unless the chip has the time at which INT1 rose last, in µs of its timer."""
    timer = board.blocks[0x4000_8000]
    read, true = timer.registers[Timer.CC + 4], (board.rose - timer.since) // 64
    if read != true:
        raise AssertionError(f"INT1 rose at {true} µs; the chip has {read} µs")
