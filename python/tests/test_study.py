import dataclasses
import inspect
import json
import math
import pickle
import re

import fos_imu as fos
import numpy as np
import pytest
from fos_imu import _engine
from fos_imu.errors import EffectError, FitError, RefineError, StudyError


def test_the_planted_effect_is_named_added_and_taken_back(case, study):
    diagnosis = study.diagnose(case.log)
    assert diagnosis.verdict == "missing"
    finding = diagnosis.findings[0]
    assert finding.effect == "thermal_lag"
    low, high = finding.predicted_reduction_interval
    assert 0 < low <= finding.predicted_reduction <= high <= 1
    assert finding.cost is not None
    assert finding.evidence is not None
    assert len(finding.evidence.time_s) == len(finding.evidence.error) == len(finding.evidence.effect)
    before = study.compare(case.evaluation)["gx"].model
    refinement = study.add(finding, case.log)
    assert [step.name for step in refinement.steps] == ["before", "+ thermal_lag"]
    assert refinement.steps[-1].added.measured_reduction > 0.5
    after = study.compare(case.evaluation)["gx"].model
    assert after.slow_error_coast < 0.5 * before.slow_error_coast
    # the logs are remembered
    assert study.diagnose().findings == ()
    with pytest.raises(RefineError, match="in the model already"):
        study.add("thermal_lag")
    assert study.undo() == "thermal_lag"
    with pytest.raises(RefineError, match="nothing was added"):
        study.undo()
    assert len(study.history[0].steps) == 1


