"""Rows and populations on Spark are those of `fos fleet`. Usage: checks.py HOST-FIT FOLDER UNITS.

Every check stands beside one that has to fail.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import fos_imu as fos
import fos_imu.spark
import logs
from pyspark.sql import functions
from session import executors, session

HOST_FIT, FOLDER, UNITS = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
FLEET = FOLDER / "line3"


def say(text):
    print(f"-- fleet: {text} ({time.monotonic() - BEGUN:.0f} s)", flush=True)


def check(holds, text):
    if not holds:
        sys.exit(f"failed: {text}")
    print(f"   {text}", flush=True)


def program(folder, out):
    done = subprocess.run([HOST_FIT, "fleet", str(folder), "-o", str(out)], capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"fos fleet on {folder.name} {done.stderr if done.returncode else ''}")
    return out.read_bytes()


def saved(fleet):
    path = FOLDER / "of_spark.json"
    fleet.save(path)
    return path.read_bytes()


def main():
    say(f"{UNITS} units")
    lines = logs.write(FLEET, UNITS, 3.0)
    # among them a log that is cut in half, one with nothing in it, one ten times as long
    whole = (FLEET / lines[0][3]).read_bytes()
    (FLEET / "cut.parquet").write_bytes(whole[: len(whole) // 2])
    (FLEET / "empty.csv").write_bytes(b"")
    fos.simulate(minutes=30.0, seed=9999, motion=False).write(FLEET / "huge.parquet")
    lines += [
        ("cut", "bmi270", "lot1", "cut.parquet"),
        ("empty", "bmi270", "", "empty.csv"),
        ("huge", "bmi270", "lot2", "huge.parquet"),
    ]
    lines.append(("gone", "bmi270", "lot2", "gone.parquet"))
    # and a unit that was logged twice
    fos.simulate(minutes=3.0, seed=9998, motion=False).write(FLEET / "again.parquet")
    lines.append((*lines[0][:3], "again.parquet"))
    logs.table(FLEET, lines)
    expected = program(FLEET, FOLDER / "population.json")

    say("a Spark of two executors")
    spark = session("local-cluster[2,1,1024]", **{"spark.task.maxFailures": "4"})
    of_units = {}
    for unit, part, lot, log in lines:
        of_units.setdefault((unit, part, lot or None), []).append(str(FLEET / log))
    frame = spark.createDataFrame(
        [(*named, logs) for named, logs in of_units.items()],
        "unit string, part string, lot string, log array<string>",
    )
    spark_rows = fos.spark.unit_rows

    say("the same bytes with 1, 3 and 7 partitions")
    for partitions in (1, 3, 7):
        rows = spark_rows(frame.repartition(partitions))
        check(
            saved(fos.spark.population(rows)) == expected, f"{partitions} partitions: {len(expected)} bytes, the same"
        )
    rows = spark_rows(frame).persist()
    check(saved(fos.spark.population(rows.where("unit != 'u0007'"))) != expected, "without a unit they are others")
    twice = rows.union(rows.where("unit = 'u0007'"))
    try:
        fos.spark.population(twice)
        check(False, "a unit twice is an error")
    except fos.FosError as error:
        check("twice" in str(error), f"a unit twice: {error.message}")

    other = spark_rows(frame.where("unit = 'huge'"), regressors=["temp_c * temp_c"])
    try:
        fos.spark.population(rows.where("unit != 'huge'").union(other))
        check(False, "rows that were asked different things are an error")
    except fos.FosError as error:
        check("asked different things" in error.message, f"asked different things: {error.message}")

    say("the rows beside a population, for a report")
    found = fos.spark.population(rows)
    kept = [row.row for row in rows.select("row").toLocalIterator()]
    found.save(FOLDER / "kept.json", rows=kept)
    report = [HOST_FIT, "fleet", "report", "kept.json", "-o", "fleet.html"]
    done = subprocess.run(report, cwd=FOLDER, capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"fos fleet report {done.stderr}")
    try:
        found.save(FOLDER / "kept.json", rows=kept[1:])
        check(False, "other rows are an error")
    except fos.FosError as error:
        check("rows" in error.message, f"a row is missing: {error.message}".replace(str(FOLDER), "…"))

    say("damaged, empty, huge and missing logs")
    failed = {row.unit: row.failed for row in rows.collect() if row.failed}
    check(set(failed) == {"cut", "empty", "gone"}, f"rows that say why: {sorted(failed)}")
    check(
        all(reasons[0] for reasons in failed.values()),
        "; ".join(reasons[0].splitlines()[0] for reasons in failed.values()).replace(str(FLEET), "…"),
    )
    huge = rows.where("unit = 'huge'").first()
    check(not huge.failed, "the log of half an hour is a row as any other")
    small = spark_rows(frame.where("unit in ('huge', 'u0001')"), largest_bytes=len(whole) * 3)
    limited = {row.unit: list(row.failed) for row in small.collect()}
    check(
        "largest_bytes" in limited["huge"][0] and not limited["u0001"],
        f"above a limit: {limited['huge'][0].splitlines()[0].replace(str(FLEET), '…')}",
    )

    say("logs that come as bytes")
    some = spark.read.format("binaryFile").load(str(FLEET / "*.parquet")).where("path not like '%cut%'")
    names = {log.rpartition(".")[0]: (unit, part, lot) for unit, part, lot, log in lines}
    # a row of binaryFile is one log: the unit that was logged twice is not among them
    twice_logged = lines[0][0]
    for stem in ("gone", "cut", "empty", "again", lines[0][3].rpartition(".")[0]):
        del names[stem]
    known = spark.createDataFrame(
        [(f"file:{FLEET}/{stem}.parquet", *named) for stem, named in names.items()],
        "path string, unit string, part string, lot string",
    )
    some = some.withColumn("path", functions.regexp_replace("path", "^file:/+", "file:/")).join(known, "path")
    of_bytes = spark_rows(some).persist()
    whole_rows = rows.where(f"unit not in ('cut', 'empty', 'gone', '{twice_logged}')")
    check(
        saved(fos.spark.population(of_bytes)) == saved(fos.spark.population(whole_rows)),
        f"{of_bytes.count()} logs: the same bytes",
    )
    check(saved(fos.spark.population(of_bytes)) != expected, "without those that failed they are others than of all")

    say("rows kept in Parquet, a folder for each lot")
    rows.write.partitionBy("lot").parquet(str(FOLDER / "rows"))
    again = spark.read.parquet(str(FOLDER / "rows"))
    check(saved(fos.spark.population(again)) == expected, "read back: the same bytes")
    check(saved(fos.spark.population(again.where("lot != 'lot1'"))) != expected, "without a lot they are others")
    parquet = sum(path.stat().st_size for path in (FOLDER / "rows").rglob("*.parquet"))
    print(f"   {parquet / len(lines):.0f} bytes a unit")

    rows.unpersist()
    say("an executor that is killed")
    check(killed(spark, frame, expected), "the same bytes, by an executor that was not there before")
    check(not killed(spark, frame, expected, really=False), "where none is killed there is no new one")
    spark.stop()
    say("done")


def killed(spark, frame, expected, really=True):
    """Whether an executor was lost while rows were made, and another took its place. The bytes are the same in any case."""
    tracker, before = spark.sparkContext.statusTracker(), executors()
    check(len(before) == 2, f"{len(before)} executors")
    outcome = {}

    def run():
        try:
            outcome["bytes"] = saved(fos.spark.population(fos.spark.unit_rows(frame.repartition(frame.count()))))
        except Exception as error:  # said below, on the thread that ends the process
            outcome["error"] = error

    thread = threading.Thread(target=run)
    thread.start()
    victim, lost = min(before), False
    while thread.is_alive() and not lost:
        for stage in map(tracker.getStageInfo, tracker.getActiveStageIds()):
            if really and stage and stage.numTasks > 10 and 2 <= stage.numCompletedTasks < stage.numTasks - 4:
                os.kill(victim, signal.SIGKILL)
                lost = True
                print(
                    f"   killed one of them with {stage.numCompletedTasks} of {stage.numTasks} tasks done", flush=True
                )
        time.sleep(0.01)
    thread.join()
    if "error" in outcome:
        raise outcome["error"]
    check(lost == really, "it was killed in the middle" if really else "none is killed")
    check(outcome["bytes"] == expected, "the job ended with the same bytes")
    for _ in range(200):
        if victim not in executors() and len(executors()) == 2 or not really:
            break
        time.sleep(0.1)
    return victim not in executors() and bool(executors() - before)


if __name__ == "__main__":
    BEGUN = time.monotonic()
    main()
