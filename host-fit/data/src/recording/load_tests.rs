//! Reading of files: formats, units, damaged rows; and writing them again.

use std::io::Write;
use std::path::PathBuf;

use flate2::{Compression, write::GzEncoder};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

use super::*;
use crate::unit::Unit;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn file(folder: &TempDir, name: &str, content: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    path
}

fn load_text(text: &str) -> Result<Recording, RecordingError> {
    load_with(text, &LoadOptions::default())
}

fn load_with(text: &str, options: &LoadOptions) -> Result<Recording, RecordingError> {
    let folder = folder();
    load(file(&folder, "log.csv", text.as_bytes()), options)
}

fn mapped(specs: &[&str]) -> LoadOptions {
    LoadOptions { columns: ColumnMap::from_specs(specs).unwrap(), ..LoadOptions::default() }
}

/// A log of 100 rows at 100 Hz; `row` may replace a line.
fn log(row: impl Fn(usize) -> Option<&'static str>) -> String {
    let lines = (0..100).map(|i| match row(i) {
        Some(line) => line.to_owned(),
        None => format!("{:.2},{}", i as f64 * 0.01, i * 10),
    });
    std::iter::once("t_s,gx_rads".to_owned()).chain(lines).map(|line| line + "\n").collect()
}

#[test]
fn recognises_csv_gzip_and_parquet_by_content() {
    let folder = folder();
    let text = log(|_| None);
    let mut gz = GzEncoder::new(Vec::new(), Compression::default());
    gz.write_all(text.as_bytes()).unwrap();
    let plain = load(file(&folder, "a.parquet", text.as_bytes()), &LoadOptions::default()).unwrap();
    let zipped = load(file(&folder, "a.txt", &gz.finish().unwrap()), &LoadOptions::default()).unwrap();
    let columns = [("t_s", plain.time_s.as_slice()), ("gx_rads", &plain.channels()[0].values)];
    let path = folder.path().join("b.parquet");
    write_columns(&path, &columns).unwrap();
    std::fs::rename(&path, folder.path().join("b.csv")).unwrap();
    let columnar = load(folder.path().join("b.csv"), &LoadOptions::default()).unwrap();
    for other in [zipped, columnar] {
        assert_eq!(other.time_s, plain.time_s);
        assert_eq!(other.channels()[0].values, plain.channels()[0].values);
        assert_eq!(other.channels()[0].unit, Unit::RadianPerSecond);
        assert_ne!(other.sources[0].sha256, plain.sources[0].sha256);
    }
    assert_eq!(plain.sources[0].bytes, text.len() as u64);
}

#[test]
fn written_files_read_back() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let n = 70_000; // more than one batch
    let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 0.005).collect();
    // any bit pattern of a finite number
    let mut any: Vec<f64> = (0..n)
        .map(|_| {
            loop {
                let number = f64::from_bits(random.random());
                if number.is_finite() {
                    break number;
                }
            }
        })
        .collect();
    any[..4].copy_from_slice(&[0.0, -0.0, f64::MIN_POSITIVE / 8.0, f64::MAX]);
    any[7] = f64::NAN;
    let folder = folder();
    for name in ["a.csv", "a.csv.gz", "a.parquet"] {
        let path = folder.path().join(name);
        write_columns(&path, &[("t_s", &time), ("any, quoted", &any)]).unwrap();
        let back = load(&path, &LoadOptions::default()).unwrap();
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back.time_s), bits(&time), "{name}");
        assert_eq!(bits(&back.channel("any, quoted").unwrap().values), bits(&any), "{name}");
        assert_eq!(back.channels()[0].n_missing(), 1);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "nothing is left beside");
}

