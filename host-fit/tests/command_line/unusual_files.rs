//! Unusual or malicious files: read, or refused with a description and a remedy; with bounded memory.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use flate2::Compression;
use flate2::write::GzEncoder;
use fos_data::recording::{LoadOptions, load, write_columns};
use fos_testkit::foreign::zip;

const ROWS: usize = 500;

fn text(end: &str) -> String {
    let row = |n: usize| format!("{:.3},{}{end}", n as f64 * 0.005, n * 7 % 13);
    format!("t_s,gx_rads{end}") + &(0..ROWS).map(row).collect::<String>()
}

fn packed(text: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(text).expect("into memory");
    packed.finish().expect("into memory")
}

fn utf16(text: &str, bytes: fn(u16) -> [u8; 2], mark: bool) -> Vec<u8> {
    let mark = mark.then_some(0xfeff);
    mark.into_iter().chain(text.encode_utf16()).flat_map(bytes).collect()
}

/// A Parquet file that states this codec for its columns: the value of the field after their path.
fn parquet_of(folder: &Path, codec: u8) -> Vec<u8> {
    let path = folder.join("sound.parquet");
    let (time, values): (Vec<f64>, Vec<f64>) =
        (0..ROWS).map(|n| (n as f64 * 0.005, (n * 7 % 13) as f64)).unzip();
    write_columns(&path, &[("t_s", &time), ("gx_rads", &values)]).expect("written");
    let mut bytes = fs::read(path).expect("written");
    let path_of_column = [&b"\x19\x18\x07gx_rads\x15"[..]].concat();
    let at = bytes.windows(path_of_column.len()).position(|found| found == path_of_column);
    // a zigzag number, with its sign in the lowest bit
    bytes[at.expect("the column is there") + path_of_column.len()] = 2 * codec;
    bytes
}

