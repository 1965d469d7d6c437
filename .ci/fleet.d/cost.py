"""What a fleet costs, with one core and with two: the program, Python, Spark. Usage: cost.py HOST-FIT FOLDER UNITS.

Every unit is a log of its own, 10 minutes of six axes at 200 Hz in Parquet. Memory is the most that the processes of a run held
at once, of what each held resident.
"""

import multiprocessing
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import fos_imu as fos
import logs

HOST_FIT, FOLDER, UNITS = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
FLEET = FOLDER / "line3"


def row(line):
    unit, part, lot, log = line
    return fos.unit_row(FLEET / log, unit=unit, part=part, lot=lot or None).to_json()


class Memory(threading.Thread):
    """The most that processes of a kind held, MB."""

    def __init__(self, of):
        super().__init__(daemon=True)
        self.of, self.most, self.over = of, 0.0, threading.Event()

    def run(self):
        while not self.over.wait(0.1):
            self.most = max(self.most, sum(map(resident, self.of())))

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *error):
        self.over.set()
        self.join()


def resident(process):
    try:
        return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * 4096 / 1e6
    except OSError:
        return 0.0


def of_program(lines, cores, out):
    environment = {**os.environ, "RAYON_NUM_THREADS": str(cores)}
    run = subprocess.Popen([HOST_FIT, "fleet", str(FLEET), "-o", str(out)], env=environment, stdout=subprocess.DEVNULL)
    with Memory(lambda: [run.pid]) as memory:
        assert run.wait() == 0
    return memory.most


def of_python(lines, cores, out):
    from session import descendants

    with (
        multiprocessing.get_context("spawn").Pool(cores) as pool,
        Memory(lambda: [os.getpid(), *descendants()]) as memory,
    ):
        fos.population(pool.imap_unordered(row, lines, chunksize=4)).save(out)
    return memory.most


def of_spark(lines, cores, out):
    import fos_imu.spark
    from session import descendants, session

    spark = session(f"local[{cores}]")
    frame = spark.createDataFrame(
        [(unit, part, lot, str(FLEET / log)) for unit, part, lot, log in lines], ["unit", "part", "lot", "log"]
    )
    with Memory(lambda: [os.getpid(), *descendants()]) as memory:
        fos.spark.population(fos.spark.unit_rows(frame.repartition(8 * cores))).save(out)
    spark.stop()
    return memory.most


def main():
    begun = time.monotonic()
    lines = logs.write(FLEET, UNITS, 10.0)
    bytes_of = [path.stat().st_size for path in FLEET.glob("*.parquet")]
    print(
        f"{UNITS} logs, {sum(bytes_of) / 1e6 / UNITS:.2f} MB each, written in {time.monotonic() - begun:.0f} s",
        flush=True,
    )
    for path in FLEET.glob("*.parquet"):
        path.read_bytes()  # the disk is not measured
    print("\n| by | cores | s | units a second | share of linear | memory, MB |\n|---|---|---|---|---|---|", flush=True)
    expected = None
    for name, run in (("fos fleet", of_program), ("Python", of_python), ("Spark", of_spark)):
        alone = None
        for cores in (1, 2):
            out = FOLDER / f"{name}-{cores}.json"
            begun = time.monotonic()
            memory = run(lines, cores, out)
            seconds = time.monotonic() - begun
            alone = alone or seconds
            expected = expected or out.read_bytes()
            assert out.read_bytes() == expected, f"{name}, {cores} cores: other bytes"
            share = f"{100 * alone / cores / seconds:.0f} %"
            print(f"| {name} | {cores} | {seconds:.1f} | {UNITS / seconds:.2f} | {share} | {memory:.0f} |", flush=True)
    print(f"\nall six the same {len(expected)} bytes")
    texts = [row(line) for line in lines[: min(UNITS, 50)]]
    length = sum(map(len, texts)) / len(texts)
    before = resident(os.getpid())
    held = fos._engine.Rows()
    many = 200
    for _ in range(many):
        held.extend(texts)
    print(
        f"a row: {length:.0f} bytes of JSON, {(resident(os.getpid()) - before) * 1e6 / many / len(texts):.0f} bytes held"
    )


if __name__ == "__main__":
    main()
