"""Power fails while an image is stored: the chip starts with the image before or with the new one. The flash changes only when a page is
erased or a word written, so the states between, and those of a change that power interrupts, are all that there are."""

import os
import random

from bits import ADDRESS, PART
from board import Board, program
from host import at, codes, fos, image, update
from part import Part
from telemetry import decode

# Bit of a validity: the axis has no model.
NOT_MODELLED = 1024
AXES = ("ax", "ay", "az", "gx", "gy", "gz")


def model_after_start(board, store):
    """Starts the chip with this content of the store, and returns the axes that its model has."""
    board.store[:] = store
    board.switch_on()
    board.sent.clear()
    board.run(2, lambda: len(board.sent) > 500)
    samples, damaged, _ = decode(board.sent)
    if not samples or damaged:
        raise AssertionError("the chip does not start")
    return ",".join(axis for axis, flags in zip(AXES, samples[0].validity) if not flags & NOT_MODELLED)


def torn(before, after, random):
    """A change that power interrupts: any share of its bits has changed."""
    share = random.random()
    masks = (sum((random.random() < share) << bit for bit in range(8)) if old != new else 0 for old, new in zip(before, after))
    return bytes(old ^ (mask & (old ^ new)) for old, new, mask in zip(before, after, masks))


def power(stride="1", seed="1"):
    """Power fails around and within every `stride`-th change, the first and the last one always."""
    generator = random.Random(int(seed))
    log = at("power.parquet")
    fos("simulate", log, "--minutes", "10", "--seed", "3", "--at-rest")
    old, new = image(log, "gx", "gx"), image(log, "gy", "gy")
    board = Board(program(os.environ["FOS_FIRMWARE"]), Part(PART, ADDRESS, codes(log, 20_000)))
    states = []

    def record():
        states.append(bytes(board.store))

    # updates until one erases a page: the longest there is
    def erases():
        return any(b != 255 and a == 255 for before, after in zip(states, states[1:]) for b, a in zip(before, after))

    count = 0
    while not erases() or count % 2:
        states.clear()
        board.nvmc.before = record
        update(board, new if count % 2 else old)
        states.append(bytes(board.store))
        count += 1
        if count > 60:
            raise AssertionError("no update erases a page")
    print(f"update {count} changes the flash {len(states) - 1} times")
    board.nvmc.before = lambda: None
    chosen = sorted({*range(0, len(states), int(stride)), len(states) - 2, len(states) - 1})
    found, interrupted = [], []

    def start(state, models, place):
        models.append(model_after_start(board, state))
        if models[-1] not in ("gx", "gy"):
            raise AssertionError(f"{place} change {index} the chip starts with {models[-1] or 'no model'}")

    for index in chosen:
        start(states[index], found, "before")
        if index + 1 < len(states):
            start(torn(states[index], states[index + 1], generator), interrupted, "within")
    if found[0] != "gx" or found[-1] != "gy" or found != sorted(found):
        raise AssertionError(f"images after the changes: {found}")
    # a state in between is no obstacle to the next update
    for index in (chosen[len(chosen) // 3], chosen[2 * len(chosen) // 3]):
        model_after_start(board, states[index])
        update(board, new)
        if model_after_start(board, bytes(board.store)) != "gy":
            raise AssertionError(f"cut after change {index}: the next update is lost")
    print(f"{len(found)} starts between changes: {found.count('gx')} with the previous image, {found.count('gy')} with the new one")
    print(f"{len(interrupted)} starts after a torn change: {interrupted.count('gx')} with the previous image, {interrupted.count('gy')} with the new one")