/// Expected result of a file: number of rows, or words of the error.
type Expected = Result<usize, [&'static str; 2]>;

fn files(folder: &Path) -> Vec<(&'static str, Vec<u8>, Expected)> {
    let lf = text("\n");
    let of = |begin: &[u8]| [begin, &[7; 100][..]].concat();
    let with = |tail: &[u8]| [&packed(lf.as_bytes())[..], tail].concat();
    vec![
        ("ends in LF", lf.clone().into(), Ok(ROWS)),
        ("ends in CRLF", text("\r\n").into(), Ok(ROWS)),
        // used to be read as one line, the names of its columns
        ("ends in CR", text("\r").into(), Ok(ROWS)),
        ("gzip of CR", packed(text("\r").as_bytes()), Ok(ROWS)),
        // used to be rejected as an invalid header
        ("gzip and zeros", with(&[0; 4096]), Ok(ROWS)),
        (
            "gzip of two members",
            [packed(&lf.as_bytes()[..100]), packed(&lf.as_bytes()[100..])].concat(),
            Ok(ROWS),
        ),
        (
            "gzip and something else",
            with(b"and this"),
            Err(["after the end of the gzip data comes something else", "help: "]),
        ),
        // used to be "no column holds numbers"
        (
            "UTF-16 with a mark",
            utf16(&lf, u16::to_le_bytes, true),
            Err(["the text is UTF-16", "iconv -f UTF-16"]),
        ),
        (
            "UTF-16, high byte first",
            utf16(&lf, u16::to_be_bytes, true),
            Err(["the text is UTF-16", "iconv -f UTF-16"]),
        ),
        (
            "UTF-16 without",
            utf16(&lf, u16::to_le_bytes, false),
            Err(["the text is UTF-16", "iconv -f UTF-16"]),
        ),
        (
            "gzip of UTF-16",
            packed(&utf16(&lf, u16::to_le_bytes, true)),
            Err(["the text is UTF-16", "iconv -f UTF-16"]),
        ),
        (
            "zeros in the header",
            b"t_s,gx_rads,a\0b\n0,1,2\n".to_vec(),
            Err(["zero bytes", "help: a log is CSV"]),
        ),
        // the help for all of these used to be "if it was cut short while being written or copied"
        (
            "Parquet with Brotli",
            parquet_of(folder, 4),
            Err(["\"gx_rads\" is compressed by Brotli", "compression=\"zstd\""]),
        ),
        (
            "Parquet with LZ4",
            parquet_of(folder, 5),
            Err(["\"gx_rads\" is compressed by LZ4", "compression=\"zstd\""]),
        ),
        (
            "Parquet with LZ4_RAW",
            parquet_of(folder, 7),
            Err(["\"gx_rads\" is compressed by LZ4", "compression=\"zstd\""]),
        ),
        (
            "Parquet with LZO",
            parquet_of(folder, 3),
            Err(["\"gx_rads\" is compressed by LZO", "compression=\"zstd\""]),
        ),
        ("encrypted Parquet", of(b"PARE"), Err(["is encrypted", "without encryption"])),
        ("zstd", of(b"\x28\xb5\x2f\xfd"), Err(["compressed by zstd", "zstd -d"])),
        ("xz", of(b"\xfd7zXZ\0"), Err(["compressed by xz", "xz -d"])),
        ("bzip2", of(b"BZh9"), Err(["compressed by bzip2", "bunzip2"])),
        ("lz4", of(b"\x04\x22\x4d\x18"), Err(["compressed by lz4", "lz4 -d"])),
        (
            "a workbook",
            zip(&[("xl/workbook.xml", b"<workbook/>")]),
            Err(["a workbook", "save the sheet as CSV"]),
        ),
        ("Arrow", of(b"ARROW1\0\0"), Err(["Arrow", "pyarrow"])),
        ("HDF5", of(b"\x89HDF\r\n\x1a\n"), Err(["HDF5", "help: "])),
        ("MAT", of(b"MATLAB 5.0 MAT-file"), Err(["MAT-file", "writetable"])),
        ("SQLite", of(b"SQLite format 3\0"), Err(["SQLite", "sqlite3 -header"])),
        // a column may have that name
        (
            "a column named ORC",
            lf.replace("gx_rads", "ORC").lines().map(swapped).collect::<String>().into(),
            Ok(ROWS),
        ),
        (
            "a line of a megabyte",
            [b"t_s,gx_rads\n0,\"", &[b'x'; 1 << 21][..]].concat(),
            Err(["line 2 is longer", "help: "]),
        ),
    ]
}

/// A line of two cells, the second first.
fn swapped(line: &str) -> String {
    let (one, other) = line.split_once(',').expect("two cells");
    format!("{other};{one}\n")
}

fn fits(found: &Result<usize, String>, expected: &Expected) -> bool {
    match (found, expected) {
        (Ok(found), Ok(expected)) => found == expected,
        (Err(message), Err(words)) => {
            message.contains("log.bin")
                && message.contains("\nhelp: ")
                && words.iter().all(|word| message.contains(word))
        }
        _ => false,
    }
}

/// Limit of the address space, kilobytes: more than the program needs at start, less than the decompressed file.
const LIMIT_KB: u32 = 150_000;

/// Reads a file of 160 MB when decompressed; returns true if the exit code is 1.
#[cfg(unix)]
fn rejects_within_little_memory(folder: &Path, begin: &[u8], piece: &[u8]) -> bool {
    // one member of a megabyte, repeated: compressing 160 MB takes longer than reading them
    let member = packed(&piece.repeat((1 << 20) / piece.len()));
    fs::write(folder.join("large.csv.gz"), [packed(begin), member.repeat(160)].concat()).expect("written");
    let line = format!("ulimit -v {LIMIT_KB}; exec \"$0\" fit large.csv.gz --axis gx -o unit.json");
    let status = Command::new("sh")
        .args(["-c", &line, env!("CARGO_BIN_EXE_fos")])
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", "2")
        // each thread would reserve 64 MB of addresses
        .env("MALLOC_ARENA_MAX", "1")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    status.expect("it starts").code() == Some(1)
}

#[test]
fn unusual_files_are_read_or_rejected_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.bin");
    let read = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("written");
        load(&path, &LoadOptions::default()).map(|log| log.n_rows()).map_err(|error| error.to_string())
    };
    let files = files(folder.path());
    let found: Vec<_> = files.iter().map(|(_, bytes, _)| read(bytes)).collect();
    for ((name, _, expected), found) in files.iter().zip(&found) {
        assert!(fits(found, expected), "{name}: {found:?}");
    }
    // the words for one file fit no other, and no damaged one
    let damaged = read(&parquet_of(folder.path(), 6)[..2000.min(ROWS)]);
    let refused: Vec<_> =
        files.iter().filter_map(|(name, _, expected)| expected.err().map(|words| (name, words))).collect();
    let mut told_apart = 0;
    for (name, words) in &refused {
        assert!(!fits(&damaged, &Err(*words)), "{name}: {damaged:?}");
        for ((other, _, of_other), found) in files.iter().zip(&found) {
            if *of_other != Err(*words) {
                assert!(!fits(found, &Err(*words)), "{name}, {other}: {found:?}");
                told_apart += 1;
            }
        }
    }
    let read = files.len() - refused.len();
    #[cfg(not(unix))]
    let memory = "memory not measured here";
    #[cfg(unix)]
    let memory = {
        let line = [&b"0,\""[..], &vec![b'x'; (1 << 20) - 10], b"\n"].concat();
        for (name, begin, piece) in [
            ("an open quotation mark", &b"t_s,gx_rads\n0,\""[..], &[b'x'; 4096][..]),
            // up to a thousand of them used to be kept: a gigabyte
            ("lines of a megabyte", b"t_s,gx_rads\n", &line),
            ("one in the header", b"\"t_s,gx_rads,", &[b'x'; 4096]),
        ] {
            assert!(rejects_within_little_memory(folder.path(), begin, piece), "{name}");
        }
        // negative control: rows are kept, so the limit is reached
        assert!(
            !rejects_within_little_memory(folder.path(), b"t_s,gx_rads\n", b"1,2\n"),
            "the limit is none"
        );
        format!("3 texts of 160 MB without a row are refused within {} MB of address space", LIMIT_KB / 1000)
    };
    println!(
        "attack: unusual files | {} kinds of file: {read} are read completely, {} are refused with their kind and a remedy; {memory} | negative control: no message fits another kind of file ({told_apart} pairs) or a damaged file; 160 MB of rows, which must be stored, exceed that memory",
        files.len(),
        refused.len()
    );
}
