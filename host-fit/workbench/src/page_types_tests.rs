//! The page is checked against the types that the server answers with: `page/types.d.ts` is written from them.

use std::any::TypeId;
use std::collections::BTreeMap;
use std::path::Path;

use ts_rs::{Config, TS, TypeVisitor};

use super::api::{AxisSeries, Hubs, NamedFigure, Replayed, Wanted};
use super::folders::Listed;
use super::populations::{PopulationPage, UnitPage};
use super::series::ViewKind;
use super::view::{Entry, Page, StatusEvent};
use fos_data::recording::Preview;
use fos_diagnose::effects::Effect;

const HEAD: &str = "// What the server answers with, from its Rust types. Written by
// FOS_WRITE_PAGE_TYPES=1 cargo test --workspace --lib page_types
";

/// Declarations by name, of types and of all that they consist of.
struct Declarations {
    config: Config,
    known: BTreeMap<String, (TypeId, String)>,
}

impl TypeVisitor for Declarations {
    fn visit<T: TS + 'static + ?Sized>(&mut self) {
        // numbers, texts and lists need none
        if T::output_path().is_none() {
            return;
        }
        let (name, id) = (T::ident(&self.config), TypeId::of::<T>());
        if let Some((known, _)) = self.known.get(&name) {
            assert_eq!(*known, id, "two types are called {name}: rename one of them, #[ts(rename = …)]");
            return;
        }
        let docs = T::docs().unwrap_or_default();
        let declaration = format!("{docs}export {}\n", T::decl(&self.config));
        let compact = declaration.replace("/**\n * ", "/** ").replace("\n */", " */").replace(" \n", "\n");
        self.known.insert(name, (id, compact));
        T::visit_dependencies(self);
    }
}

fn declared() -> String {
    // JSON.parse knows no bigint
    let config = Config::new().with_large_int("number");
    let mut all = Declarations { config, known: BTreeMap::new() };
    all.visit::<Wanted>();
    all.visit::<ViewKind>();
    all.visit::<StatusEvent>();
    all.visit::<Entry>();
    all.visit::<Page>();
    all.visit::<AxisSeries>();
    all.visit::<NamedFigure>();
    all.visit::<Hubs>();
    all.visit::<Replayed>();
    all.visit::<Listed>();
    all.visit::<Preview>();
    all.visit::<Effect>();
    all.visit::<PopulationPage>();
    all.visit::<UnitPage>();
    let declarations = all.known.values().map(|(_, declaration)| format!("\n{declaration}"));
    HEAD.to_owned() + &declarations.collect::<String>()
}

#[test]
fn page_types_match_the_server() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("page/types.d.ts");
    let declared = declared();
    if std::env::var_os("FOS_WRITE_PAGE_TYPES").is_some() {
        std::fs::write(&path, &declared).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == declared,
        "{} is not what the types of the server say\nhelp: FOS_WRITE_PAGE_TYPES=1 cargo test --workspace --lib page_types, then .ci/browser types",
        path.display()
    );
}
