"""Long calls: others run meanwhile, Ctrl-C ends them, several at once are safe."""

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import fos_imu as fos
import pytest
from fos_imu import errors

LONG = """
import signal
import time
import fos_imu as fos
# as in a terminal: a shell's background jobs are started with it ignored
signal.signal(signal.SIGINT, signal.default_int_handler)
log = fos.simulate(minutes=25, seed=2)
print("begun", flush=True)
begun = time.monotonic()
try:
    fos.fit(log, max_lag=60, max_terms=200, stop="never")
except KeyboardInterrupt:
    print(f"stopped after {time.monotonic() - begun}", flush=True)
    print(fos.fit(fos.simulate(minutes=1), axes="gx", max_lag=2).axes)
else:
    print("not stopped")
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as POSIX has them")
def test_ctrl_c_ends_a_long_call_and_the_engine_goes_on_working():
    running = subprocess.Popen([sys.executable, "-c", LONG], stdout=subprocess.PIPE, text=True)
    assert running.stdout.readline() == "begun\n"
    time.sleep(1.0)
    running.send_signal(signal.SIGINT)
    out, _ = running.communicate(timeout=60)
    stopped, works = out.splitlines()
    assert stopped.startswith("stopped after")
    # a second of work, 50 ms until it is looked for, and the longest stretch that does not check, on a machine that may be busy;
    # the whole call takes more than a minute
    assert float(stopped.split()[-1]) < 30.0
    assert works == "('gx_rads',)"


def judged(minutes):
    log, later = fos.simulate(minutes=minutes, seed=5), fos.simulate(minutes=minutes, seed=6)
    return str(fos.fit(log, axes="gx", max_lag=4).compare(later))


@pytest.mark.skipif(os.name != "posix", reason="only there processes are forked")
# from Python 3.12 on it warns of what is tried here
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_process_that_is_forked_after_a_fit_fits_too():
    alone = judged(1)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        # without threads of its own it would wait for those of its parent for ever
        assert pool.map_async(judged, [1, 1, 1]).get(timeout=120) == [alone] * 3


def test_others_run_while_the_engine_works(case):
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.005)

    ticker = threading.Thread(target=tick)
    ticker.start()
    begun = time.monotonic()
    fos.fit(case.reference, axes="gx", max_lag=25)
    spent = time.monotonic() - begun
    done.set()
    ticker.join()
    # with the interpreter locked there would be none; half of the time is for a busy machine
    assert len([at for at in ticks if begun < at < begun + spent]) > 0.5 * spent / 0.05


def test_threads_see_the_same_and_changes_are_whole(case):
    study = fos.fit(case.reference, axes="gx", max_lag=3)
    expected = study.diagnose(case.log)
    found, raised = [], []

    def work(change):
        try:
            if change:
                study.add("thermal_lag", case.log)
            else:
                found.append(study.diagnose(case.log, reference=case.reference))
        except fos.FosError as error:
            raised.append(error)

    threads = [threading.Thread(target=work, args=(change,)) for change in (True, False, True, False)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # of two that add the same one is refused, and a diagnosis is of the study before or after
    assert [type(error) for error in raised] == [errors.RefineError]
    assert all(one.findings == () or one.sentence == expected.sentence for one in found)
    assert [step.name for step in study.history[0].steps] == ["before", "+ thermal_lag"]


def test_errors_survive_a_process():
    error = errors.RecordingError("what", remedy="do", file="a.csv", line=3, column="gx")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is errors.RecordingError
    assert vars(again) == vars(error)
    assert str(again) == "what\nhelp: do"


def test_every_error_of_the_engine_has_its_class():
    kinds = {
        name for name, kind in vars(errors).items() if isinstance(kind, type) and issubclass(kind, errors.FosError)
    }
    assert kinds >= {
        "RecordingError",
        "FitError",
        "CompareError",
        "DiagnoseError",
        "RefineError",
        "StudyError",
        "NoiseError",
    }
