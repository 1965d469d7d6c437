#!/usr/bin/env python3
"""bias_error.py LOG TRUTH BEFORE AFTER STUDY: the slow error that the messages of bias leave in gyro x, before and after.

LOG was played twice, BEFORE and AFTER are the bias.csv of the two plays; TRUTH has, row by row, the error that is in LOG, in its
column gx_rads; STUDY is what `fos add --json` printed. As in fos, the slow error is the variance of means over a
second. Fails where the measured fall is outside what was predicted.
"""

import csv
import json
import sys

AXIS = "gx_rads"
START_S = 1.0  # stamp of the first row, as the player gives it
BLOCK_S = 1.0


def column(path, name):
    with open(path, newline="") as file:
        rows = csv.reader(file)
        k = next(rows).index(name)
        return [float(row[k]) for row in rows]


def bias_of_rows(path, times):
    """The bias that holds at every row: that of the last message before; None before the first."""
    stamps, biases = column(path, "t_s"), column(path, "gx")
    held, n = [], 0
    for time in times:
        while n < len(stamps) and stamps[n] <= time:
            n += 1
        held.append(biases[n - 1] if n else None)
    return held


def slow_variance(times, values):
    """Of the means of whole blocks, about their mean."""
    blocks = {}
    for time, value in zip(times, values):
        if value is not None:
            blocks.setdefault(int((time - times[0]) / BLOCK_S), []).append(value)
    full = max(len(block) for block in blocks.values()) * 0.9
    means = [sum(block) / len(block) for block in blocks.values() if len(block) >= full]
    mean = sum(means) / len(means)
    return sum((value - mean) ** 2 for value in means) / len(means)


def main():
    log, truth, before, after, study = sys.argv[1:]
    times = column(log, "t_s")
    times = [time - times[0] + START_S for time in times]
    true_error = column(truth, AXIS)
    if len(true_error) != len(times):
        sys.exit(f"error: {truth} is not the truth of {log}")
    step = json.load(open(study))["steps"][-1]
    finding = step["added"]["finding"]
    low, high = finding["expected_drop_ci"]
    print(f"slow error of {AXIS}, rad/s, after the bias that the nanoapp sent is subtracted:")
    falls = []
    for what, error in [("measured", column(log, AXIS)), ("true", true_error)]:
        left = []
        for path in (before, after):
            bias = bias_of_rows(path, times)
            left.append(slow_variance(times, [None if b is None else e - b for e, b in zip(error, bias)]))
        falls.append(1 - left[1] / left[0])
        print(f"  against the {what:8} error: {left[0] ** 0.5:.3e} before, {left[1] ** 0.5:.3e} after: fell by {100 * falls[-1]:.1f} %")
    print(f"  predicted by fos: {100 * finding['expected_drop']:.1f} % ({100 * low:.1f} to {100 * high:.1f}, 90 %)")
    print(f"  measured by fos:  {100 * step['added']['realised_fall']:.1f} %")
    if not low <= falls[0] <= high:
        sys.exit("error: the fall is outside what was predicted")


main()
