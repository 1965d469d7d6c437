//! Modules, the names in them, and the places where names are used.

use std::collections::{HashMap, HashSet};

/// Index into [`Sources::files`].
pub(crate) type FileId = usize;
/// Index into [`Sources::modules`].
pub(crate) type ModuleId = usize;
/// Index into [`Sources::crates`].
pub(crate) type CrateId = usize;

/// Everything that was read.
#[derive(Default)]
pub(crate) struct Sources {
    pub(crate) files: Vec<File>,
    pub(crate) crates: Vec<Crate>,
    pub(crate) modules: Vec<Module>,
    pub(crate) references: Vec<Reference>,
}

/// A file of source.
pub(crate) struct File {
    /// From the root of the workspace.
    pub(crate) path: String,
    /// The package that it belongs to.
    pub(crate) package: String,
}

/// One compilation.
#[derive(Default)]
pub(crate) struct Crate {
    pub(crate) root: ModuleId,
    /// The crates of this workspace that it can name.
    pub(crate) externs: HashMap<String, CrateId>,
}

/// A module, or a block with items of its own.
pub(crate) struct Module {
    pub(crate) of: CrateId,
    pub(crate) file: FileId,
    /// None of the root of a crate.
    pub(crate) parent: Option<ModuleId>,
    /// Sees the names around it, as a module does not.
    pub(crate) is_block: bool,
    pub(crate) names: HashMap<String, Vec<Name>>,
    pub(crate) imports: Vec<Import>,
    /// `#[macro_use]`: its macros are those of its parent too.
    pub(crate) gives_macros: bool,
}

/// What stands behind a name in its own module.
pub(crate) struct Name {
    pub(crate) space: Space,
    pub(crate) visible: Visible,
    pub(crate) defined: Defined,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Defined {
    Module(ModuleId),
    /// Anything else; which of them is of no interest.
    Item(FileId),
    /// In a crate that is not of the workspace.
    Outside,
}

/// Names of different spaces may be alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Space {
    /// Modules too.
    Type,
    Value,
    Macro,
}

/// Which modules see a name.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Visible {
    Everywhere,
    InCrate,
    /// And in all that are inside of it.
    Inside(ModuleId),
}

/// One name, or a glob, of a `use`.
pub(crate) struct Import {
    pub(crate) path: Path,
    /// None of a glob.
    pub(crate) name: Option<String>,
    /// Everything of that name, but of `{self}` and of globs modules and types alone.
    pub(crate) takes: Wanted,
    pub(crate) visible: Visible,
}

/// As it is written.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Path {
    /// With `crate`, `self` and `super` as they are.
    pub(crate) segments: Vec<String>,
    /// `::name`: another crate, whatever is called so here.
    pub(crate) is_global: bool,
}

/// A place where a name is used.
pub(crate) struct Reference {
    pub(crate) module: ModuleId,
    pub(crate) path: Path,
    pub(crate) wanted: Wanted,
}

/// Which of several things of one name is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Wanted {
    /// What another segment may follow.
    Scope,
    /// A type or a value.
    Plain,
    Macro,
    /// As `use` does.
    All,
}

impl Wanted {
    pub(crate) fn accepts(self, space: Space) -> bool {
        match self {
            Wanted::Scope => space == Space::Type,
            Wanted::Plain => space != Space::Macro,
            Wanted::Macro => space == Space::Macro,
            Wanted::All => true,
        }
    }
}

/// The names that patterns have bound, innermost last.
#[derive(Default)]
pub(crate) struct Locals(pub(crate) Vec<HashSet<String>>);

impl Locals {
    pub(crate) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|bound| bound.contains(name))
    }
}

impl Sources {
    /// The module that a block stands in; of a module itself.
    pub(crate) fn module_of(&self, mut module: ModuleId) -> ModuleId {
        while self.modules[module].is_block {
            // a block stands in something
            module = self.modules[module].parent.unwrap_or(module);
        }
        module
    }

    /// Whether one is the other, or inside of it.
    pub(crate) fn is_inside(&self, module: ModuleId, outer: ModuleId) -> bool {
        let mut at = Some(module);
        while let Some(module) = at {
            if module == outer {
                return true;
            }
            at = self.modules[module].parent;
        }
        false
    }
}
