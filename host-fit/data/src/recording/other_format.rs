//! Files that are no log but are known by their first bytes: their kind, and how to convert them.

/// A kind of file: its first bytes, its description, and the remedy.
struct Known {
    begin: &'static [u8],
    is: &'static str,
    help: &'static str,
}

const KNOWN: &[Known] = &[
    Known { begin: b"PARE", is: "the Parquet file is encrypted", help: "write it again without encryption" },
    Known {
        begin: b"\x28\xb5\x2f\xfd",
        is: "it is compressed by zstd",
        help: "unpack it first: `zstd -d FILE`",
    },
    Known { begin: b"\xfd7zXZ\0", is: "it is compressed by xz", help: "unpack it first: `xz -d FILE`" },
    Known { begin: b"BZh", is: "it is compressed by bzip2", help: "unpack it first: `bunzip2 FILE`" },
    Known {
        begin: b"\x04\x22\x4d\x18",
        is: "it is compressed by lz4",
        help: "unpack it first: `lz4 -d FILE`",
    },
    Known {
        begin: b"ARROW1",
        is: "it is an Arrow (Feather) file",
        help: "write it as Parquet: in Python, pyarrow.parquet.write_table(pyarrow.feather.read_table(\"a\"), \"a.parquet\")",
    },
    Known {
        begin: b"\x89HDF\r\n\x1a\n",
        is: "it is an HDF5 file, as MATLAB writes too",
        help: "write the table in it as CSV or Parquet",
    },
    Known {
        begin: b"MATLAB 5.0",
        is: "it is a MAT-file",
        help: "write its columns as CSV: in MATLAB writetable(table(t, acc, gyr), \"log.csv\"), in Python scipy.io.loadmat and numpy.savetxt",
    },
    Known {
        begin: b"SQLite format 3",
        is: "it is a database of SQLite",
        help: "`sqlite3 -header -csv FILE 'select * from TABLE' > log.csv`",
    },
    Known { begin: b"Obj\x01", is: "it is an Avro file", help: "write it as CSV or Parquet" },
    Known { begin: b"ORC", is: "it is an ORC file", help: "write it as CSV or Parquet" },
];

/// Number of bytes that distinguish the kinds.
pub(super) const BEGIN: usize = 16;

/// Description and remedy of a file with these first bytes, if it is a known non-log.
pub(super) fn known(begin: &[u8]) -> Option<(&'static str, &'static str)> {
    // the first sector is empty
    if begin.get(512..).is_some_and(|rest| rest.starts_with(b"MDTC"))
        && begin[..512].iter().all(|byte| *byte == 0)
    {
        return Some((
            "it is a log of a Matrix wearable of Parmay Tech (.BIN, with accelerometer, gyro and temperature)",
            "export it as CSV, with time, accelerometer and gyro: by the software of the device, or in R by GGIRread::readParmayMatrix",
        ));
    }
    // a column of a CSV file may be named ORC
    let is_text = |known: &Known| known.begin.iter().all(u8::is_ascii_alphanumeric);
    let ends_as_text =
        |known: &Known| begin.get(known.begin.len()).is_some_and(|next| b",;\t _\r\n".contains(next));
    let known = KNOWN
        .iter()
        .find(|known| begin.starts_with(known.begin) && !(is_text(known) && ends_as_text(known)))?;
    Some((known.is, known.help))
}

/// Description and remedy of a text that is not UTF-8, from its first line: UTF-16 if every second byte or more is 0.
pub(super) fn known_text(line: &[u8]) -> Option<(&'static str, &'static str)> {
    let zeros = line.iter().filter(|&&byte| byte == 0).count();
    let is_wide = line.starts_with(b"\xff\xfe")
        || line.starts_with(b"\xfe\xff")
        || (zeros > 0 && 5 * zeros >= 2 * line.len());
    if is_wide {
        return Some((
            "the text is UTF-16, as some programs of Windows write it",
            "write it as UTF-8: `iconv -f UTF-16 -t UTF-8 FILE > log.csv`, or \"CSV UTF-8\" when saving it",
        ));
    }
    (zeros > 0).then_some((
        "its first line holds zero bytes: it is no text",
        "a log is CSV (a header line, then numbers), gzip'd CSV or Parquet, or in a known format of others",
    ))
}
