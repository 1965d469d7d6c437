//! Modules, the names in them, and the places where names are used.

use std::collections::{HashMap, HashSet};

/// Index into [`Sources::files`].
pub(crate) type FileId = usize;
/// Index into [`Sources::modules`].
pub(crate) type ModuleId = usize;
/// Index into [`Sources::crates`].
pub(crate) type CrateId = usize;

/// All files, crates and modules read.
#[derive(Default)]
pub(crate) struct Sources {
    pub(crate) files: Vec<File>,
    pub(crate) crates: Vec<Crate>,
    pub(crate) modules: Vec<Module>,
    pub(crate) references: Vec<Reference>,
}

/// A file of source.
pub(crate) struct File {
    /// Path from the root of the workspace.
    pub(crate) path: String,
    /// Package of the file.
    pub(crate) package: String,
}

/// One compilation.
#[derive(Default)]
pub(crate) struct Crate {
    pub(crate) root: ModuleId,
    /// Crates of this workspace that it can name.
    pub(crate) externs: HashMap<String, CrateId>,
}

/// A module, or a block with its own items.
pub(crate) struct Module {
    pub(crate) of: CrateId,
    pub(crate) file: FileId,
    /// None for the root of a crate.
    pub(crate) parent: Option<ModuleId>,
    /// A block also sees the names around it, unlike a module.
    pub(crate) is_block: bool,
    pub(crate) names: HashMap<String, Vec<Name>>,
    pub(crate) imports: Vec<Import>,
    /// `#[macro_use]`: its macros are visible in its parent.
    pub(crate) gives_macros: bool,
}

/// A name and its definition in a module.
pub(crate) struct Name {
    pub(crate) space: Space,
    pub(crate) visible: Visible,
    pub(crate) defined: Defined,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Defined {
    Module(ModuleId),
    /// Any other item.
    Item(FileId),
    /// Defined in a crate outside the workspace.
    Outside,
}

/// Namespace; the same name may exist in several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Space {
    /// Types and modules.
    Type,
    Value,
    Macro,
}

/// Visibility of a name.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Visible {
    Everywhere,
    InCrate,
    /// Visible in this module and all inside it.
    Inside(ModuleId),
}

/// One name, or a glob, of a `use`.
pub(crate) struct Import {
    pub(crate) path: Path,
    /// None for a glob.
    pub(crate) name: Option<String>,
    /// Accepted namespaces: all, but for `{self}` and globs only those of modules and types.
    pub(crate) takes: Wanted,
    pub(crate) visible: Visible,
}

/// A path as written.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Path {
    /// Segments, with `crate`, `self` and `super` unresolved.
    pub(crate) segments: Vec<String>,
    /// `::name`, which is always another crate.
    pub(crate) is_global: bool,
}

/// A place where a name is used.
pub(crate) struct Reference {
    pub(crate) module: ModuleId,
    pub(crate) path: Path,
    pub(crate) wanted: Wanted,
}

/// Namespaces in which a name is resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Wanted {
    /// Names that a further segment may follow.
    Scope,
    /// Types and values.
    Plain,
    Macro,
    /// All namespaces, as in `use`.
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

/// Names bound by patterns, innermost last.
#[derive(Default)]
pub(crate) struct Locals(pub(crate) Vec<HashSet<String>>);

impl Locals {
    pub(crate) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|bound| bound.contains(name))
    }
}

impl Sources {
    /// Module that contains a block; a module itself.
    pub(crate) fn module_of(&self, mut module: ModuleId) -> ModuleId {
        while self.modules[module].is_block {
            // Every block has a parent.
            module = self.modules[module].parent.unwrap_or(module);
        }
        module
    }

    /// `module` is `outer` or inside it.
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
