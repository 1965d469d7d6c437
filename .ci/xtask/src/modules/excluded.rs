//! Detects items that exist only in tests.

use syn::punctuated::Punctuated;
use syn::{Attribute, Item, Meta, Token};

/// Attributes of an item of any kind.
pub(crate) fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// The item is compiled only in tests.
pub(crate) fn is_excluded(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let holds = attribute.path().is_ident("cfg").then(|| attribute.parse_args::<Meta>().ok()).flatten();
        attribute.path().is_ident("test")
            || holds.is_some_and(|condition| without_tests(&condition) == Some(false))
    })
}

/// Value of a `cfg` condition without `test`; none if it depends on other options.
fn without_tests(condition: &Meta) -> Option<bool> {
    match condition {
        Meta::Path(path) if path.is_ident("test") => Some(false),
        Meta::List(list) => {
            let parts = list.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated).ok()?;
            let parts: Vec<Option<bool>> = parts.iter().map(without_tests).collect();
            // One deciding operand is enough, whatever the others are.
            let decided_by = |one: bool| {
                if parts.contains(&Some(one)) {
                    Some(one)
                } else {
                    parts.iter().all(|part| *part == Some(!one)).then_some(!one)
                }
            };
            match &list.path {
                path if path.is_ident("not") => parts.first().copied().flatten().map(|part| !part),
                path if path.is_ident("all") => decided_by(false),
                path if path.is_ident("any") => decided_by(true),
                _ => None,
            }
        }
        _ => None,
    }
}