#[test]
fn rejected_writes_keep_the_old_file() {
    let folder = folder();
    let path = file(&folder, "a.csv", b"old");
    let columns: [(&str, &[f64]); 2] = [("a", &[1.0]), ("b", &[1.0, 2.0])];
    assert!(matches!(write_columns(&path, &columns), Err(RecordingError::Lengths { .. })));
    assert!(matches!(write_columns(&path, &[columns[0]; 2]), Err(RecordingError::DuplicateColumn { .. })));
    let unknown = folder.path().join("a.xlsx");
    assert!(matches!(write_columns(unknown, &columns[..1]), Err(RecordingError::UnknownFormat { .. })));
    assert_eq!(std::fs::read(path).unwrap(), b"old");
}

#[test]
fn columns_are_mapped_and_converted() {
    let text = "time;gyro;acc;T;note\n0;1000;1;212;a\n10;2000;2;32;b\n20;3000;-1;32;c\n";
    let options = mapped(&["t_s=time:ms", "gx_rads=gyro:mdps", "ax_mps2=acc:g", "temp_c=T:degF", "raw=gyro"]);
    let recording = load_with(text, &options).unwrap();
    assert_eq!(recording.time_s, [0.0, 0.01, 0.02]);
    assert!((recording.channel("gx_rads").unwrap().values[1] - 2_f64.to_radians()).abs() < 1e-15);
    assert!((recording.channel("ax_mps2").unwrap().values[2] + 9.80665).abs() < 1e-15);
    assert!((recording.channel("temp_c").unwrap().values[0] - 100.0).abs() < 1e-12);
    assert_eq!(**recording.channel("raw").unwrap().values, [1000.0, 2000.0, 3000.0]);
    assert_eq!(recording.quality.text_columns, ["note"]);
    assert!((recording.rate.true_hz - 100.0).abs() < 1e-9);
}

#[test]
fn unknown_column_in_a_map_suggests_a_similar_one() {
    let message = load_with(&log(|_| None), &mapped(&["gy_rads=gx_rad"])).unwrap_err().to_string();
    assert!(message.contains("did you mean \"gx_rads\"?"), "{message}");
}

#[test]
fn damaged_rows_are_located_counted_and_leave_a_gap() {
    let text = log(|i| match i {
        40 => Some("0.40,1\"2x"),
        41 => Some("garbage"),
        70 => Some(",700"),
        99 => Some("0.9"),
        _ => None,
    });
    let recording = load_text(&text).unwrap();
    assert_eq!(recording.quality.rows_in_file, 100);
    assert_eq!(recording.quality.rows_unusable, 4);
    assert_eq!(recording.n_rows(), 96);
    let unusable: Vec<String> = recording.quality.first_unusable.iter().map(|row| row.to_string()).collect();
    assert_eq!(unusable[0], "42:2: gx_rads: \"1\"2x\" is not a number");
    assert_eq!(unusable[1], "43: 1 cells where the header has 2: \"garbage\"");
    assert_eq!(unusable[2], "72:1: t_s: no time stamp");
    let gaps: Vec<_> =
        recording.segments.iter().map(|s| (s.rows.clone(), s.tick, s.missing_before)).collect();
    assert_eq!(gaps, [(0..40, 0, 0), (40..68, 42, 2), (68..96, 71, 1)]);
    assert_eq!(recording.quality.samples_missing, 3);
}

#[test]
fn a_quotation_mark_does_not_swallow_the_rows_after_it() {
    let recording = load_text(&log(|i| (i == 10).then_some("\"0.10,100"))).unwrap();
    assert_eq!(recording.quality.rows_unusable, 1);
    assert_eq!(recording.n_rows(), 99);
}

#[test]
fn strict_refuses_the_first_bad_row_by_name() {
    let options = LoadOptions { strict: true, ..LoadOptions::default() };
    let message = load_with(&log(|i| (i == 10).then_some("0.10,x")), &options).unwrap_err().to_string();
    assert!(message.contains("log.csv:12:2: gx_rads: \"x\" is not a number"), "{message}");
    assert!(load_with(&log(|_| None), &options).is_ok());
}

