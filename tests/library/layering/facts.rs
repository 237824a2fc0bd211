//! What a source file names and does, read as tokens.

use super::ONLY_IN;
use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use std::collections::BTreeSet;

/// What a source file does that a rule may forbid.
#[derive(Debug, Default)]
pub struct Facts {
    /// Modules named by `crate::` or `super::`.
    pub uses: BTreeSet<String>,
    /// Outside crates of [`ONLY_IN`], and clap, that are named.
    pub crates: BTreeSet<String>,
    /// `println!` and the like, and `process::exit`.
    pub output: BTreeSet<String>,
    /// `stdout()`, `stderr()`, `.print()`.
    pub streams: BTreeSet<String>,
    /// `.display()`, which shows a path as it is.
    pub shows_paths: bool,
    pub has_unsafe: bool,
    /// Modules declared as `#[cfg(test)] mod name;`.
    pub test_modules: Vec<String>,
}

/// How deep below the crate's root the module in this file is: `simd.rs` and `scene/mod.rs` 1,
/// `scene/camera.rs` 2.
fn depth(path: &str) -> usize {
    let stem = path.trim_end_matches(".rs");
    if matches!(stem, "lib" | "main") {
        return 0;
    }
    stem.trim_end_matches("/mod").split('/').count()
}

fn ident(tree: Option<&TokenTree>) -> Option<String> {
    match tree {
        Some(TokenTree::Ident(ident)) => Some(ident.to_string()),
        _ => None,
    }
}

fn is_punct(tree: Option<&TokenTree>, c: char) -> bool {
    matches!(tree, Some(TokenTree::Punct(punct)) if punct.as_char() == c)
}

/// Whether `::` starts at `i`.
fn is_path_sep(trees: &[TokenTree], i: usize) -> bool {
    matches!(trees.get(i), Some(TokenTree::Punct(p)) if p.as_char() == ':' && p.spacing() == Spacing::Joint)
        && is_punct(trees.get(i + 1), ':')
}

impl Facts {
    pub fn of(source: &str, path: &str) -> Self {
        let tokens: TokenStream = source
            .parse()
            .unwrap_or_else(|error| panic!("{path}: not Rust: {error}"));
        let mut facts = Self::default();
        facts.scan(tokens, depth(path));
        facts
    }

    fn scan(&mut self, tokens: TokenStream, depth: usize) {
        let trees: Vec<TokenTree> = tokens.into_iter().collect();
        let mut i = 0;
        while i < trees.len() {
            if is_punct(trees.get(i), '#') && is_cfg_test(trees.get(i + 1)) {
                i = self.skip_item(&trees, i + 2);
                continue;
            }
            match &trees[i] {
                TokenTree::Group(group) => {
                    let inline_module = i >= 2 && ident(trees.get(i - 2)).as_deref() == Some("mod");
                    self.scan(group.stream(), depth + usize::from(inline_module));
                }
                TokenTree::Ident(_) => self.note(&trees, i, depth),
                _ => {}
            }
            i += 1;
        }
    }

    /// Past the item that starts at `i`: its block or its semicolon.
    fn skip_item(&mut self, trees: &[TokenTree], mut i: usize) -> usize {
        let start = i;
        while i < trees.len() {
            let ends = match &trees[i] {
                TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
                TokenTree::Punct(punct) => punct.as_char() == ';',
                _ => false,
            };
            if ends {
                let is_mod = ident(trees.get(start)).as_deref() == Some("mod");
                if is_mod && is_punct(trees.get(i), ';') {
                    self.test_modules.extend(ident(trees.get(start + 1)));
                }
                return i + 1;
            }
            i += 1;
        }
        i
    }

    fn note(&mut self, trees: &[TokenTree], i: usize, depth: usize) {
        let Some(word) = ident(trees.get(i)) else { return };
        let follows_path = i >= 2 && is_path_sep(trees, i - 2);
        match word.as_str() {
            "crate" if is_path_sep(trees, i + 1) => self.first_segments(trees, i + 3),
            "super" if !follows_path => {
                let (mut ups, mut at) = (1, i + 1);
                while is_path_sep(trees, at) && ident(trees.get(at + 2)).as_deref() == Some("super") {
                    ups += 1;
                    at += 3;
                }
                if ups >= depth && is_path_sep(trees, at) {
                    self.first_segments(trees, at + 2);
                }
            }
            "unsafe" => self.has_unsafe = true,
            "stdout" | "stderr" if is_empty_call(trees, i) && !is_definition(trees, i) => {
                self.streams.insert(format!("{word}()"));
            }
            "print" if is_empty_call(trees, i) && i > 0 && is_punct(trees.get(i - 1), '.') => {
                self.streams.insert(".print()".into());
            }
            "display" if is_empty_call(trees, i) && i > 0 && is_punct(trees.get(i - 1), '.') => {
                self.shows_paths = true;
            }
            "print" | "println" | "eprint" | "eprintln" | "dbg" if is_punct(trees.get(i + 1), '!') => {
                self.output.insert(format!("{word}!"));
            }
            "process" if is_path_sep(trees, i + 1) && ident(trees.get(i + 3)).as_deref() == Some("exit") => {
                self.output.insert("process::exit".into());
            }
            _ => {}
        }
        let named = word == "clap" || ONLY_IN.iter().any(|(name, _)| *name == word);
        let used = is_path_sep(trees, i + 1) || (i > 0 && ident(trees.get(i - 1)).as_deref() == Some("use"));
        if named && used && !follows_path {
            self.crates.insert(word);
        }
    }

    /// `crate::module` or `crate::{module::..., other}`: the word at `i`, or each one that starts a branch.
    fn first_segments(&mut self, trees: &[TokenTree], i: usize) {
        match trees.get(i) {
            Some(TokenTree::Group(group)) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                for branch in inner.split(|tree| matches!(tree, TokenTree::Punct(p) if p.as_char() == ',')) {
                    self.uses.extend(ident(branch.first()));
                }
            }
            tree => self.uses.extend(ident(tree)),
        }
    }
}

/// Whether the word at `i` is called without arguments.
fn is_empty_call(trees: &[TokenTree], i: usize) -> bool {
    let Some(TokenTree::Group(group)) = trees.get(i + 1) else {
        return false;
    };
    group.delimiter() == Delimiter::Parenthesis && group.stream().is_empty()
}

/// Whether the word at `i` is a function's name, or one of the type's own functions is called.
fn is_definition(trees: &[TokenTree], i: usize) -> bool {
    let before = |back: usize| i.checked_sub(back).and_then(|at| ident(trees.get(at)));
    before(1).as_deref() == Some("fn") || before(3).as_deref() == Some("Self")
}

fn is_cfg_test(tree: Option<&TokenTree>) -> bool {
    let Some(TokenTree::Group(group)) = tree else {
        return false;
    };
    let text: String = group.stream().to_string().split_whitespace().collect();
    group.delimiter() == Delimiter::Bracket && (text == "cfg(test)" || text.starts_with("cfg(all(test,"))
}
