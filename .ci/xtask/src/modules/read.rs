//! Reads modules, names and references from files.

use std::error::Error;
use std::fs;
use std::path::{Path as FilePath, PathBuf};

use syn::Meta;
use syn::visit::Visit;

use super::excluded::is_excluded;
use super::source::*;
use crate::workspace::Package;

/// Reads all compiled files of these packages except tests and build scripts.
pub(crate) fn workspace(packages: &[Package], root: &FilePath) -> Result<Sources, Box<dyn Error>> {
    let mut sources = Sources::default();
    let mut libraries: Vec<(&str, CrateId)> = Vec::new();
    let mut of_package: Vec<(&Package, CrateId)> = Vec::new();
    for package in packages {
        for target in &package.targets {
            let of = sources.crates.len();
            sources.crates.push(Crate { root: sources.modules.len(), ..Crate::default() });
            let mut reader = Reader::new(&mut sources, of, root, &package.name);
            reader.file(&target.root, None, true)?;
            if target.is_library {
                libraries.push((&package.name, of));
            }
            of_package.push((package, of));
        }
    }
    let library = |name: &str| libraries.iter().find(|(package, _)| *package == name).map(|&(_, of)| of);
    for (package, of) in of_package {
        if let Some(own) = library(&package.name).filter(|own| *own != of) {
            sources.crates[of].externs.insert(package.name.replace('-', "_"), own);
        }
        for dependency in &package.dependencies {
            if let Some(other) = library(&dependency.package) {
                sources.crates[of].externs.insert(dependency.name.clone(), other);
            }
        }
    }
    Ok(sources)
}

/// State of the reader.
pub(crate) struct Reader<'a> {
    pub(crate) sources: &'a mut Sources,
    pub(crate) of: CrateId,
    pub(crate) root: &'a FilePath,
    pub(crate) package: &'a str,
    pub(crate) module: ModuleId,
    /// Folders for modules declared here, and for `#[path]`.
    pub(crate) modules_in: PathBuf,
    pub(crate) paths_from: PathBuf,
    pub(crate) locals: Locals,
    pub(crate) failed: Option<Box<dyn Error>>,
}

impl<'a> Reader<'a> {
    fn new(sources: &'a mut Sources, of: CrateId, root: &'a FilePath, package: &'a str) -> Self {
        let nowhere = PathBuf::new();
        Self {
            sources,
            of,
            root,
            package,
            module: 0,
            modules_in: nowhere.clone(),
            paths_from: nowhere,
            locals: Locals::default(),
            failed: None,
        }
    }

    /// Reads a module in its own file. `is_mod_rs`: its submodules are in the same folder.
    fn file(
        &mut self,
        path: &FilePath,
        parent: Option<ModuleId>,
        is_mod_rs: bool,
    ) -> Result<ModuleId, Box<dyn Error>> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let parsed = syn::parse_file(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        // `#[path]` may give any spelling.
        let path = path.canonicalize()?;
        let name =
            path.strip_prefix(self.root.canonicalize()?).unwrap_or(&path).to_string_lossy().into_owned();
        let known = self.sources.files.iter().position(|file| file.path == name);
        let file = known.unwrap_or_else(|| {
            self.sources.files.push(File { path: name, package: self.package.to_owned() });
            self.sources.files.len() - 1
        });
        let module = self.add(file, parent, false);
        if is_excluded(&parsed.attrs) {
            return Ok(module);
        }
        let folder = path.parent().unwrap_or(self.root).to_path_buf();
        let modules_in = if is_mod_rs { folder.clone() } else { path.with_extension("") };
        self.within(module, modules_in, folder, |reader| reader.visit_file(&parsed));
        match self.failed.take() {
            Some(error) => Err(error),
            None => Ok(module),
        }
    }

    pub(crate) fn add(&mut self, file: FileId, parent: Option<ModuleId>, is_block: bool) -> ModuleId {
        let (names, imports) = Default::default();
        self.sources.modules.push(Module {
            of: self.of,
            file,
            parent,
            is_block,
            names,
            imports,
            gives_macros: false,
        });
        self.sources.modules.len() - 1
    }

    fn within(
        &mut self,
        module: ModuleId,
        modules_in: PathBuf,
        paths_from: PathBuf,
        read: impl FnOnce(&mut Self),
    ) {
        let before =
            (self.module, self.modules_in.clone(), self.paths_from.clone(), std::mem::take(&mut self.locals));
        (self.module, self.modules_in, self.paths_from) = (module, modules_in, paths_from);
        read(self);
        (self.module, self.modules_in, self.paths_from, self.locals) = before;
    }

    pub(crate) fn here(&self) -> &Module {
        &self.sources.modules[self.module]
    }

    pub(crate) fn module(&mut self, item: &syn::ItemMod) -> Result<(), Box<dyn Error>> {
        let name = item.ident.to_string();
        let path = item.attrs.iter().find_map(|attribute| match &attribute.meta {
            Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
                syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => Some(text.value()),
                _ => None,
            },
            _ => None,
        });
        let visible = self.visible(&item.vis);
        let parent = self.module;
        let module = if let Some((_, items)) = &item.content {
            let module = self.add(self.here().file, Some(parent), false);
            let folder = self.modules_in.join(path.unwrap_or(name));
            self.within(module, folder.clone(), folder, |reader| {
                items.iter().for_each(|item| reader.visit_item(item))
            });
            module
        } else if let Some(path) = path {
            self.file(&self.paths_from.join(path), Some(parent), true)?
        } else {
            let (beside, inside) =
                (self.modules_in.join(format!("{name}.rs")), self.modules_in.join(&name).join("mod.rs"));
            let is_mod_rs = !beside.exists();
            self.file(if is_mod_rs { &inside } else { &beside }, Some(parent), is_mod_rs)?
        };
        self.sources.modules[module].gives_macros =
            item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_use"));
        self.declare(&item.ident, Space::Type, visible, Defined::Module(module));
        Ok(())
    }
}
