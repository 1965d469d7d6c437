//! include/fos.h is checked in, so that users need no generator; this test compares it with the source.

use std::path::Path;

#[test]
fn header_matches_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("a configuration");
    let mut builder = cbindgen::Builder::new().with_config(config);
    // in the order of the header
    for file in ["status", "values", "hub", "telemetry", "streams", "flash", "store", "unit"] {
        builder = builder.with_src(root.join(format!("src/c_api/{file}.rs")));
    }
    let mut generated = Vec::new();
    builder.generate().expect("bindings").write(&mut generated);
    let generated = String::from_utf8(generated).expect("text");

    let path = root.join("include/fos.h");
    if std::env::var_os("FOS_WRITE_HEADER").is_some() {
        std::fs::create_dir_all(root.join("include")).expect("a folder");
        std::fs::write(&path, &generated).expect("written");
    }
    let checked_in = std::fs::read_to_string(&path).unwrap_or_default();
    let difference = checked_in.lines().zip(generated.lines()).find(|(old, new)| old != new);
    assert!(
        checked_in == generated,
        "include/fos.h is not what the source says: {difference:?}\nFOS_WRITE_HEADER=1 cargo test -p fos-embedded --test device c_header::"
    );
}
