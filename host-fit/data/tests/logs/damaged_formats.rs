//! Foreign logs that are damaged, or crafted so that reading them would never end: cases found by a fuzzer, and cases
//! that it is too slow to find. Each is rejected at once, with the file's name and a remedy.

use std::fs;
use std::io::Write as _;
use std::time::{Duration, Instant};

use fos_data::recording::{LoadOptions, Recording, load};
use fos_testkit::foreign::{Flight, Rate, ulog, zip};
use tempfile::TempDir;

fn read(name: &str, bytes: &[u8]) -> Result<Recording, String> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path, &LoadOptions::default()).map_err(|error| error.to_string())
}

fn refused(name: &str, bytes: &[u8], says: &str) {
    let began = Instant::now();
    let error = read(name, bytes).map(|_| ()).unwrap_err();
    assert!(error.contains(name) && error.contains(says) && error.contains("\nhelp: "), "{error}");
    assert!(began.elapsed() < Duration::from_secs(20), "{:?}", began.elapsed());
}

fn message(kind: u8, payload: &[u8]) -> Vec<u8> {
    let mut message = (payload.len() as u16).to_le_bytes().to_vec();
    message.push(kind);
    message.extend(payload);
    message
}

#[test]
fn rejects_ulog_formats_of_excessive_size() {
    let begin = [&b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0"[..], &message(b'B', &[0; 40])].concat();
    let log = |formats: &[String], subscriptions: u16| {
        let mut log = begin.clone();
        formats.iter().for_each(|format| log.extend(message(b'F', format.as_bytes())));
        for id in 0..subscriptions {
            log.extend(message(b'A', &[&[0][..], &id.to_le_bytes(), b"a"].concat()));
        }
        log
    };
    let nested = ["a:b[32767] x;", "b:c[32767] x;", "c:d[32767] x;", "d:"].map(str::to_owned);
    let deep: Vec<String> = (0..50_000).map(|n| format!("{n}:{} x;", n + 1)).collect();
    let many: Vec<String> = (0..1000).map(|n| format!("a{n}:uint8_t[32767] x;uint8_t[32767] y;")).collect();
    for formats in [&nested[..], &deep, &many] {
        refused("a.ulg", &log(formats, 1), "too deep or too large");
    }
    // the same layout repeatedly, some megabytes each time
    refused("a.ulg", &log(&["a:uint8_t[32767] x;".to_owned()], 2000), "no inertial topic");
}

#[test]
fn chunks_that_unpack_to_a_gigabyte_are_refused() {
    let field = |name: &str, value: &[u8]| {
        let text = [name.as_bytes(), b"=", value].concat();
        [&(text.len() as u32).to_le_bytes()[..], &text].concat()
    };
    // 2000 bytes would do; the claimed size alone is sufficient
    let size = 1_u32 << 30;
    let mut packed = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
    packed.write_all(&[0; 1 << 16]).unwrap();
    let packed = packed.finish().unwrap();
    let fields =
        [field("op", &[5]), field("compression", b"bz2"), field("size", &size.to_le_bytes())].concat();
    let mut bag = b"#ROSBAG V2.0\n".to_vec();
    for part in [&fields, &packed] {
        bag.extend((part.len() as u32).to_le_bytes());
        bag.extend(part);
    }
    refused("a.bag", &bag, "a chunk of 1073741824 bytes");
}

#[test]
fn damage_in_a_container_is_not_a_system_error() {
    let flight = Flight::new(500, 5000, 1);
    let (csv, log) = (flight.csv(), ulog(&flight, Rate::Full));
    for (name, content) in [("a.csv", csv.as_bytes()), ("a.ulg", &log[..])] {
        let mut archive = zip(&[(name, content)]);
        // a bit of the last sample
        let at = 30 + name.len() + content.len() - 3;
        archive[at] ^= 1;
        refused("b.zip", &archive, "the zip archive is damaged");
    }
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&log).unwrap();
    let packed = packed.finish().unwrap();
    refused("a.ulg.gz", &packed[..packed.len() / 2], "the gzip file is damaged");
    refused("a.bag", b"#ROSBAG V2", "another version");
}

#[test]
fn errors_name_archive_and_member() {
    let linear = b"time,seconds_elapsed,z,y,x\n1,0.0,0.1,0.1,0.1\n2,0.01,0.1,0.1,0.1\n";
    refused("b.zip", &zip(&[("Accelerometer.csv", linear)]), "b.zip/Accelerometer.csv");
    // an absolute member path must not replace that of the archive
    refused("b.zip", &zip(&[("/etc/log.csv", b"")]), "b.zip/etc/log.csv");
    let rubbish = b"time,seconds_elapsed,z,y,x\n1,0.0,0.1,0.1,0.1\n2,0.01,0.1,0.1,0.1\nrubbish\n";
    refused("b.zip", &zip(&[("/etc/Gyroscope.csv", rubbish)]), "b.zip/etc/Gyroscope.csv");
}

#[test]
fn skips_rows_of_a_phone_without_a_timestamp() {
    let mut text =
        "\"Time (s)\",\"Gyroscope x (rad/s)\",\"Gyroscope y (rad/s)\",\"Gyroscope z (rad/s)\"\n".to_owned();
    for row in 0..1000 {
        let stamp = if row == 500 { String::new() } else { (100.0 + f64::from(row) * 0.01).to_string() };
        text.push_str(&format!("{stamp},0.01,0.02,{}\n", f64::from(row) * 1e-6));
    }
    // not representable as i64 nanoseconds
    text.push_str("1e300,0.01,0.02,0.03\n");
    let log = read("a.zip", &zip(&[("Gyroscope.csv", text.as_bytes())])).unwrap();
    assert_eq!((log.n_rows(), log.time_s[0], log.time_s[998]), (999, 100.0, 109.99));
    let assumed = &log.sources[0].read_as.as_ref().unwrap().assumed;
    assert!(assumed.contains("2 of 1001 rows cannot be used"), "{assumed}");
}
