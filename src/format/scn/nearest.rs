//! Suggestions for misspelt words.

/// The one of `known` that was probably meant by `word`.
pub(super) fn nearest<'a>(word: &[u8], known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // No known word is nearly as long, and the distance takes quadratic time.
    if word.len() > 20 {
        return None;
    }
    let word = std::str::from_utf8(word).ok()?.to_lowercase();
    known
        .into_iter()
        .map(|name| (strsim::damerau_levenshtein(&word, name), name))
        .min()
        .filter(|&(distance, name)| distance <= name.len() / 3)
        .map(|(_, name)| name)
}

/// Names as a list: "`a`, `b` or `c`".
pub(super) fn list(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [only] => format!("`{only}`"),
        [others @ .., last] => format!("`{}` or `{last}`", others.join("`, `")),
    }
}

/// Names that may follow, or the end: "`a`, `b` or the end of the line".
pub(super) fn list_or_end(keys: &[&str]) -> String {
    format!("`{}` or the end of the line", keys.join("`, `"))
}

#[cfg(test)]
mod tests;
