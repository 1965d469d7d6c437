"""What the wheel costs: bytes, seconds to import, and calls beside the same work in the program.

    cost.py WHEEL HOST-FIT

A call is compared with the program's on the same file: reading, the work itself, and what the program prints as JSON. The
start of the interpreter and the import stand apart; what they add to a call that lasts a second is not the call's.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

wheel, host_fit = Path(sys.argv[1]), sys.argv[2]
ROUNDS = 7
AIMS = {"bytes": 15e6, "import_s": 0.2, "overhead": 0.05}


def median(run) -> float:
    """Seconds."""
    times = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        run()
        times.append(time.perf_counter() - begun)
    return statistics.median(times)


def python(code: str) -> float:
    """What `code` measures of itself in an interpreter of its own, s."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(done.stdout)


IMPORT = "import time; t = time.perf_counter(); import numpy; n = time.perf_counter(); import fos_imu; e = time.perf_counter(); print({})"


def main() -> None:
    import fos_imu as fos

    bytes_ = wheel.stat().st_size
    both = statistics.median(python(IMPORT.format("e - t")) for _ in range(ROUNDS))
    own = statistics.median(python(IMPORT.format("e - n")) for _ in range(ROUNDS))
    print(f"wheel: {bytes_ / 1e6:.1f} MB (aim {AIMS['bytes'] / 1e6:.0f})")
    print(f"import: {both:.3f} s with NumPy (aim {AIMS['import_s']}), {own:.3f} s of it fos_imu itself")

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def program(*arguments: str) -> None:
            subprocess.run([host_fit, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        case = fos.simulate_case(["thermal_lag"], setup="desk", seed=3)
        for log in ("reference", "log", "evaluation"):
            getattr(case, log).write(folder / f"{log}.parquet")
        read = lambda log: fos.read(folder / f"{log}.parquet")  # noqa: E731
        fos.fit(read("reference"), axes="gx").save(folder / "unit.json")
        study = fos.Study.load(folder / "unit.json")
        (folder / "unit.fosm").write_bytes(study.export_image())

        def fit() -> None:
            fos.fit(read("reference"), physical=["temp_c"]).save(folder / "all.json", replace=True)

        def compare() -> None:
            fos.Study.load(folder / "unit.json").compare(read("evaluation"))

        def diagnose() -> None:
            fos.Study.load(folder / "unit.json").diagnose(read("log"))

        calls = {
            "fit, six axes": (fit, ("fit", "reference.parquet", "--physical", "temp_c", "-o", "all.json", "--json")),
            "compare, one axis": (compare, ("compare", "unit.json", "evaluation.parquet", "--json")),
            "diagnose, one axis": (diagnose, ("diagnose", "unit.json", "--from", "log.parquet", "--json")),
            "noise, six axes": (lambda: fos.noise(read("reference")), ("noise", "reference.parquet", "--json")),
        }
        print("| call | Python, s | program, s | more, % |\n|---|---|---|---|")
        told = {}
        for call, (here, there) in calls.items():
            # in turns, so that a busy machine is busy for both
            mine, theirs = [], []
            for _ in range(ROUNDS):
                for kept, run in ((mine, here), (theirs, lambda: program(*there))):
                    begun = time.perf_counter()
                    run()
                    kept.append(time.perf_counter() - begun)
            # what else the machine does makes either slower, never faster
            a, b = min(mine), min(theirs)
            told[call] = a / b - 1
            print(f"| {call} | {a:.3f} | {b:.3f} | {100 * (a / b - 1):+.1f} |")
    print(json.dumps({"bytes": bytes_, "import_s": both, "own_import_s": own, "overhead": told}))


main()
