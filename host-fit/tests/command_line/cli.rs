//! The command line as a session: every subcommand, and its errors.

use crate::session::{done, fails, stderr_of};

#[test]
fn a_session_goes_from_a_log_to_a_corrected_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "log.csv.gz", "--minutes", "3", "--seed", "4", "--at-rest"]);
    let fitted =
        done(folder, &["fit", "log.csv.gz", "--axis", "gx,gz", "--physical", "temp_c", "-o", "unit.json"]);
    assert!(fitted.contains("gx_rads") && fitted.contains("slow error before"), "{fitted}");
    let compared = done(folder, &["compare", "unit.json", "--details", "--figures", "figures"]);
    assert!(compared.contains("noise floor") && compared.contains("free run, 10 s ahead"), "{compared}");
    assert!(compared.contains("best lag") && compared.contains("by time and frequency"), "{compared}");
    assert!(compared.contains("Heading error after 10 s without aiding: "), "{compared}");
    assert!(
        compared.contains("Heading error after 10 min without aiding: too few windows at rest (0 of 3"),
        "{compared}"
    );
    // a line for each axis before the details
    let details = compared.find("\ngx_rads: ").expect("the details");
    let (summary, _) = compared.split_at(details);
    for axis in ["gx_rads", "gz_rads"] {
        let line = summary.lines().find(|line| line.trim_start().starts_with(axis)).expect("a line");
        assert!(line.contains("°/") && line.contains(" %") && line.contains("depends on"), "{line}");
    }
    let one = done(folder, &["fit", "log.csv.gz", "--axis", "gx", "-o", "one.json"]);
    assert!(!one.contains("physical part"), "{one}");
    for arguments in
        [&["fit", "log.csv.gz", "-o", "six.json"][..], &["compare", "six.json"], &["diagnose", "log.csv.gz"]]
    {
        let summary = done(folder, arguments);
        assert!(summary.lines().count() <= 40, "{arguments:?}: {summary}");
        assert!(summary.contains("--details") && !summary.contains("dps"), "{summary}");
        if arguments[0] == "compare" {
            let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
            let row =
                |text: &str| summary.lines().map(words).find(|line| line.contains(text)).expect("a row");
            assert_eq!(row("gz_rads heading error, °").matches(" → ").count(), 2, "{summary}");
            assert!(row("ax_mps2 position error, m").ends_with("too few"), "{summary}");
        }
    }
    let si = done(folder, &["compare", "unit.json", "--units", "si"]);
    assert!(si.contains(" rad/s ") && !si.contains('°'), "{si}");
    for figure in ["1_over_time", "2_residual", "3_autocorrelation", "4_spectrum", "5_allan", "6_dependence"]
    {
        for format in ["svg", "png"] {
            let path = folder.join(format!("figures/gx_rads_{figure}.{format}"));
            assert!(path.metadata().is_ok_and(|file| file.len() > 1000), "{}", path.display());
        }
    }
    done(
        folder,
        &["export", "unit.json", "--image", "unit.fosm", "--rust", "model.rs", "--sensor", "demo part"],
    );
    done(folder, &["export", "unit.json", "--c", "gyro-x.h", "--sensor", "demo part"]);
    let header = std::fs::read_to_string(folder.join("gyro-x.h")).expect("written");
    assert!(header.contains("static inline int gyro_x_check(") && header.contains("demo part"), "{header}");
    assert!(fails(folder, 1, &["export", "unit.json", "--c", "1.h"]).contains("begins with a letter"));
    assert!(fails(folder, 1, &["export", "unit.json"]).contains("--c FILE"));
    let inspected = done(folder, &["inspect", "unit.fosm"]);
    assert!(
        inspected.contains("demo part") && inspected.contains("gyro x: ") && inspected.contains("temp_c"),
        "{inspected}"
    );
    let replayed = done(folder, &["replay", "unit.fosm", "log.csv.gz", "-o", "corrected.parquet"]);
    assert!(replayed.contains("digest of the innovations"), "{replayed}");
    // once more, and from the corrected log's own reader
    assert_eq!(replayed, done(folder, &["replay", "unit.fosm", "log.csv.gz", "-o", "corrected.parquet"]));
    let again =
        done(folder, &["fit", "corrected.parquet", "--axis", "gx", "--memory", "none", "-o", "again.json"]);
    assert!(again.contains("gx_rads"), "{again}");
}