#[test]
fn more_than_a_twentieth_of_bad_rows_is_refused() {
    assert!(load_text(&log(|i| (i % 20 == 3).then_some("x,y"))).is_ok());
    let error = load_text(&log(|i| (i % 20 == 3 || i == 50).then_some("x,y"))).unwrap_err();
    assert!(matches!(error, RecordingError::TooManyBadRows { unusable: 6, rows: 100, .. }), "{error}");
    assert!(error.to_string().contains("log.csv:5:1: t_s: \"x\" is not a number"), "{error}");
}

#[test]
fn empty_and_not_finite_cells_are_missing_in_their_channel_only() {
    let text = log(|i| match i {
        5 => Some("0.05,"),
        6 => Some("0.06,nan"),
        7 => Some("0.07,-inf"),
        8 => Some("0.08, NA "),
        _ => None,
    });
    let recording = load_text(&text).unwrap();
    assert_eq!((recording.n_rows(), recording.segments.len()), (100, 1));
    let channel = recording.channel("gx_rads").unwrap();
    assert!(channel.values[5..9].iter().all(|value| value.is_nan()));
    assert_eq!(recording.held(channel)[5..10], [40.0, 40.0, 40.0, 40.0, 90.0]);
    let missing = MissingCells { column: "gx_rads".into(), empty: 2, not_finite: 2 };
    assert_eq!(recording.quality.missing_cells, [missing]);
}

#[test]
fn logs_without_timestamps_need_a_rate_and_keep_skipped_rows() {
    let mut text = String::from("gx_rads\n");
    (0..100).for_each(|i| text += if i == 30 { "#!\n?\n" } else { "1\n" });
    let message = load_text(&text).unwrap_err().to_string();
    assert!(message.contains("rate_hz") && message.contains("t_s=time:ms"), "{message}");
    let options = LoadOptions { rate_hz: Some(50.0), ..LoadOptions::default() };
    let recording = load_with(&text, &options).unwrap();
    assert_eq!(recording.rate.stamps, Stamps::Absent);
    assert_eq!(recording.segments[1].tick, 31);
    assert!((recording.time_s[30] - 0.62).abs() < 1e-12);
    assert!(load_with(&text, &LoadOptions { rate_hz: Some(-1.0), ..options }).is_err());
}

#[test]
fn a_time_column_by_another_name_is_suggested() {
    let message = load_text("timestamp,gx_rads\n0,1\n1,1\n").unwrap_err().to_string();
    assert!(message.contains("did you mean \"timestamp\"?"), "{message}");
}

#[test]
fn copies_of_a_row_are_dropped_and_repeated_stamps_kept() {
    let text = log(|i| match i {
        // the sender repeats row 49 while two samples are lost
        50 | 51 => Some("0.49,490"),
        // another sample with the timestamp of the one before
        80 => Some("0.79,800"),
        _ => None,
    });
    let recording = load_text(&text).unwrap();
    assert_eq!((recording.quality.rows_repeated, recording.quality.stamps_repeated), (2, 1));
    assert_eq!(recording.n_rows(), 98);
    assert_eq!(recording.segments[1].rows.start, 50);
    assert_eq!(recording.quality.samples_missing, 2);
}

#[test]
fn equal_rows_under_a_coarse_clock_are_measurements() {
    let mut text = String::from("t_s,temp_c\n");
    (0..1000).for_each(|i| text += &format!("{},25.5\n", i / 10));
    let recording = load_text(&text).unwrap();
    assert_eq!((recording.n_rows(), recording.segments.len()), (1000, 1));
    assert_eq!((recording.quality.rows_repeated, recording.quality.stamps_repeated), (0, 900));
    assert!((recording.rate.true_hz - 10.0).abs() < 0.01);
}

#[test]
fn segment_and_still_columns_are_understood() {
    let mut text = String::from("t_s,gx_rads,segment,still\n");
    let label = |i| if i < 40 { "rest" } else { "turned" };
    (0..100).for_each(|i| text += &format!("{:.2},1,{},{}\n", i as f64 * 0.01, label(i), i % 50 < 45));
    let recording = load_text(&text).unwrap();
    let boundaries: Vec<_> = recording.segments.iter().map(|s| (s.rows.clone(), s.boundary)).collect();
    assert_eq!(boundaries, [(0..40, Boundary::Start), (40..100, Boundary::SegmentColumn)]);
    assert_eq!(recording.quality.gaps, 0);
    assert_eq!(recording.still_rows(), [0..40, 40..45, 50..95]);
    assert_eq!(recording.channels().len(), 1);
}

