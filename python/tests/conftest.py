"""What tests share: one simulated case, one study of it, and the program where it is built."""

import json
import os
import subprocess
from pathlib import Path

import fos_imu as fos
import pytest


@pytest.fixture(scope="session")
def case():
    return fos.simulate_case(["thermal_lag"], setup="desk", seed=3, reference_s=300, log_s=900, evaluation_s=300)


@pytest.fixture
def study(case):
    return fos.fit(case.reference, axes="gx")


@pytest.fixture(scope="session")
def short():
    """A minute and a half of six axes with a motion."""
    return fos.simulate(minutes=1.5, seed=5)


@pytest.fixture(scope="session")
def program():
    """Runs the program; what it prints as JSON."""
    path = os.environ.get("FOS_HOST_FIT")
    if not path:
        pytest.skip("FOS_HOST_FIT does not name the program (cargo build --release -p host-fit)")

    def run(*arguments, folder: Path):
        done = subprocess.run([path, *map(str, arguments)], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout) if "--json" in arguments else done.stdout

    return run