/// Text is in the units of data sheets, JSON in SI.
#[test]
fn reports_are_in_field_units_and_state_the_error_without_aiding() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "log.parquet", "--minutes", "3", "--seed", "4", "--at-rest"]);
    done(folder, &["fit", "log.parquet", "--axis", "gx,ax", "--physical", "temp_c", "-o", "unit.json"]);
    for (axis, unit, si, quantity) in [
        ("gx", "°", "rad/s", "heading error after 10 s, °"),
        ("ax", "mg", "m/s²", "position error after 10 s, m"),
    ] {
        let arguments = ["report", "unit.json", "--from", "log.parquet", "--axis", axis];
        for file in ["report.md", "report.html"] {
            done(folder, &[&arguments[..], &["-o", file]].concat());
            let text = std::fs::read_to_string(folder.join(file)).expect("written");
            assert!(text.contains(&format!("RMS in {unit}")) && !text.contains(si), "{file} of {axis}");
            assert!(text.contains(quantity) && text.contains("too few windows"), "{file} of {axis}");
        }
        let json = done(folder, &[&arguments[..], &["--json"]].concat());
        let report: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        let section = &report["axes"][0]["section"];
        assert_eq!(section["unit"], si);
        let ten_seconds = &section["comparison"]["errors"][3]["unaided"][1];
        let found = &ten_seconds[if axis == "gx" { "heading_rad" } else { "position_m" }];
        let [rms, low, high] = ["rms", "low", "high"].map(|name| found[name].as_f64().expect("a number"));
        assert!(0.0 < low && low < rms && rms < high, "{ten_seconds}");
    }
}

/// Exports fail early with the error that a device would give on loading.
#[test]
fn export_names_the_hub_that_rejects_the_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "log.parquet", "--minutes", "1", "--at-rest"]);
    let fit = ["fit", "log.parquet", "--axis", "gx", "--method", "yule-walker", "-o", "unit.json"];
    done(folder, &[&fit[..], &["--max-lag", "10"]].concat());
    let exported = done(folder, &["export", "unit.json", "--image", "a.fosm", "--c", "a.h"]);
    assert!(exported.contains("samples per second, within 10 %, with raw values"), "{exported}");

    done(folder, &[&fit[..], &["--max-lag", "140"]].concat());
    let warned = stderr_of(folder, &["export", "unit.json", "--image", "b.fosm", "--rust", "b.rs"]);
    for part in
        ["warning: the hub of the C interface", "140 terms (room for 128)", "--max-terms", "Hub<0, 140, 256>"]
    {
        assert!(warned.contains(part), "{part}: {warned}");
    }
    assert!(folder.join("b.fosm").exists());
    // Rust source defines a hub that is large enough, a C header does not
    assert_eq!(stderr_of(folder, &["export", "unit.json", "--rust", "b.rs"]), "");
    let refused = fails(folder, 1, &["export", "unit.json", "--image", "c.fosm", "--c", "c.h"]);
    assert!(refused.contains("error: the hub of the C interface") && refused.contains("help:"), "{refused}");
    assert!(!folder.join("c.h").exists() && !folder.join("c.fosm").exists());
}

#[test]
fn json_is_json_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "log.parquet", "--minutes", "2", "--at-rest"]);
    for arguments in [
        &["fit", "log.parquet", "--axis", "gy", "-o", "unit.json", "--json"][..],
        &["compare", "unit.json", "--json"],
    ] {
        let text = done(folder, arguments);
        let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert!(value["axes"][0]["column"] == "gy_rads", "{arguments:?}");
    }
    done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
    let image: serde_json::Value =
        serde_json::from_str(&done(folder, &["inspect", "unit.fosm", "--json"])).expect("JSON");
    assert_eq!(image["format_version"], 1);
    let replayed = done(folder, &["replay", "unit.fosm", "log.parquet", "--hub-log", "hub.fosh", "--json"]);
    let replayed: serde_json::Value = serde_json::from_str(&replayed).expect("JSON");
    assert!(replayed["axes"][0]["innovation_rms_f32"].as_f64().is_some_and(|rms| rms > 0.0));
    let digest = replayed["hub_outputs_digest"].as_str().expect("that of the log");
    assert!(digest.len() == 16 && u64::from_str_radix(digest, 16).is_ok(), "{digest}");
}