def test_what_is_left_is_there_row_by_row(case, study):
    comparison = study.compare(case.evaluation)
    axis = comparison["gx_rads"]
    assert axis.time_s.shape == axis.measured.shape == axis.innovation.shape == axis.left.shape
    one_step = axis.innovation[np.isfinite(axis.innovation)]
    assert np.mean(one_step**2) == pytest.approx(axis.model.one_step_mse, rel=1e-9)
    known = np.isfinite(axis.predicted)
    assert known.mean() > 0.5
    np.testing.assert_allclose((axis.predicted + axis.left)[known], axis.measured[known], atol=1e-12)
    assert [errors.model for errors in axis.errors][-1] == "model"
    own = study.compare()
    assert own.evaluated_s[0] >= case.reference.time_s[case.reference.n_rows // 2 - 1]
    with pytest.raises(KeyError):
        comparison["gy"]


def test_a_study_opens_in_the_program_and_the_other_way_round(case, study, tmp_path, program):
    for name in ("reference", "log", "evaluation"):
        getattr(case, name).write(tmp_path / f"{name}.parquet")
    reference, log = fos.read(tmp_path / "reference.parquet"), fos.read(tmp_path / "log.parquet")
    ours = fos.fit(reference, axes="gx")
    ours.add("thermal_lag", log)
    ours.save(tmp_path / "ours.json")
    program("fit", "reference.parquet", "--axis", "gx", "-o", "theirs.json", folder=tmp_path)
    program("add", "theirs.json", "thermal_lag", "--from", "log.parquet", folder=tmp_path)
    # the same file but for the paths as they were given
    ours_json, theirs_json = ((tmp_path / f"{name}.json").read_text() for name in ("ours", "theirs"))
    assert ours_json.replace(f"{tmp_path}/", "") == theirs_json.replace(f"{tmp_path}/", "")

    told = program("compare", "ours.json", "evaluation.parquet", "--json", folder=tmp_path)
    mine = fos.Study.load(tmp_path / "theirs.json").compare(fos.read(tmp_path / "evaluation.parquet"))
    assert told["axes"][0]["errors"][-1]["one_step_mse"] == mine["gx"].model.one_step_mse
    assert told["axes"][0]["errors"][-1]["slow_error_coast"] == mine["gx"].model.slow_error_coast

    program("undo", "ours.json", folder=tmp_path)
    assert len(fos.Study.load(tmp_path / "ours.json").history[0].steps) == 1
    # logs are found again beside the study
    again = fos.Study.load(tmp_path / "theirs.json")
    assert again.diagnose().verdict == "nothing_missing"
    assert again.undo() == "thermal_lag"
    again.save()
    history = program("history", "theirs.json", "--json", folder=tmp_path)
    assert len(history[0]["steps"]) == 1

    diagnosis = program("diagnose", "theirs.json", "--from", "log.parquet", "--json", folder=tmp_path)[0]
    mine = fos.Study.load(tmp_path / "theirs.json").diagnose(log)
    assert (diagnosis["sentence"], diagnosis["findings"][0]["score"]) == (mine.sentence, mine.findings[0].score)
    program("export", "theirs.json", "--image", "theirs.fosm", "--sensor", "unit 7", folder=tmp_path)
    assert again.export_image("unit 7") == (tmp_path / "theirs.fosm").read_bytes()


def test_a_study_of_arrays_names_what_it_was_fitted_to(case, study, tmp_path):
    study.save(tmp_path / "unit.json")
    again = fos.Study.load(tmp_path / "unit.json")
    assert again.axes == study.axes == ("gx_rads",)
    assert again.sources == case.reference.sources
    assert again.export_image() == study.export_image()
    # the log itself is in no file
    with pytest.raises(fos.FosError, match="not there"):
        again.compare()
    assert again.compare(case.evaluation)["gx"].rows > 0
    assert again.diagnose(case.log, reference=case.reference).findings[0].effect == "thermal_lag"


def test_a_file_is_not_written_over_what_somebody_else_wrote(study, tmp_path):
    path = tmp_path / "unit.json"
    study.save(path)
    study.save(path)
    other = tmp_path / "other.json"
    other.write_text("{}")
    with pytest.raises(StudyError, match="there is a file already"):
        study.save(other)
    study.save(other, replace=True)
    study.save(path, replace=True)
    path.write_text(path.read_text() + " ")
    with pytest.raises(StudyError, match="changed meanwhile"):
        study.save()
    study_again = fos.Study.load(path)
    study_again.save()
    path.write_text("{\n  x")
    with pytest.raises(StudyError) as bad:
        fos.Study.load(path)
    assert (bad.value.file, bad.value.line) == (str(path), 2)
    with pytest.raises(TypeError, match="path"):
        fos.fit(fos.simulate(minutes=1), axes="gx").save()


def test_several_axes_and_several_logs(short):
    study = fos.fit([short, fos.simulate(minutes=1, seed=6)], physical=["temp_c"], axes=["gx", "ax"])
    assert study.axes == ("gx_rads", "ax_mps2")
    assert len(study.sources) == 2
    assert {fit.column for fit in study.fits} == set(study.axes)
    assert [axis.column for axis in study.compare(short)] == list(study.axes)
    with pytest.raises(StudyError, match="several axes"):
        study.diagnose(short)
    with pytest.raises(StudyError, match="no axis gz"):
        study.undo("gz")


def test_what_cannot_be_fitted_says_why(short):
    for options, says in (
        ({"method": "fox"}, "not one of"),
        ({"degree": 4}, "degree is 1, 2 or 3"),
        ({"memory_s": [-1.0]}, "not a positive time"),
        ({"physical": ["temp_c:lowpas(1)"]}, "not one of identity"),
        ({"train": "half"}, "neither like 50% nor like 180s"),
        ({"max_lag": 500}, "help: a longer log"),
    ):
        with pytest.raises(FitError, match=says):
            fos.fit(short, axes="gx", **options)
    with pytest.raises(EffectError, match="did you mean"):
        fos.fit(short, axes="gx").add("termal_lag", short)


def test_the_defaults_are_those_of_the_engine():
    defaults = json.loads(_engine.fit_defaults())
    said = {name: one.default for name, one in inspect.signature(fos.fit).parameters.items()}
    for name in (
        "max_lag",
        "degree",
        "input_lags",
        "max_terms",
        "stop",
        "search",
        "method",
        "offset",
        "scale",
        "full_scale",
    ):
        assert said[name] == defaults[name], name
    assert list(said["memory_s"]) == defaults["memory_s"]
    assert (said["train"], defaults["train"]) == ("50%", {"share": 0.5})
    assert (said["factory_corrected"], defaults["fitted_on"]) == (False, "Raw")


def test_an_effect_of_ones_own(case, study, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        'id = "my_lag"\nname = "my lag"\nband = "slow"\nmechanism = "m"\nequation = "e"\nexperiment = "x"\n'
        '[[terms]]\nregressor = "temp_c:lowpass({tau_s})"\ngyro = "dps/K"\n'
        '[parameter]\nname = "tau_s"\nunit = "s"\nlow = 5\nhigh = 400\n'
    )
    assert fos.effects([path])["my_lag"].name == "my lag"
    assert study.add("my_lag", case.log, effects=[path]).steps[-1].added.measured_reduction > 0.5
    path.write_text("id = 7\n")
    with pytest.raises(EffectError) as bad:
        fos.effects([path])
    assert (bad.value.file, bad.value.line) == (str(path), 1)


def test_a_diagnosis_without_a_model(case):
    diagnosis = fos.diagnose(case.log, axis="gx", reference=case.reference, evaluate_on=case.evaluation)
    finding = diagnosis.findings[0]
    assert finding.effect == "thermal_lag"
    assert finding.measured_reduction is not None
    assert finding.evidence is not None
    error, effect = np.array(finding.evidence.error), np.array(finding.evidence.effect)
    assert np.corrcoef(error, effect)[0, 1] > 0.8
    nothing = fos.diagnose(case.reference, axis="gx")
    assert nothing.verdict == "nothing_missing"
    assert "#00734f" in nothing._repr_html_()


def test_a_card_rounds_the_time_constant_of_a_regressor(case):
    finding = fos.diagnose(case.log, axis="gx", reference=case.reference).findings[0]
    assert "lowpass" in finding.sizes[0].of
    card = finding._repr_html_()
    assert ">size<" in card
    assert "lowpass" not in card
    lag = dataclasses.replace(finding.sizes[0], of="temp_c:lowpass(20.023247)")
    assert "size of temp_c:lowpass(20)" in dataclasses.replace(finding, sizes=(lag, lag))._repr_html_()


def test_a_line_has_its_spectrum():
    case = fos.simulate_case([fos.Plant("spectral_line", 80.0)], seed=4, reference_s=120, log_s=300, evaluation_s=60)
    finding = fos.diagnose(case.log, axis="gx", reference=case.reference).findings[0]
    assert finding.effect == "spectral_line"
    assert finding.line is not None
    peak = finding.line.frequency_hz[int(np.argmax(finding.line.density))]
    assert peak == pytest.approx(finding.line.line_hz, rel=0.02)
    assert finding.figure is not None
    assert "the line at" in finding.figure.svg()


def test_results_are_frozen_and_show_themselves(case, study):
    diagnosis = study.diagnose(case.log)
    refinement = study.add(None, case.log)
    comparison = study.compare(case.evaluation)
    for result in (
        diagnosis,
        diagnosis.findings[0],
        comparison,
        comparison["gx"],
        refinement,
        study,
        *fos.effects().values(),
    ):
        page = result._repr_html_()
        assert page.count("<div") == page.count("</div>"), type(result)
        assert not re.search(r"\bnan\b", page), type(result)
    for result in (diagnosis, comparison, comparison["gx"], refinement):
        with pytest.raises(dataclasses.FrozenInstanceError):
            result.unit = "furlong"
    with pytest.raises(TypeError):
        diagnosis.findings[0].params["tau_s"] = 1.0


def test_figures_are_those_of_a_report(case, study, program, tmp_path):
    study.save(tmp_path / "study.json")
    case.evaluation.write(tmp_path / "evaluation.parquet")
    program("compare", "study.json", "evaluation.parquet", "--figures", "figures", folder=tmp_path)
    drawn = {path.stem.split("_", 2)[2].split("_", 1)[1]: path for path in (tmp_path / "figures").glob("*.svg")}
    # without the fitted log, as the program, which cannot open a log made of arrays
    again = fos.Study.load(tmp_path / "study.json")
    figures = again.compare(fos.read(tmp_path / "evaluation.parquet"))["gx"].figures
    assert set(figures) == set(drawn) > {"over_time", "residual", "allan"}
    stored = pickle.loads(pickle.dumps(again.compare(fos.read(tmp_path / "evaluation.parquet"))["gx"]))
    assert {name: figure.svg() for name, figure in stored.figures.items()} == {
        name: figure.svg() for name, figure in figures.items()
    }
    for name, figure in figures.items():
        assert figure.svg().split(">", 1)[1] == drawn[name].read_text().split(">", 1)[1], name


def test_results_are_tables_of_pandas(case, study):
    pytest.importorskip("pandas")
    refinement = study.add("thermal_lag", case.log)
    comparison = study.compare(case.evaluation)
    steps = refinement.to_pandas()
    assert list(steps["step"]) == ["before", "+ thermal_lag"]
    assert steps["slow_left"].is_monotonic_decreasing
    models = comparison["gx"].to_pandas()
    assert models["one_step_mse"].iloc[-1] == comparison["gx"].model.one_step_mse
    assert len(comparison.to_pandas()) == len(models)
    found = fos.diagnose(case.log, axis="gx", reference=case.reference).to_pandas()
    assert found["effect"].iloc[0] == "thermal_lag"
    assert found["size_low"].iloc[0] < found["size"].iloc[0] < found["size_high"].iloc[0]


def test_text_from_outside_is_escaped(case):
    arrays = {name: case.reference[name] for name in case.reference}
    evil = fos.Recording.from_arrays({"t_s": case.reference.time_s, **arrays}, name="<script>alert(1)</script>")
    page = evil._repr_html_() + fos.fit(evil, axes="gx")._repr_html_()
    assert "<script" not in page


def test_a_log_of_another_rate_is_warned_of(study):
    other = fos.simulate(minutes=3, rate_hz=190.0, motion=False)
    with pytest.warns(fos.FosWarning, match="lags are"):
        study.compare(other)


def test_intervals_that_are_not_known_are_nan():
    from fos_imu._results import build
    from fos_imu.diagnosis import Size

    size = build(Size, {"of": "t", "value": 1, "interval": [None, 2.0], "unit": "dps", "more": 1})
    assert math.isnan(size.interval[0])
    assert (size.interval[1], size.value) == (2.0, 1.0)
