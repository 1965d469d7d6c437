"""FosRegressor beside SysIdentPy and fastcan, on the systems of their own documentation.

    python beside_others.py [FOLDER]     prints a table; writes beside_others.svg and .md into FOLDER

Every package gets the same rows, lags, degree and number of terms to choose from, and is judged by its own free run over
rows that it was not fitted to: the validation input, and the first measured outputs to begin from.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fos_imu as fos
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
SEEDS = 20
BEGIN = 8
"""Measured outputs that a free run begins from, more than any lag here."""


@dataclass(frozen=True)
class System:
    """A system of somebody's documentation: how it runs, and what is asked of those who identify it."""

    name: str
    equation: str
    inputs: int
    max_lag: int
    terms: int
    run: Callable[[Floats, Floats], Floats]
    true_terms: frozenset[str]
    input_today: bool
    """Whether x(k) is among the terms of y(k)."""


def of_sysidentpy(u: Floats, e: Floats) -> Floats:
    """`get_siso_data` of SysIdentPy."""
    y = np.zeros(len(u))
    for k in range(2, len(u)):
        y[k] = 0.2 * y[k - 1] + 0.1 * y[k - 1] * u[k - 1, 0] + 0.9 * u[k - 2, 0] + e[k]
    return y


def of_fastcan(u: Floats, e: Floats) -> Floats:
    """The example of `make_narx` of fastcan."""
    y = np.zeros(len(u))
    for k in range(3, len(u)):
        y[k] = (
            0.5 * y[k - 1]
            + 0.3 * u[k, 0] ** 2
            + 2 * u[k - 1, 0] * u[k - 3, 0]
            + 1.5 * u[k - 2, 0] * u[k - 3, 1]
            + 1
            + e[k]
        )
    return y


SYSTEMS = (
    System(
        "SysIdentPy",
        "y(k) = 0.2 y(k−1) + 0.1 y(k−1) x(k−1) + 0.9 x(k−2) + e(k)",
        1,
        2,
        3,
        of_sysidentpy,
        frozenset({"y(n-1)", "y(n-1)·x0(n-1)", "x0(n-2)"}),
        False,
    ),
    System(
        "fastcan",
        "y(k) = 0.5 y(k−1) + 0.3 u₀(k)² + 2 u₀(k−1) u₀(k−3) + 1.5 u₀(k−2) u₁(k−3) + 1 + e(k)",
        2,
        3,
        4,
        of_fastcan,
        frozenset({"y(n-1)", "x0(n)²", "x0(n-1)·x0(n-3)", "x0(n-2)·x1(n-3)"}),
        True,
    ),
)


def data(system: System, seed: int, noise: float) -> tuple[Floats, Floats]:
    """Inputs and output; noise as a share of the output's standard deviation."""
    random = np.random.default_rng(seed)
    u = random.uniform(-1, 1, (1000, system.inputs))
    clean = system.run(u, np.zeros(1000))
    return u, system.run(u, noise * float(clean.std()) * random.normal(size=1000))


def with_fos(system: System, u: Floats, y: Floats, later: Floats, begin: Floats) -> Floats:
    """FosRegressor, which stops by itself before the most terms."""
    model = fos.FosRegressor(max_lag=system.max_lag, input_lags=system.max_lag, degree=2, max_terms=system.terms + 4)
    model.fit(u, y)
    _chosen.append({term.monomial for term in model.terms_})
    return np.concatenate([begin, model.predict(later, y_init=begin)])