/// A log with this sampling rate, at rest or not by its own flag; gyro x has only noise, no model.
fn log_at(rate_hz: f64, still: bool) -> String {
    let noise = |n: u32| f64::from(n.wrapping_mul(2_654_435_761) >> 16) / 65_536.0 - 0.5;
    let row =
        |n: u32| format!("{},{},{}\n", f64::from(n) / rate_hz, 0.01 + 0.001 * noise(n), u8::from(still));
    let rows: String = (0..6000).map(row).collect();
    format!("t_s,gx_rads,still\n{rows}")
}

/// Follows the rule of the hub, which refuses such a sensor.
#[test]
fn replay_refuses_a_log_of_another_rate_as_the_hub_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (name, rate_hz) in [("fit.csv", 100.0), ("near.csv", 108.0), ("far.csv", 113.0), ("half.csv", 50.0)] {
        std::fs::write(folder.join(name), log_at(rate_hz, true)).expect("written");
    }
    done(folder, &["fit", "fit.csv", "--axis", "gx", "-o", "unit.json"]);
    done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
    done(folder, &["replay", "unit.fosm", "near.csv"]);
    for (log, periods) in
        [("far.csv", ["0.008850 s", "0.010000 s"]), ("half.csv", ["0.020000 s", "0.010000 s"])]
    {
        let refused = fails(folder, 1, &["replay", "unit.fosm", log, "-o", "out.csv"]);
        for part in [log, periods[0], periods[1], "10 %", "help:", "--rate"] {
            assert!(refused.contains(part), "{part}: {refused}");
        }
        assert!(!folder.join("out.csv").exists());
    }
}

/// Used to print "NaN" for the cost of f32, and a root mean square of 0.
#[test]
fn replay_without_rest_reports_that_nothing_is_comparable() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("fit.csv"), log_at(100.0, true)).expect("written");
    std::fs::write(folder.join("moving.csv"), log_at(100.0, false)).expect("written");
    done(folder, &["fit", "fit.csv", "--axis", "gx", "-o", "unit.json"]);
    done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
    let replayed = done(folder, &["replay", "unit.fosm", "moving.csv"]);
    assert!(!replayed.contains("NaN"), "{replayed}");
    assert!(replayed.contains("–: no row at rest") && replayed.contains("help: "), "{replayed}");
    let json: serde_json::Value =
        serde_json::from_str(&done(folder, &["replay", "unit.fosm", "moving.csv", "--json"])).expect("JSON");
    let axis = &json["axes"][0];
    assert_eq!(axis["innovations"], 0);
    for key in ["innovation_rms_f32", "innovation_rms_f64", "largest_difference", "valid_share"] {
        assert!(axis[key].is_null(), "{key}: {axis}");
    }
}

