//! Collects the names that a file declares, re-exports and uses.

use std::collections::HashSet;

use syn::visit::{self, Visit};
use syn::{Attribute, Item, Meta, Stmt, UseTree, Visibility};

use super::excluded::{attributes, is_excluded};
use super::read::Reader;
use super::source::*;
use super::tokens::{self, serde_paths, written};

impl Reader<'_> {
    pub(crate) fn declare(&mut self, name: &syn::Ident, space: Space, visible: Visible, defined: Defined) {
        let name = name.to_string().trim_start_matches("r#").to_owned();
        self.sources.modules[self.module].names.entry(name).or_default().push(Name {
            space,
            visible,
            defined,
        });
    }

    fn item(&mut self, name: &syn::Ident, space: Space, visibility: &Visibility) {
        let (visible, file) = (self.visible(visibility), self.here().file);
        self.declare(name, space, visible, Defined::Item(file));
    }

    pub(crate) fn visible(&self, visibility: &Visibility) -> Visible {
        let inside = |module| Visible::Inside(self.sources.module_of(module));
        match visibility {
            Visibility::Public(_) => Visible::Everywhere,
            Visibility::Inherited => inside(self.module),
            Visibility::Restricted(to) if to.path.is_ident("self") => inside(self.module),
            Visibility::Restricted(to) if to.path.is_ident("super") => inside(
                self.sources.modules[self.sources.module_of(self.module)].parent.unwrap_or(self.module),
            ),
            // `pub(in …)` always names an enclosing module, or the code would not compile.
            Visibility::Restricted(_) => Visible::InCrate,
        }
    }

    fn refer(&mut self, path: Path, wanted: Wanted) {
        let is_local =
            path.segments.len() == 1 && wanted == Wanted::Plain && self.locals.has(&path.segments[0]);
        if path.segments[0] != "Self" && !is_local {
            self.sources.references.push(Reference { module: self.module, path, wanted });
        }
    }

    fn tokens(&mut self, tokens: &proc_macro2::TokenStream) {
        for (path, wanted) in tokens::paths(tokens.clone()) {
            self.refer(path, wanted);
        }
    }

    fn import(&mut self, tree: &UseTree, before: &[String], is_global: bool, visibility: &Visibility) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        let whole = |name: &syn::Ident| name == "self" && !before.is_empty();
        let (segments, name, takes) = match tree {
            UseTree::Path(path) => return self.import(&path.tree, &with(&path.ident), is_global, visibility),
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.import(tree, before, is_global, visibility));
            }
            UseTree::Name(name) if whole(&name.ident) => {
                (before.to_vec(), before.last().cloned(), Wanted::Scope)
            }
            UseTree::Rename(name) if whole(&name.ident) => {
                (before.to_vec(), Some(name.rename.to_string()), Wanted::Scope)
            }
            UseTree::Name(name) => (with(&name.ident), Some(name.ident.to_string()), Wanted::All),
            UseTree::Rename(name) => (with(&name.ident), Some(name.rename.to_string()), Wanted::All),
            UseTree::Glob(_) => (before.to_vec(), None, Wanted::Scope),
        };
        let path = Path { segments, is_global };
        // A re-export is not a use.
        if matches!(visibility, Visibility::Inherited) && !path.segments.is_empty() {
            self.refer(path.clone(), takes);
        }
        let visible = self.visible(visibility);
        self.sources.modules[self.module].imports.push(Import { path, name, takes, visible });
    }

    fn macro_rules(&mut self, name: &syn::Ident, item: &syn::ItemMacro) {
        let file = self.here().file;
        self.declare(
            name,
            Space::Macro,
            Visible::Inside(self.sources.module_of(self.module)),
            Defined::Item(file),
        );
        if item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_export")) {
            let inside = std::mem::replace(&mut self.module, self.sources.crates[self.of].root);
            self.declare(name, Space::Macro, Visible::Everywhere, Defined::Item(file));
            self.module = inside;
        }
        // Other names are resolved where the macro is called.
        let own = tokens::paths(item.mac.tokens.clone())
            .into_iter()
            .filter(|(path, _)| path.segments[0] == "crate");
        own.for_each(|(path, wanted)| self.refer(path, wanted));
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if is_excluded(attributes(item)) || self.failed.is_some() {
            return;
        }
        match item {
            Item::Const(item) => self.item(&item.ident, Space::Value, &item.vis),
            Item::Enum(item) => self.item(&item.ident, Space::Type, &item.vis),
            Item::Fn(item) => self.item(&item.sig.ident, Space::Value, &item.vis),
            Item::Static(item) => self.item(&item.ident, Space::Value, &item.vis),
            // A tuple or unit struct is also a value, in the same file.
            Item::Struct(item) => {
                self.item(&item.ident, Space::Type, &item.vis);
                self.item(&item.ident, Space::Value, &item.vis);
            }
            Item::Trait(item) => self.item(&item.ident, Space::Type, &item.vis),
            Item::TraitAlias(item) => self.item(&item.ident, Space::Type, &item.vis),
            Item::Type(item) => self.item(&item.ident, Space::Type, &item.vis),
            Item::Union(item) => self.item(&item.ident, Space::Type, &item.vis),
            Item::Mod(item) => {
                if let Err(error) = self.module(item) {
                    self.failed.get_or_insert(error);
                }
                return;
            }
            Item::Use(item) => return self.import(&item.tree, &[], item.leading_colon.is_some(), &item.vis),
            Item::Macro(item) => {
                if let Some(name) = &item.ident {
                    return self.macro_rules(name, item);
                }
            }
            _ => {}
        }
        self.locals.0.push(HashSet::new());
        visit::visit_item(self, item);
        self.locals.0.pop();
    }

    fn visit_impl_item(&mut self, item: &'ast syn::ImplItem) {
        let attributes = match item {
            syn::ImplItem::Const(item) => &item.attrs,
            syn::ImplItem::Fn(item) => &item.attrs,
            syn::ImplItem::Type(item) => &item.attrs,
            syn::ImplItem::Macro(item) => &item.attrs,
            _ => return,
        };
        if !is_excluded(attributes) {
            self.locals.0.push(HashSet::new());
            visit::visit_impl_item(self, item);
            self.locals.0.pop();
        }
    }

    fn visit_stmt(&mut self, statement: &'ast Stmt) {
        let attributes = match statement {
            Stmt::Local(local) => &local.attrs[..],
            Stmt::Macro(call) => &call.attrs[..],
            _ => &[],
        };
        if !is_excluded(attributes) {
            visit::visit_stmt(self, statement);
        }
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        if !is_excluded(&field.attrs) {
            visit::visit_field(self, field);
        }
    }

    fn visit_variant(&mut self, variant: &'ast syn::Variant) {
        if !is_excluded(&variant.attrs) {
            visit::visit_variant(self, variant);
        }
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        if !is_excluded(&arm.attrs) {
            visit::visit_arm(self, arm);
        }
    }

    fn visit_block(&mut self, block: &'ast syn::Block) {
        let outer = self.module;
        if block.stmts.iter().any(|statement| matches!(statement, Stmt::Item(_))) {
            self.module = self.add(self.here().file, Some(outer), true);
        }
        visit::visit_block(self, block);
        self.module = outer;
    }

    fn visit_pat_ident(&mut self, pattern: &'ast syn::PatIdent) {
        let name = pattern.ident.to_string();
        if name.starts_with(char::is_uppercase) {
            self.refer(Path { segments: vec![name], is_global: false }, Wanted::Plain);
        } else if let Some(bound) = self.locals.0.last_mut() {
            bound.insert(name);
        }
        visit::visit_pat_ident(self, pattern);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.refer(written(path), Wanted::Plain);
        visit::visit_path(self, path);
    }

    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.refer(written(&call.path), Wanted::Macro);
        self.tokens(&call.tokens);
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        let Meta::List(list) = &attribute.meta else { return };
        if list.path.is_ident("serde") {
            for path in serde_paths(list) {
                self.refer(path, Wanted::Plain);
            }
        } else if !list.path.is_ident("cfg") && !list.path.is_ident("cfg_attr") {
            self.tokens(&list.tokens);
        }
    }
}