#[test]
fn label_holds_until_the_next_one() {
    let label = |i| {
        if i == 0 {
            "rest"
        } else if i == 40 {
            "turned"
        } else {
            ""
        }
    };
    let rows = (0..100).map(|i| format!("{:.2},1,{}\n", f64::from(i) * 0.01, label(i)));
    let recording = load_text(&("t_s,gx_rads,segment\n".to_owned() + &rows.collect::<String>())).unwrap();
    let boundaries: Vec<_> = recording.segments.iter().map(|s| (s.rows.clone(), s.boundary)).collect();
    assert_eq!(boundaries, [(0..40, Boundary::Start), (40..100, Boundary::SegmentColumn)]);
}

#[test]
fn replaces_control_characters_in_names() {
    let recording = load_text("t_s,gx_rads,\x1b[2Jwiped\n0,1,1\n0.01,2,3\n0.02,1,2\n0.03,1,5\n").unwrap();
    assert!(recording.channel("\u{fffd}[2Jwiped").is_ok());
}

#[test]
fn split_is_contiguous_and_cuts_a_segment_in_two() {
    let recording = load_text(&log(|i| (i == 20).then_some("#"))).unwrap();
    let (first, rest) = recording.split(0.5);
    assert_eq!(first, [0..20, 20..50]);
    assert_eq!((rest.len(), rest[0].clone()), (1, 50..99));
    assert!(recording.split(1.0).1.is_empty());
}

#[test]
fn remarks_after_many_empty_cells_are_text() {
    let mut text = String::from("t_s,gx_rads,remark\n");
    (0..3000).for_each(|i| text += &format!("{},1,{}\n", i, if i == 2000 { "door" } else { "" }));
    let recording = load_text(&text).unwrap();
    assert_eq!(recording.quality.text_columns, ["remark"]);
    assert_eq!(recording.quality.rows_unusable, 0);
    assert!(recording.channel("remark").is_err());
}

#[test]
fn reads_csv_of_spreadsheets_and_loggers() {
    let text = "\u{feff}# made by x\r\n\"t_s\", gx_rads ,\r\n\r\n0.0, 1 ,\r\n0.1,\"2\",\r\n0.2,3\t,\r\n";
    let recording = load_text(text).unwrap();
    assert_eq!(**recording.channel("gx_rads").unwrap().values, [1.0, 2.0, 3.0]);
}

#[test]
fn rejects_other_files_with_the_expected_format() {
    for (text, hint) in [
        ("", "empty"),
        ("1,2\n3,4\n", "no header"),
        ("1\n3\n", "names of the columns"),
        ("t_s,t_s\n1,2\n", "two columns are named \"t_s\""),
        ("t_s,gx_rads\n1,2\n", "at least 2"),
        ("t_s,gx_rads\nx,2\ny,3\n", "\"t_s\" is needed as numbers"),
        ("t_s,gx_rads\n5,1\n5,2\n5,3\n", "do not increase"),
        // in ns, and in years
        ("t_s,gx_rads\n0,1\n5000000,2\n10000000,3\n", "a sample every 5e6 s"),
        ("t_s,gx_rads\n0,1\n1e-9,2\n2e-9,3\n", "a sample every 1e-9 s"),
        ("a,b\nx,y\n", "no column holds numbers"),
        ("t_s,gx_rads\n# x\nup,0\ndown,1\n", "log.csv:3:1: t_s: \"up\" is not a number\nhelp: check"),
        (
            "t_s;gx_rads\n0,25;0.5\n-1,5e-3;1.5\n",
            "log.csv:2:1: t_s: \"0,25\" is not a number\nhelp: write decimals",
        ),
    ] {
        let message = load_text(text).unwrap_err().to_string();
        assert!(message.contains(hint) && message.contains("\nhelp: "), "{text:?}: {message}");
    }
    assert!(matches!(load("/no/such/file", &LoadOptions::default()), Err(RecordingError::File(_))));
    let folder = folder();
    let cut = file(&folder, "cut.parquet", b"PAR1 and then nothing");
    assert!(matches!(load(cut, &LoadOptions::default()), Err(RecordingError::Parquet { .. })));
}