#[test]
fn errors_state_place_and_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");

    assert!(fails(folder, 1, &["fit", "absent.csv"]).contains("absent.csv"));
    write("rubbish.csv", "t_s,gx_rads\n0.0,0.1\n0.01,oops\n0.02,0.3\n0.03,0.2\n");
    let message = fails(folder, 1, &["fit", "rubbish.csv", "--strict"]);
    assert!(message.contains("rubbish.csv:3:2") && message.contains("oops"), "{message}");
    write("timeless.csv", "gx_rads\n0.1\n0.2\n");
    let message = fails(folder, 1, &["fit", "timeless.csv"]);
    assert!(message.contains("t_s") && message.contains("rate"), "{message}");
    let constant: String = (0..3000).map(|n| format!("{},0.5\n", f64::from(n) * 0.01)).collect();
    write("constant.csv", &format!("t_s,gx_rads\n{constant}"));
    let message = fails(folder, 1, &["fit", "constant.csv"]);
    assert!(message.contains("gx_rads") && message.contains("0.5"), "{message}");
    let short: String =
        (0..50).map(|n| format!("{},{}\n", f64::from(n) * 0.01, f64::from(n * n % 7))).collect();
    write("short.csv", &format!("t_s,gx_rads\n{short}"));
    let message = fails(folder, 1, &["fit", "short.csv"]);
    assert!(message.contains("help: a longer log, a larger --train") && !message.contains('`'), "{message}");
    let message = fails(folder, 1, &["fit", "short.csv", "--axis", "gy"]);
    assert!(message.contains("gy_rads"), "{message}");

    write("study.json", "{\"schema\": \"fos-study/99\"}");
    let message = fails(folder, 1, &["compare", "study.json"]);
    assert!(message.contains("fos-study/99") && message.contains("fos-study/1"), "{message}");
    write("broken.json", "{\"schema\": \"fos-study/1\",\n oops");
    assert!(fails(folder, 1, &["export", "broken.json", "--image", "x.fosm"]).contains("broken.json:2"));
    assert!(!folder.join("x.fosm").exists());
    write("not.fosm", "hello, this is no image at all");
    assert!(fails(folder, 1, &["inspect", "not.fosm"]).contains("FOSM"));
}

#[test]
fn wrong_usage_is_exit_code_two() {
    let folder = tempfile::tempdir().expect("a folder");
    for arguments in [
        &["nonsense"][..],
        &["fit"],
        &["fit", "log.csv", "--degree", "4"],
        &["fit", "log.csv", "--train", "soon"],
    ] {
        fails(folder.path(), 2, arguments);
    }
}

#[test]
fn the_classical_methods_take_the_same_path_as_fos() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "hour.parquet", "--band-limited", "--minutes", "2", "--seed", "3"]);
    for method in ["yule-walker", "covariance", "modified-covariance", "burg"] {
        let arguments = ["fit", "hour.parquet", "--axis", "ay", "--method", method, "--max-lag", "4"];
        let fitted = done(folder, &[&arguments[..], &["-o", "study.json"]].concat());
        assert!(fitted.contains(method) && fitted.contains("all lags to 4"), "{fitted}");
        done(folder, &["export", "study.json", "--image", "unit.fosm"]);
        let inspected = done(folder, &["inspect", "unit.fosm"]);
        assert!(inspected.contains("r(n-4)") && !inspected.contains("r(n-5)"), "{inspected}");
        done(folder, &["replay", "unit.fosm", "hour.parquet", "-o", "corrected.parquet"]);
    }
    let arguments = ["fit", "hour.parquet", "--axis", "ay", "-o", "study.json", "--denoise", "db4:3:soft"];
    let denoised = done(folder, &[&arguments[..], &["--method", "burg"]].concat());
    assert!(denoised.contains("0 to 12.5"), "three levels at 200 Hz leave 12.5 Hz: {denoised}");
    let refused = fails(folder, 1, &arguments);
    assert!(refused.contains("fos is fitted to the data as measured"), "{refused}");
    let refused = fails(folder, 2, &["fit", "hour.parquet", "--method", "burgh"]);
    assert!(refused.contains("yule-walker") && refused.contains("burg"), "{refused}");
}