def with_sysidentpy(system: System, u: Floats, y: Floats, later: Floats, begin: Floats) -> Floats:
    """FROLS, which chooses the number of terms by AIC."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    # its candidates begin at x(k−1): where today's input counts, it is given one sample early
    early = 1 if system.input_today else 0
    lags = list(range(1, system.max_lag + early + 1))
    model: Any = FROLS(
        order_selection=True,
        n_info_values=system.terms + 4,
        ylag=system.max_lag,
        xlag=lags if system.inputs == 1 else [lags] * system.inputs,
        info_criteria="aic",
        estimator=LeastSquares(),
        basis_function=Polynomial(degree=2),
    )

    def shifted(inputs: Floats) -> Floats:
        return np.vstack([inputs[early:], inputs[len(inputs) - early :]])

    model.fit(X=shifted(u), y=y.reshape(-1, 1))
    start = begin[: model.max_lag].reshape(-1, 1)
    return np.asarray(model.predict(X=shifted(later), y=start), float).ravel()


def with_fastcan(system: System, u: Floats, y: Floats, later: Floats, begin: Floats) -> Floats:
    """make_narx with as many terms as the system has: it does not choose their number."""
    from fastcan.narx import make_narx

    model: Any = make_narx(X=u, y=y, n_terms_to_select=system.terms, max_delay=system.max_lag, poly_degree=2, verbose=0)
    model.fit(u, y)
    return np.asarray(model.predict(later, y_init=begin), float).ravel()


_chosen: list[set[str]] = []
PACKAGES = {"fos-imu": with_fos, "SysIdentPy": with_sysidentpy, "fastcan": with_fastcan}


def main() -> None:
    """All systems, noises and packages."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    rows: list[tuple[str, float, str, float, float, float]] = []
    runs: dict[tuple[str, str], tuple[Floats, Floats]] = {}
    for system in SYSTEMS:
        for noise in (0.001, 0.1):
            errors: dict[str, list[float]] = {name: [] for name in PACKAGES}
            seconds = dict.fromkeys(PACKAGES, 0.0)
            _chosen.clear()
            for seed in range(SEEDS):
                u, y = data(system, seed, noise)
                clean_u, _ = data(system, 1000 + seed, 0.0)
                truth = system.run(clean_u, np.zeros(len(clean_u)))
                for name, package in PACKAGES.items():
                    begun = time.perf_counter()
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        run = package(system, u, y, clean_u[:200], truth[:BEGIN])
                    seconds[name] += time.perf_counter() - begun
                    left = run[BEGIN:200] - truth[BEGIN:200]
                    errors[name].append(float(np.sqrt(np.mean(left**2)) / truth.std()))
                    if seed == 0 and noise == 0.1:
                        runs[system.name, name] = (truth[:200], run[:200])
            right = sum(chosen == set(system.true_terms) for chosen in _chosen)
            print(f"{system.name}, noise {noise:.1%}: fos-imu chose the true terms in {right} of {SEEDS}")
            for name, found in errors.items():
                worst, median = float(np.max(found)), float(np.median(found))
                rows.append((system.name, noise, name, median, worst, seconds[name] / SEEDS))
    text = table(rows)
    print(text)
    if folder is not None:
        (folder / "beside_others.md").write_text(text, encoding="utf-8")
        figure(runs, folder / "beside_others.svg")


def table(rows: list[tuple[str, float, str, float, float, float]]) -> str:
    """Markdown."""
    head = "| system of | noise | package | free-run error, median of 20 | worst of 20 | seconds a fit and run |\n"
    line = "| {} | {:.1%} | {} | {:.2e} | {:.2e} | {:.3f} |\n"
    return head + "|---|---|---|---|---|---|\n" + "".join(line.format(*row) for row in rows)


def figure(runs: dict[tuple[str, str], tuple[Floats, Floats]], path: Path) -> None:
    """The first validation run at 10 % noise, and what each leaves of it."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "fos"
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(2, len(SYSTEMS), figsize=(11, 5), sharex=True)
    for column, system in enumerate(SYSTEMS):
        above, below = panels[0][column], panels[1][column]
        for name, colour in zip(PACKAGES, ("#0072b2", "#d55e00", "#009e73"), strict=True):
            truth, run = runs[system.name, name]
            if name == "fos-imu":
                above.plot(truth, color="#222222", linewidth=1, label="true, without noise")
            below.plot(run - truth, color=colour, linewidth=1, label=name)
            above.plot(run, color=colour, linewidth=0.7, linestyle="--", label=name)
        above.set_title(f"the system of {system.name}")
        above.legend(fontsize=7)
        below.set_xlabel("sample")
        below.set_ylabel("run − true")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main()
