//! Paths in unparsed tokens: the arguments of macros and attributes.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::punctuated::Punctuated;
use syn::{Meta, Token};

use super::source::{Path, Wanted};

/// Paths in these tokens: those of several segments, and single names that look like a type, a constant, a call or a
/// macro.
pub(crate) fn paths(tokens: TokenStream) -> Vec<(Path, Wanted)> {
    let mut found = Vec::new();
    collect(tokens, &mut found);
    found
}

fn is_punctuation(token: Option<&TokenTree>, wanted: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punctuation)) if punctuation.as_char() == wanted)
}

fn collect(tokens: TokenStream, found: &mut Vec<(Path, Wanted)>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let colons = |at: usize| is_punctuation(tokens.get(at), ':') && is_punctuation(tokens.get(at + 1), ':');
    let mut at = 0;
    while at < tokens.len() {
        match &tokens[at] {
            TokenTree::Group(group) => collect(group.stream(), found),
            TokenTree::Ident(first) => {
                let before = at;
                let mut segments = vec![first.to_string()];
                while colons(at + 1) {
                    let Some(TokenTree::Ident(next)) = tokens.get(at + 3) else { break };
                    segments.push(next.to_string());
                    at += 3;
                }
                let is_macro =
                    is_punctuation(tokens.get(at + 1), '!') && !is_punctuation(tokens.get(at + 2), '=');
                let is_call = matches!(tokens.get(at + 1), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
                // A field, a method, a macro variable, or the end of another path.
                let preceded = before > 0
                    && (is_punctuation(tokens.get(before - 1), '.')
                        || is_punctuation(tokens.get(before - 1), '$'));
                let is_global = before >= 2 && colons(before - 2);
                let looks_like_one =
                    segments.len() > 1 || segments[0].starts_with(char::is_uppercase) || is_call || is_macro;
                if looks_like_one && (!preceded || segments[0] == "crate") {
                    found.push((
                        Path { segments, is_global },
                        if is_macro { Wanted::Macro } else { Wanted::Plain },
                    ));
                }
            }
            _ => {}
        }
        at += 1;
    }
}

/// A path without its arguments.
pub(crate) fn written(path: &syn::Path) -> Path {
    let segments = path
        .segments
        .iter()
        .map(|segment| segment.ident.to_string().trim_start_matches("r#").to_owned())
        .collect();
    Path { segments, is_global: path.leading_colon.is_some() }
}

/// Paths in serde attributes: `with = "module"`, `default = "function"` and similar.
pub(crate) fn serde_paths(list: &syn::MetaList) -> Vec<Path> {
    const KEYS: [&str; 8] = [
        "with",
        "default",
        "serialize_with",
        "deserialize_with",
        "skip_serializing_if",
        "from",
        "into",
        "try_from",
    ];
    let mut found = Vec::new();
    let Ok(pairs) = list.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated) else {
        return found;
    };
    for pair in pairs {
        let Meta::NameValue(pair) = pair else { continue };
        let syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) = &pair.value else { continue };
        if !KEYS.iter().any(|key| pair.path.is_ident(key)) {
            continue;
        }
        if let Ok(path) = text.parse::<syn::Path>() {
            let mut path = written(&path);
            if pair.path.is_ident("with") {
                // The function called in this module.
                path.segments.push("serialize".to_owned());
            }
            found.push(path);
        }
    }
    found
}
