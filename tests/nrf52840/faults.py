"""Faults of the sensor, its bus and its pin: the firmware gives valid samples again, within a stated time, and loses no more samples than
stated. No sample has codes that the part did not deliver."""

import os

import part as faults_of
from bits import ADDRESS, PART
from board import Board, program
from host import ACCEL_MPS2, GYRO_RADS, at, codes, fos, frame, six_axes, update
from part import Part
from telemetry import decode

# Rows of the log that the model is fitted to; later temperatures are out of its range.
FITTED = 55_000
# Samples without a flag that show a recovery: 0.5 s.
CLEAN = 100


def of_part(fault, value):
    return lambda board: board.part.fault(fault, value)


def scl(held):
    def hold(board):
        board.scl_held = held

    return hold


def sda(clocks):
    def hold(board):
        if clocks == 0 and board.sda_clocks != 0:
            raise AssertionError("the firmware has not freed SDA")
        board.sda_clocks = clocks

    return hold


NOTHING = of_part(faults_of.NONE, 0)
# Fault; how it begins and ends; how long it lasts, s; within how many seconds after its end the samples are valid again; most ticks
# without a sample. `restarts`: the watchdog starts the chip, and its ticks count from 0.
FAULTS = [
    ("an address is not acknowledged", of_part(faults_of.NACK, 1), NOTHING, 0, 0.3, 0),
    ("five transfers are not answered", of_part(faults_of.NACK, 5), NOTHING, 0, 0.3, 0),
    ("no transfer is answered", of_part(faults_of.UNANSWERED, 1e9), NOTHING, 1, 2.5, 450),
    ("SDA high", of_part(faults_of.STUCK_HIGH, 1), NOTHING, 1, 2.5, 450),
    ("SDA low", of_part(faults_of.STUCK_LOW, 1), NOTHING, 1, 2.5, 450),
    ("SCL stretched by 20 µs after every byte", of_part(faults_of.STRETCH, 20e3), NOTHING, 5, 0.1, 0),
    ("a bit in 2000 bytes flips", of_part(faults_of.FLIP, 2000), NOTHING, 1, 1.5, 100),
    ("the part resets itself", of_part(faults_of.RESET, 1), NOTHING, 0, 1.5, 60),
    ("INT1 stuck low", of_part(faults_of.PIN, 1), NOTHING, 5, 0.3, 0),
    ("INT1 stuck high", of_part(faults_of.PIN, 2), NOTHING, 5, 0.3, 0),
    ("an image with a changed bit", lambda board: board.line.receive(damaged(board)), NOTHING, 0, 0.3, 0),
    ("an image that breaks off", lambda board: board.line.receive(frame(board.image)[:200]), NOTHING, 0, 0.3, 0),
    ("SDA held low until nine clocks", sda(9), sda(0), 3, 3, "restarts"),
    ("SCL held for ever", scl(True), scl(False), 3, 3, "restarts"),
]


def damaged(board):
    whole = bytearray(frame(board.image))
    whole[50] ^= 4
    return whole


def happen(board, begin, end, seconds, restarts):
    """Lets a fault happen; returns the time after which samples are valid again, and the ticks without a sample."""
    board.run(0.53)
    samples, _, rest = decode(board.sent)
    board.sent[:] = rest
    last = None if restarts else samples[-1].tick
    begin(board)
    board.run(seconds)
    end(board)
    ended = recovered = board.now
    clean = lost = 0
    while clean < CLEAN:
        if board.now - ended > 20 * 64_000_000:
            raise AssertionError("no recovery within 20 s")
        board.run(0.05)
        samples, _, rest = decode(board.sent)
        board.sent[:] = rest
        for sample in samples:
            follows = last is not None and sample.tick == last + 1
            if last is not None and sample.tick > last:
                lost += sample.tick - last - 1
            last = sample.tick
            check(board, sample)
            fine = follows and not any(sample.validity)
            if not fine or clean == 0:
                recovered = board.now
            clean = clean + 1 if fine else 0
    return max(0, recovered - ended) / 64e6, 0 if restarts else lost


def check(board, sample):
    """Fails if the part did not deliver the codes of a sample."""
    scales = [ACCEL_MPS2] * 3 + [GYRO_RADS] * 3
    read = tuple(round(value / scale) for value, scale in zip(sample.measured, scales))
    if read not in board.played:
        raise AssertionError(f"the part has no codes {read}")


def faults(only=""):
    log = at("faults.parquet")
    fos("simulate", log, "--minutes", "10", "--seed", "3", "--at-rest")
    played = codes(log, FITTED)
    board = Board(program(os.environ["FOS_FIRMWARE"]), Part(PART, ADDRESS, played))
    board.played = {tuple(row[:6]) for row in played}
    board.image = six_axes(log, "six")
    update(board, board.image)
    board.run(2)
    board.sent.clear()
    missed = False
    print("| fault | lasts, s | valid again after, s | ticks without a sample |\n|---|---|---|---|")
    for name, begin, end, seconds, within, most in FAULTS:
        if only not in name:
            continue
        bites = board.starts["watchdog"]
        restarts = most == "restarts"
        after, lost = happen(board, begin, end, seconds, restarts)
        met = after <= within and (restarts or lost <= most) and (board.starts["watchdog"] > bites) == restarts
        missed |= not met
        print(f"| {name} | {seconds or '–'} | {after:.2f} ({within}) | {'counts from 0' if restarts else f'{lost} ({most})'} |{'' if met else ' MISSED'}", flush=True)
    if missed:
        raise AssertionError("a fault took longer than stated, or cost more samples")