#[test]
fn the_papers_tables_and_figures_come_from_any_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "hour.parquet", "--band-limited", "--minutes", "2"]);
    let arguments = ["table", "hour.parquet", "--axis", "ay", "--train", "40", "--evaluate", "20"];
    let tables = done(folder, &[&arguments[..], &["--degree", "2", "--figures", "figures"]].concat());
    for text in
        ["largest output lag) 1", "largest output lag) 10", "de-noised, burg", "fos, CP 2", "0 to 6.25"]
    {
        assert!(tables.contains(text), "{text}: {tables}");
    }
    for figure in ["autocorrelation", "samples", "mse_by_order"] {
        for format in ["svg", "png"] {
            let path = folder.join(format!("figures/ay_mps2_{figure}.{format}"));
            assert!(path.metadata().is_ok_and(|file| file.len() > 1000), "{}", path.display());
        }
    }
    let markdown = done(folder, &[&arguments[..], &["--degree", "1", "--markdown"]].concat());
    assert!(markdown.contains("|---"), "{markdown}");
    let json = done(folder, &[&arguments[..], &["--degree", "1", "--max-order", "2", "--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON and nothing else");
    assert_eq!(json["axes"][0]["cells"].as_array().expect("cells").len(), 9 * 2);
    let refused = fails(folder, 1, &["table", "hour.parquet", "--axis", "ay"]);
    assert!(refused.contains("--train"), "{refused}");
}

#[test]
fn fits_several_logs_without_splicing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (log, seed) in [("a.parquet", "1"), ("b.parquet", "2")] {
        done(folder, &["simulate", log, "--band-limited", "--minutes", "1", "--seed", seed]);
    }
    let arguments = ["fit", "a.parquet", "b.parquet", "--axis", "ay", "--memory", "none", "--train", "90s"];
    let fitted = done(folder, &[&arguments[..], &["-o", "study.json"]].concat());
    // 60 s and 30 s at 200 Hz, the first ten rows of each without their lags
    assert!(fitted.contains("2 segments,") && fitted.contains("over 17980 rows"), "{fitted}");
    let compared = done(folder, &["compare", "study.json"]);
    assert!(compared.contains("ay_mps2"), "{compared}");
    // a log other than the fitted one is rejected
    done(folder, &["simulate", "b.parquet", "--band-limited", "--minutes", "1", "--seed", "3"]);
    let refused = fails(folder, 1, &["compare", "study.json"]);
    assert!(refused.contains("b.parquet: not the log that study.json was made with"), "{refused}");
}

#[test]
fn simulates_a_case_with_the_requested_effect() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let arguments = ["simulate", "--case", "case_9", "--setup", "pose-rig", "--target", "gy", "--seed", "7"];
    let message = done(
        folder,
        &[&arguments[..], &["--effect", "thermal_lag:tau_s=60", "--effect", "g_sensitivity", "--size", "40"]]
            .concat(),
    );
    assert!(message.contains("thermal_lag of size 40.0, g_sensitivity of size 40.0 in gy_rads"), "{message}");
    let meta = std::fs::read_to_string(folder.join("case_9/meta.json")).expect("written");
    assert!(meta.contains("fos-case/1") && meta.contains("\"case_9\"") && !meta.contains("thermal_lag"));
    let truth = std::fs::read_to_string(folder.join("case_9/truth.json")).expect("written");
    assert!(truth.contains("\"tau_s\": 60.0"));
    for log in ["reference", "log", "evaluation", "truth_log", "truth_evaluation"] {
        assert!(folder.join(format!("case_9/{log}.parquet")).is_file(), "{log}");
    }
    for (effect, choices) in [
        ("thermal_drag", "outside:recoveries"),
        ("thermal_lag:tau=60", "tau_s, usually 15 to 200"),
        ("thermal_lag:tau_s=warm", "is no number"),
        ("bias_ramp:tau_s=60", "has no parameter"),
        ("load_heating", "a gyro in the set-up desk"),
    ] {
        let message = fails(folder, 1, &[&arguments[..], &["--effect", effect]].concat());
        assert!(message.contains(choices), "{message}");
    }
    fails(folder, 2, &["simulate", "--case", "case_9", "--minutes", "3"]);
    fails(folder, 2, &["simulate", "log.csv", "--effect", "bias_ramp"]);
    fails(folder, 2, &["simulate", "--suite", "3"]);
}

#[test]
fn a_suite_is_a_folder_of_cases() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = done(folder.path(), &["simulate", "--suite", "2", "cases", "--seed", "3"]);
    assert!(message.contains("2 cases"), "{message}");
    for case in ["case_000", "case_001"] {
        assert!(folder.path().join("cases").join(case).join("meta.json").is_file(), "{case}");
    }
}