#[test]
fn ignores_an_axis_of_text_and_reports_it_when_needed() {
    let recording = load_text("t_s,gx_rads\n0,up\n1,down\n").unwrap();
    let error = recording.axes().unwrap_err().to_string();
    assert!(
        error.contains("gx_rads; the first is 2:2: gx_rads: \"up\"") && error.contains("help: "),
        "{error}"
    );
    // another column in its place
    let options = mapped(&["gx_rads=gyro"]);
    let recording = load_with("t_s,gx_rads,gyro\n0,up,1\n1,down,2\n", &options).unwrap();
    assert_eq!(recording.channel("gx_rads").unwrap().values[..], [1.0, 2.0]);
}

#[test]
fn damaged_compressed_log_reports_the_last_readable_line() {
    let text: String =
        (0..20_000).map(|i| format!("{},{}\n", f64::from(i) * 0.01, f64::from(i * i % 977))).collect();
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(format!("t_s,gx_rads\n{text}").as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    let folder = folder();
    let refused =
        |bytes: &[u8]| load(file(&folder, "log.csv.gz", bytes), &LoadOptions::default()).unwrap_err();
    for damaged in [packed[..packed.len() / 2].to_vec(), [&packed[..packed.len() - 8], &[0; 8]].concat()] {
        let error = refused(&damaged);
        let RecordingError::NotUnpacked { line, .. } = error else { panic!("{error}") };
        assert!(line > 1000, "{line}");
        assert!(
            error.to_string().contains(&format!("log.csv.gz:{line}: "))
                && error.to_string().contains("help: ")
        );
    }
}

#[test]
fn no_input_makes_it_panic() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let folder = folder();
    let pieces: [&[u8]; 16] = [
        b"t_s",
        b"gx_rads",
        b",",
        b",",
        b"\n",
        b"\n",
        b"\"",
        b"1e308",
        b"-1e308",
        b"0",
        b"1",
        b"2.5",
        b"nan",
        b"\x00\xff",
        b"segment",
        b"PAR1",
    ];
    for _ in 0..2000 {
        let mut bytes = if random.random() { b"t_s,segment,gx_rads\n".to_vec() } else { Vec::new() };
        for _ in 0..random.random_range(0..200) {
            bytes.extend_from_slice(pieces[random.random_range(0..pieces.len())]);
        }
        let _ = load(file(&folder, "x", &bytes), &LoadOptions::default());
    }
    for _ in 0..2000 {
        let n = random.random_range(2..60);
        let wild = [0.0, 1e308, -1e308, 1e-308, 3.0, 1e15, f64::NAN, f64::INFINITY];
        let time =
            (0..n)
                .map(|i| {
                    if random.random_range(0..4) == 0 {
                        wild[random.random_range(0..8)]
                    } else {
                        f64::from(i)
                    }
                })
                .collect();
        let labels = (0..n).map(|_| f64::from(random.random_range(0..20) / 19)).collect();
        let columns = vec![("t_s".to_owned(), time), ("segment".to_owned(), labels)];
        if let Ok(recording) = Recording::from_columns(Source::made_by("x"), columns, &LoadOptions::default())
        {
            let rows: usize = recording.segments.iter().map(|segment| segment.rows.len()).sum();
            assert_eq!(rows, recording.n_rows());
            assert!(recording.segments.windows(2).all(|pair| pair[0].tick < pair[1].tick));
        }
    }
}
