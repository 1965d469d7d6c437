//! Resolves names to the files that define them.

use super::source::*;

/// Names being resolved, to detect cyclic imports.
type Looking = Vec<(ModuleId, String, Wanted)>;

/// Definitions at the end of a path, with the segment that names them.
pub(crate) struct Found {
    pub(crate) defined: Vec<Defined>,
    pub(crate) name: String,
}

impl Sources {
    /// Resolves a reference.
    pub(crate) fn follow(&self, reference: &Reference) -> Found {
        self.path(reference.module, &reference.path, reference.wanted, &mut Vec::new())
    }

    fn path(&self, from: ModuleId, path: &Path, wanted: Wanted, looking: &mut Looking) -> Found {
        let Some((first, rest)) = path.segments.split_first() else {
            return Found { defined: Vec::new(), name: String::new() };
        };
        let own = self.module_of(from);
        let wanted_of = |left: usize| if left == 0 { wanted } else { Wanted::Scope };
        let mut defined = match first.as_str() {
            "crate" => vec![Defined::Module(self.crates[self.modules[from].of].root)],
            "self" => vec![Defined::Module(own)],
            "super" => vec![Defined::Module(self.modules[own].parent.unwrap_or(own))],
            name if path.is_global => self.another_crate(from, name),
            name => self.lexical(from, name, wanted_of(rest.len()), looking),
        };
        let mut name = first;
        for (at, segment) in rest.iter().enumerate() {
            let is_item = |one: &Defined| !matches!(one, Defined::Module(_));
            // A variant, constant or function of the type.
            if defined.iter().any(is_item) {
                defined.retain(is_item);
                break;
            }
            let mut next = Vec::new();
            for &one in &defined {
                if let Defined::Module(module) = one {
                    next.extend(match (segment.as_str(), self.modules[module].parent) {
                        ("super", parent) => vec![Defined::Module(parent.unwrap_or(module))],
                        ("self", _) => vec![one],
                        (segment, _) => {
                            self.inside(module, segment, wanted_of(rest.len() - at - 1), from, looking)
                        }
                    });
                }
            }
            (defined, name) = (next, segment);
        }
        defined.sort();
        defined.dedup();
        Found { defined, name: name.clone() }
    }

    /// Resolves a single name in a block or module.
    fn lexical(&self, from: ModuleId, name: &str, wanted: Wanted, looking: &mut Looking) -> Vec<Defined> {
        let mut at = from;
        loop {
            let found = self.named(at, name, wanted, from, looking);
            if !found.is_empty() {
                return found;
            }
            match self.modules[at].parent {
                Some(parent) if self.modules[at].is_block => at = parent,
                _ => break,
            }
        }
        if wanted == Wanted::Macro { self.textual(from, name) } else { self.another_crate(from, name) }
    }

    /// A crate of the workspace by its name.
    fn another_crate(&self, from: ModuleId, name: &str) -> Vec<Defined> {
        let other = self.crates[self.modules[from].of].externs.get(name);
        vec![other.map_or(Defined::Outside, |&other| Defined::Module(self.crates[other].root))]
    }

    /// Finds a macro of an enclosing module, or of a `#[macro_use]` module in one.
    fn textual(&self, from: ModuleId, name: &str) -> Vec<Defined> {
        let mut at = Some(from);
        while let Some(module) = at {
            let given =
                self.modules.iter().filter(|other| other.gives_macros && other.parent == Some(module));
            for scope in std::iter::once(&self.modules[module]).chain(given) {
                let macros =
                    scope.names.get(name).into_iter().flatten().filter(|name| name.space == Space::Macro);
                let found: Vec<Defined> = macros.map(|name| name.defined).collect();
                if !found.is_empty() {
                    return found;
                }
            }
            at = self.modules[module].parent;
        }
        vec![Defined::Outside]
    }

    /// Resolves a name by a path through its module. If it is not found there, a macro makes it or it is
    /// re-exported from another crate.
    fn inside(
        &self,
        module: ModuleId,
        name: &str,
        wanted: Wanted,
        from: ModuleId,
        looking: &mut Looking,
    ) -> Vec<Defined> {
        let found = self.named(module, name, wanted, from, looking);
        if !found.is_empty() {
            return found;
        }
        let being_looked_for = looking.iter().any(|(of, this, _)| *of == module && this == name);
        if being_looked_for || !self.named(module, name, Wanted::All, from, looking).is_empty() {
            return Vec::new();
        }
        let globs = self.modules[module].imports.iter().filter(|import| import.name.is_none());
        let passes_on = |import: &Import| {
            self.path(module, &import.path, Wanted::Scope, &mut looking.clone())
                .defined
                .contains(&Defined::Outside)
        };
        vec![if globs.into_iter().any(passes_on) {
            Defined::Outside
        } else {
            Defined::Item(self.modules[module].file)
        }]
    }

    /// Resolves a name of a module: its own, imported, or by a glob, in this order.
    fn named(
        &self,
        module: ModuleId,
        name: &str,
        wanted: Wanted,
        from: ModuleId,
        looking: &mut Looking,
    ) -> Vec<Defined> {
        let key = (module, name.to_owned(), wanted);
        if looking.contains(&key) {
            return Vec::new();
        }
        looking.push(key);
        let scope = &self.modules[module];
        let own = scope.names.get(name).into_iter().flatten();
        let mut found: Vec<Defined> = own
            .filter(|name| wanted.accepts(name.space) && self.is_visible(name.visible, module, from))
            .map(|name| name.defined)
            .collect();
        let imports = |is_glob: bool| {
            let of_this_kind = scope.imports.iter().filter(move |import| import.name.is_none() == is_glob);
            of_this_kind.filter(|import| self.is_visible(import.visible, module, from))
        };
        if found.is_empty() || wanted == Wanted::All {
            for import in imports(false).filter(|import| import.name.as_deref() == Some(name)) {
                match (import.takes, wanted) {
                    (Wanted::Scope, Wanted::Macro) => {}
                    (Wanted::Scope, _) => {
                        found.extend(self.path(module, &import.path, Wanted::Scope, looking).defined)
                    }
                    _ => found.extend(self.path(module, &import.path, wanted, looking).defined),
                }
            }
        }
        if found.is_empty() {
            for import in imports(true) {
                for target in self.path(module, &import.path, Wanted::Scope, looking).defined {
                    if let Defined::Module(target) = target {
                        found.extend(self.named(target, name, wanted, module, looking));
                    }
                }
            }
        }
        looking.pop();
        found
    }

    fn is_visible(&self, visible: Visible, module: ModuleId, from: ModuleId) -> bool {
        match visible {
            Visible::Everywhere => true,
            Visible::InCrate => self.modules[module].of == self.modules[from].of,
            Visible::Inside(outer) => self.is_inside(from, outer),
        }
    }
}
