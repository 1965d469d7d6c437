"""Programs on the host, and files between them and the board."""

import csv
import math
import os
import struct
import subprocess
import tempfile

from part import READ

# Scales of the codes of an LSM6DSV16X (fos-embedded/src/sample_source/lsm6dsv16x.rs), and their zeros: temperature from 25 °C.
ACCEL_MPS2, GYRO_RADS, TEMPERATURE_K = 0.122 * 9.80665e-3, math.radians(17.5e-3), 1 / 256
COLUMNS = {"ax_mps2": (ACCEL_MPS2, 0), "ay_mps2": (ACCEL_MPS2, 0), "az_mps2": (ACCEL_MPS2, 0), "gx_rads": (GYRO_RADS, 0),
           "gy_rads": (GYRO_RADS, 0), "gz_rads": (GYRO_RADS, 0), "temp_c": (TEMPERATURE_K, 25)}

_folder = tempfile.TemporaryDirectory(prefix="fos-nrf52840-")


def at(name):
    """Path of a file that is removed at the end of the program."""
    return os.path.join(_folder.name, name)


def fos(*options):
    """Runs `fos` and returns what it prints."""
    return subprocess.run([os.environ["FOS_HOST_FIT"], *options], check=True, stdout=subprocess.PIPE, text=True).stdout


def image(log, axis, name, *options):
    """Fits a model to a log and returns its image."""
    fos("fit", log, "--axis", axis, *options, "-o", at(f"{name}.json"))
    fos("export", at(f"{name}.json"), "--image", at(name))
    return at(name)


def six_axes(log, name):
    """Image of six axes over temperature and its square."""
    return image(log, "all", name, "--degree", "2", "--memory", "none", "--input", "temp_c")


def codes(log, rows=None):
    """The first rows of a log as codes for the part."""
    fos("convert", log, "-o", f"{log}.csv")
    with open(f"{log}.csv", newline="") as file:
        read = csv.DictReader(file)
        return [[max(-32768, min(32767, round((float(row[name]) - zero) / scale))) for name, (scale, zero) in COLUMNS.items()]
                for _, row in zip(range(rows or 1 << 30), read)]


def expected(image, delivered):
    """Telemetry that a hub on the host sends for rows that a part delivered."""
    rows = [row for row in delivered if row[8] == READ]
    with open(at("codes"), "wb") as file:
        before = rows[0][0] - 1
        for row in rows:
            file.write(struct.pack("<I7h", row[0] - before - 1, *row[1:8]))
            before = row[0]
    subprocess.run([os.environ["FOS_FIRMWARE_TELEMETRY"], "nrf52840", image, at("codes"), at("telemetry")], check=True, stdout=subprocess.DEVNULL)
    with open(at("telemetry"), "rb") as file:
        return file.read()


def compare(sent, expected):
    """Fails unless the board sent what the host computes: the same bytes, as far as they have been sent."""
    for index in range(0, len(sent), 4096):
        if sent[index:index + 4096] != expected[index:index + 4096][:len(sent) - index]:
            raise AssertionError(f"bytes {index} to {index + 4096} of {len(sent)} differ from what the host computes")
    # the samples since the latest interrupt are still on their way
    if len(sent) < len(expected) - 32 * 100:
        raise AssertionError(f"{len(expected) - len(sent)} bytes were not sent")
    return len(sent)


def frame(image):
    """Frame in which an image goes over the line, after a delimiter."""
    return b"\0" + subprocess.run([os.environ["FOS_IMAGE_FRAME"], image], check=True, stdout=subprocess.PIPE).stdout


def update(board, image):
    """Sends an image and waits for the flash to hold it."""
    board.run(0.4)
    before = board.nvmc.changes
    board.line.receive(frame(image))
    board.run(2, lambda: board.nvmc.changes > before)
    if board.nvmc.changes == before:
        raise AssertionError("the image was not stored")
    board.run(0.4)
