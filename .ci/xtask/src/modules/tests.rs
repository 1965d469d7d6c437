//! Tests on small source trees: edges between files, and cycles.

use std::fs;

use crate::workspace::{Dependency, Package, Target};

use super::graph::Graph;
use super::read;

/// Packages by name, each with the files of a library; a package depends on all before it.
type Tree<'a> = &'a [(&'a str, &'a [(&'a str, &'a str)])];

/// Edges between files as `from -> to: names`, and cycles.
fn edges_and_cycles(tree: Tree) -> (Vec<String>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let mut packages: Vec<Package> = Vec::new();
    for (name, files) in tree {
        for (path, text) in *files {
            let path = folder.path().join(name).join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let dependencies = packages
            .iter()
            .map(|other| Dependency {
                package: other.name.clone(),
                name: other.name.replace('-', "_"),
                is_normal: true,
            })
            .collect();
        let root = folder.path().join(name).join("lib.rs");
        packages.push(Package {
            name: (*name).to_owned(),
            folder: folder.path().join(name),
            targets: vec![Target { is_library: true, root }],
            dependencies,
        });
    }
    let sources = read::workspace(&packages, folder.path()).unwrap();
    let graph = Graph::of(&sources);
    (graph.arrows().lines().map(str::to_owned).collect(), graph.circles())
}

/// Edges in one package, without its name in the paths.
fn edges(files: &[(&str, &str)]) -> Vec<String> {
    edges_and_cycles(&[("a", files)]).0.iter().map(|arrow| arrow.replace("a/", "")).collect()
}

fn cycles(files: &[(&str, &str)]) -> Vec<String> {
    edges_and_cycles(&[("a", files)]).1.iter().map(|circle| circle.replace("a/", "")).collect()
}

#[test]
fn one_way_dependencies_are_no_cycle() {
    let files = [
        ("lib.rs", "mod one; mod two;"),
        ("one.rs", "pub struct One;"),
        ("two.rs", "use crate::one::One; pub fn two(_: One) {}"),
    ];
    assert_eq!(edges(&files), ["two.rs -> one.rs: One"]);
    assert_eq!(cycles(&files), [""; 0]);
}

#[test]
fn reexports_add_no_edges() {
    let files = [
        ("lib.rs", "mod folder;"),
        ("folder/mod.rs", "mod error; mod load; pub use error::Error; pub(crate) use load::*;"),
        ("folder/error.rs", "pub struct Error;"),
        ("folder/load.rs", "use super::Error; pub fn load() -> Result<(), Error> { Err(Error) }"),
    ];
    assert_eq!(edges(&files), ["folder/load.rs -> folder/error.rs: Error"]);
}

#[test]
fn finds_cycle_through_reexports() {
    let files = [
        ("lib.rs", "mod folder; pub use folder::{Error, load};"),
        ("folder.rs", "mod error; mod load; pub use error::*; pub(crate) use load::*;"),
        (
            "folder/error.rs",
            "pub struct Error; pub const WHERE: u8 = crate::RATE; use crate::folder::other as _;",
        ),
        (
            "folder/load.rs",
            "use super::Error; pub const RATE: u8 = 1; pub fn load() -> Error { Error } pub fn other() {}",
        ),
    ];
    assert_eq!(
        cycles(&files),
        [
            "a circle of 2 files: folder/error.rs, folder/load.rs\n  folder/error.rs -> folder/load.rs: other\n  folder/load.rs -> folder/error.rs: Error"
        ]
    );
}

#[test]
fn use_groups_name_each_part() {
    let files = [
        ("lib.rs", "mod part; mod user;"),
        ("part/mod.rs", "pub mod b; pub mod c; pub struct Own;"),
        ("part/b.rs", "pub struct B;"),
        ("part/c.rs", "pub struct D; pub fn called() {}"),
        (
            "user.rs",
            "use crate::part::{b::B as Other, c::{self, D}, Own}; pub fn user(_: Other, _: D, _: Own) { c::called() }",
        ),
    ];
    assert_eq!(
        edges(&files),
        ["user.rs -> part/b.rs: B, Other", "user.rs -> part/c.rs: D, called", "user.rs -> part/mod.rs: Own"]
    );
}

#[test]
fn distinguishes_module_from_function_of_same_name() {
    let files = [
        ("lib.rs", "mod lines; mod user; fn lines() {}"),
        ("lines.rs", "pub fn find() {}"),
        ("user.rs", "use super::lines::{self}; pub fn user() { lines::find() }"),
    ];
    assert_eq!(edges(&files), ["user.rs -> lines.rs: find"]);
    let files = [files[0], files[1], ("user.rs", "use super::lines; pub fn user() { lines() }")];
    assert_eq!(edges(&files), ["user.rs -> lib.rs: lines"]);
}

#[test]
fn inline_modules_belong_to_their_file() {
    let files = [
        ("lib.rs", "mod outer; mod user;"),
        (
            "outer.rs",
            "pub mod inner { pub mod deep; pub struct Inner; fn own(_: super::Outer, _: deep::Deep) {} } pub struct Outer;",
        ),
        (
            "outer/inner/deep.rs",
            "pub struct Deep; impl Deep { fn take(_: super::Inner, _: super::super::Outer) {} }",
        ),
        ("user.rs", "fn user() { crate::outer::inner::Inner; }"),
    ];
    assert_eq!(
        edges(&files),
        [
            "outer.rs -> outer/inner/deep.rs: Deep",
            "outer/inner/deep.rs -> outer.rs: Inner, Outer",
            "user.rs -> outer.rs: Inner"
        ]
    );
}

#[test]
fn impl_in_another_file_uses_the_type() {
    let files = [
        ("lib.rs", "mod model; mod shown;"),
        ("model.rs", "pub struct Model; mod inside { impl super::Model {} }"),
        ("shown.rs", "impl std::fmt::Display for crate::model::Model {}"),
    ];
    assert_eq!(edges(&files), ["shown.rs -> model.rs: Model"]);
}

#[test]
fn macros_resolve_by_path_and_by_scope() {
    let files = [
        (
            "lib.rs",
            "#[macro_use] mod log; mod print; mod user; #[macro_export] macro_rules! root { () => {} }",
        ),
        ("log.rs", "macro_rules! info { () => { $crate::print::written(); elsewhere() } }"),
        (
            "print.rs",
            "macro_rules! line { () => {} } pub(crate) use line; pub fn written() {} pub struct Written;",
        ),
        (
            "user.rs",
            "fn user() { info!(); crate::print::line!(); assert!(vec![crate::print::Written].is_empty()); root!(); println!(); }",
        ),
    ];
    assert_eq!(
        edges(&files),
        [
            "log.rs -> print.rs: written",
            "user.rs -> lib.rs: root",
            "user.rs -> log.rs: info",
            "user.rs -> print.rs: Written, line"
        ]
    );
}

#[test]
fn macro_output_belongs_to_the_calling_file() {
    let files = [
        ("lib.rs", "mod made; mod user; pub use made::Faults;"),
        ("made.rs", "bitflags::bitflags! { pub struct Faults: u8 {} }"),
        ("user.rs", "use crate::Faults;"),
    ];
    assert_eq!(edges(&files), ["user.rs -> made.rs: Faults"]);
}

#[test]
fn glob_imports_resolve_where_names_are_used() {
    let files = [
        ("lib.rs", "mod one; mod two; mod user;"),
        ("one.rs", "pub struct One; pub fn rate() {} struct Hidden;"),
        ("two.rs", "pub struct Hidden; pub use super::one::One as Renamed;"),
        (
            "user.rs",
            "use crate::one::*; use crate::two::*; fn user(_: One, _: Hidden, _: Renamed) { let rate = 1; rate; }",
        ),
    ];
    assert_eq!(edges(&files), ["user.rs -> one.rs: One, Renamed", "user.rs -> two.rs: Hidden"]);
}

#[test]
fn block_imports_are_local_to_the_block() {
    let files = [
        ("lib.rs", "mod one; mod user;"),
        ("one.rs", "pub mod inner { pub fn called() {} }"),
        (
            "user.rs",
            "mod inner { pub fn called() {} } fn user() { inner::called(); { use crate::one::inner; inner::called(); } }",
        ),
    ];
    assert_eq!(edges(&files), ["user.rs -> one.rs: called"]);
}

#[test]
fn serde_attributes_are_references() {
    let files = [
        ("lib.rs", "mod text; mod user;"),
        ("text.rs", "pub fn serialize() {} pub fn deserialize() {}"),
        (
            "user.rs",
            r#"#[derive(serde::Serialize)] struct User { #[serde(with = "crate::text", rename = "text")] text: u8 }"#,
        ),
    ];
    assert_eq!(edges(&files), ["user.rs -> text.rs: serialize"]);
}

#[test]
fn excludes_test_only_items() {
    let files = [
        ("lib.rs", "mod one; mod two; #[cfg(all(test, unix))] mod absent;"),
        (
            "one.rs",
            "pub struct One; #[cfg(test)] mod tests { use crate::two::Two; } #[cfg(test)] use crate::two::Two; \
             struct Kept { #[cfg(test)] two: crate::two::Two }",
        ),
        (
            "two.rs",
            "#[cfg(any(test, feature = \"more\"))] use crate::one::One; #[cfg(not(test))] pub struct Two;",
        ),
    ];
    assert_eq!(edges(&files), ["two.rs -> one.rs: One"]);
}

#[test]
fn names_of_other_crates_resolve_to_files() {
    let core: (&str, &[_]) =
        ("fos-core", &[("lib.rs", "mod model; pub use model::Model;"), ("model.rs", "pub struct Model;")]);
    let passed_on: (&str, &[_]) =
        ("host", &[("lib.rs", "pub use fos_core::*; pub mod own;"), ("own.rs", "use fos_core::Model;")]);
    let user: (&str, &[_]) =
        ("user", &[("lib.rs", "fn user(_: host::Model, _: ::host::own::Own, _: std::fmt::Error) {}")]);
    let (edges, cycles) = edges_and_cycles(&[core, passed_on, user]);
    assert_eq!(
        edges,
        [
            "host/own.rs -> fos-core/model.rs: Model",
            "user/lib.rs -> fos-core/model.rs: Model",
            "user/lib.rs -> host/own.rs: Own"
        ]
    );
    assert_eq!(cycles, [""; 0]);
}

#[test]
fn cyclic_imports_terminate() {
    let files = [
        ("lib.rs", "mod one; mod two; fn user() { one::Something; }"),
        ("one.rs", "pub use crate::two::*; pub use crate::two::Nothing;"),
        ("two.rs", "pub use crate::one::*; pub use crate::one::Nothing; pub struct Something;"),
    ];
    assert_eq!(edges(&files), ["lib.rs -> two.rs: Something"]);
}

#[test]
fn removing_the_back_edge_removes_the_cycle() {
    let back = "use crate::three::Three; pub struct One;";
    let chain = |one| {
        [
            ("lib.rs", "mod one; mod two; mod three;"),
            ("one.rs", one),
            ("two.rs", "pub struct Two(crate::one::One);"),
            ("three.rs", "pub struct Three(crate::two::Two);"),
        ]
    };
    assert_eq!(cycles(&chain(back)).len(), 1);
    assert!(cycles(&chain(back))[0].starts_with("a circle of 3 files: one.rs, three.rs, two.rs\n"));
    assert_eq!(cycles(&chain("pub struct One;")), [""; 0]);
}
