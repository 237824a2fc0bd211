//! The config file: defaults for options of `octray render`.
//!
//! A key is an option's long name. The file becomes arguments before those of the command line, so every option of
//! `render` works in the file and is checked as on the command line, with its place in the file.

use super::{camera::Ortho, definition};
use crate::{
    cli::{CliError, plan::ConfigDefault},
    error::{LoadError, SourcePos, clip, io_reason},
    format,
};
use clap::{
    Arg, ArgAction, ArgMatches, Args, Command,
    error::{ContextKind, ContextValue, ErrorKind},
    parser::ValueSource,
};
use std::{
    any::TypeId,
    env,
    ffi::OsString,
    io::{self, Read},
    ops::Range,
    path::{Path, PathBuf},
};
use toml::{Spanned, de::DeTable, de::DeValue};

/// The largest file, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Options that make no sense in a file of defaults. With `force` in it, every call would replace any file.
const NO_KEYS: [&str; 5] = ["config", "force", "help", "no-config", "version"];

/// Options of cameras that frame no mesh, so that `--ortho fit` excludes them.
const PLACES: [&str; 3] = ["camera", "eye", "view"];

/// Where defaults come from.
#[derive(Args, Debug)]
#[command(next_help_heading = "Configuration")]
pub struct ConfigArgs {
    /// Read default options from a TOML file [default: octray/config.toml in $XDG_CONFIG_HOME or ~/.config, if it exists]
    #[arg(long, value_name = "FILE", conflicts_with = "no_config")]
    pub config: Option<PathBuf>,

    /// Read no config file
    #[arg(long)]
    pub no_config: bool,
}

impl ConfigArgs {
    /// The file, if there is one.
    pub fn path(&self) -> Option<PathBuf> {
        match &self.config {
            Some(path) => Some(path.clone()),
            None if self.no_config => None,
            None => usual_place().filter(|path| path.exists()),
        }
    }
}

/// A command line with the config file's defaults added.
pub struct WithDefaults {
    pub arguments: Vec<OsString>,
    /// The options that were added.
    pub options: Vec<ConfigDefault>,
}

/// A parsed command line of `render` with the config file's defaults added, except for the options with the ids `ignored`;
/// `None` if there is no file.
///
/// # Errors
/// [`CliError::Load`], with the place of the fault: file not found, invalid TOML, an unknown option, an invalid value.
pub fn with_defaults(
    arguments: &[OsString],
    matches: &ArgMatches,
    args: &ConfigArgs,
    ignored: &[&str],
) -> Result<Option<WithDefaults>, CliError> {
    let Some(path) = args.path() else {
        return Ok(None);
    };
    let text = read(&path).map_err(|error| LoadError::whole_file(&path, io_reason(&error)))?;
    let file = File { path, text: &text };
    let defaults = file.defaults()?;
    let given = |id: &str| matches.value_source(id) == Some(ValueSource::CommandLine);
    let fits = matches.get_one("ortho") == Some(&Ortho::Fit) && given("ortho");
    let excluded_by_value = |id: &str| fits && PLACES.contains(&id);
    let applies = |default: &&Setting| {
        // The command line wins, also over options that it excludes.
        !given(&default.id)
            && !default.excludes.iter().any(|id| given(id))
            && !excluded_by_value(&default.id)
            && !ignored.contains(&default.id.as_str())
            && default.argument.is_some()
    };
    let usable: Vec<&Setting> = defaults.iter().filter(applies).collect();
    let is_there = |id: &String| given(id) || usable.iter().any(|other| other.id == *id);
    let kept = usable.iter().filter(|default| default.needs.iter().all(is_there));
    let kept = kept.filter_map(|default| Some((default.argument.clone()?, file.added(default))));
    let (added, options): (Vec<_>, Vec<_>) = kept.unzip();
    // After the names of the program and the command.
    let (command, rest) = arguments.split_at(2);
    Ok(Some(WithDefaults {
        arguments: [command, &added, rest].concat(),
        options,
    }))
}

/// Whether `octray render` reads a config file unless told otherwise.
#[cfg(feature = "viewer")]
pub fn is_present() -> bool {
    usual_place().is_some_and(|path| path.exists())
}

fn usual_place() -> Option<PathBuf> {
    let set = |name| env::var_os(name).map(PathBuf::from);
    // The XDG standard: a relative path is ignored.
    let folder = set("XDG_CONFIG_HOME").filter(|folder| folder.is_absolute());
    let folder = folder.or_else(|| Some(set("HOME")?.join(".config")))?;
    Some(folder.join("octray").join("config.toml"))
}

fn read(path: &Path) -> io::Result<String> {
    let file = format::open_file(path)?;
    let mut text = String::new();
    let length = file.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    if length as u64 > MAX_BYTES {
        return Err(io::Error::other(format!(
            "the file is larger than {MAX_BYTES} bytes"
        )));
    }
    Ok(text)
}

/// An option's default from the file.
struct Setting {
    id: String,
    /// Its long name.
    name: String,
    /// Options that conflict with it.
    excludes: Vec<String>,
    /// Options without which it has no effect.
    needs: Vec<String>,
    /// `None` for a switch that is off.
    argument: Option<OsString>,
    /// Its value, if that is a file's name or free text.
    words: Option<String>,
    key: Range<usize>,
}

struct File<'a> {
    path: PathBuf,
    text: &'a str,
}

impl File<'_> {
    fn defaults(&self) -> Result<Vec<Setting>, LoadError> {
        let render = render_command();
        let table = DeTable::parse(self.text)
            .map_err(|error| self.invalid(&render, error.span().unwrap_or(0..0), error.message()))?;
        let mut entries: Vec<_> = table.get_ref().iter().collect();
        // Faults are reported in the order of the file.
        entries.sort_by_key(|(key, _)| key.span().start);
        let mut defaults: Vec<Setting> = Vec::new();
        for (key, value) in entries {
            let default = self.default(&render, key.get_ref(), key.span(), value)?;
            if let Some(other) = defaults.iter().find(|other| {
                let both = default.argument.is_some() && other.argument.is_some();
                both && (other.excludes.contains(&default.id) || default.excludes.contains(&other.id))
            }) {
                let message = format!(
                    "`{}` cannot be used with `{}`",
                    key.get_ref(),
                    &self.text[other.key.clone()]
                );
                return Err(self.fault(key.span(), &message));
            }
            defaults.push(default);
        }
        Ok(defaults)
    }

    fn default(
        &self,
        render: &Command,
        key: &str,
        span: Range<usize>,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<Setting, LoadError> {
        let option = options(render).find(|option| option.get_long() == Some(key));
        let option = option.ok_or_else(|| {
            let message = match value.get_ref() {
                DeValue::Table(_) => format!("a config file has no sections; remove `[{}]`", clip(key)),
                _ => no_option(render, key),
            };
            self.fault(span.clone(), &message)
        })?;
        let fault = |message: &str| self.fault(value.span(), message);
        let is_switch = matches!(option.get_action(), ArgAction::SetTrue);
        let needs_value = option.get_num_args().is_none_or(|count| count.min_values() > 0);
        let argument = match value.get_ref() {
            DeValue::Boolean(on) if is_switch || !needs_value => on.then(|| format!("--{key}")),
            _ if is_switch => {
                return Err(fault(&no_switch(key)));
            }
            value => {
                let text = text(value).ok_or_else(|| {
                    fault(&format!(
                        "expected a string, a number, or a list of them, as after --{key} on the command line"
                    ))
                })?;
                Some(format!("--{key}={text}"))
            }
        };
        let needs = match &argument {
            Some(argument) => check(render, argument).map_err(|message| fault(&message))?,
            None => Vec::new(),
        };
        let has_words = [TypeId::of::<PathBuf>(), TypeId::of::<String>()]
            .iter()
            .any(|kind| option.get_value_parser().type_id() == *kind);
        Ok(Setting {
            id: option.get_id().to_string(),
            words: text(value.get_ref()).filter(|_| has_words),
            name: key.to_owned(),
            excludes: excluded(render, option),
            needs,
            argument: argument.map(OsString::from),
            key: span,
        })
    }

    /// A default that is added to a command line.
    fn added(&self, setting: &Setting) -> ConfigDefault {
        let key = setting.key.clone();
        let at = SourcePos::in_text(&self.path, self.text.as_bytes(), key.start);
        ConfigDefault {
            id: setting.id.clone(),
            name: setting.name.clone(),
            words: setting.words.clone(),
            at,
        }
    }

    /// The error about text that is not TOML.
    fn invalid(&self, render: &Command, span: Range<usize>, message: &str) -> LoadError {
        // After an f or a t the parser expects false or true.
        if !message.contains("must be quoted") && !message.starts_with("invalid boolean") {
            return self.fault(span, message);
        }
        let start = self.text[..span.start].rfind('\n').map_or(0, |end| end + 1);
        let line = self.text[start..].lines().next().unwrap_or_default();
        let (key, value) = line.split_once('=').unwrap_or_default();
        let (key, value) = (key.trim(), value.split('#').next().unwrap_or_default().trim());
        let option = options(render).find(|option| option.get_long() == Some(key));
        let message = match option.map(|option| matches!(option.get_action(), ArgAction::SetTrue)) {
            Some(true) => no_switch(key),
            Some(false) if value.is_empty() => format!("`{key}` has no value"),
            Some(false) if !value.contains(['"', '[', '\\']) => {
                format!("text needs quotes: {key} = \"{}\"", clip(value))
            }
            _ => "text needs quotes".to_owned(),
        };
        self.fault(span, &message)
    }

    fn fault(&self, span: Range<usize>, message: &str) -> LoadError {
        // A parser's message may have several lines.
        LoadError::in_text(
            &self.path,
            self.text.as_bytes(),
            span,
            message.replace('\n', ", "),
        )
    }
}

fn render_command() -> Command {
    let mut all = definition();
    all.build();
    all.find_subcommand("render").cloned().unwrap_or_default()
}

/// The options that may be keys.
fn options(render: &Command) -> impl Iterator<Item = &Arg> {
    let is_key = |option: &&Arg| option.get_long().is_some_and(|long| !NO_KEYS.contains(&long));
    render.get_arguments().filter(is_key)
}

fn no_switch(key: &str) -> String {
    format!("`{key}` is a switch, expected true or false")
}

fn no_option(render: &Command, key: &str) -> String {
    if NO_KEYS.contains(&key) {
        return format!("`{key}` belongs on the command line, not in a file of defaults");
    }
    // The distance takes quadratic time and memory.
    let names = options(render)
        .filter_map(Arg::get_long)
        .filter(|_| key.len() < 100);
    let near = names
        .map(|name| (strsim::damerau_levenshtein(name, key), name))
        .min()
        .filter(|(distance, name)| *distance <= name.len().div_ceil(3));
    let key = clip(key);
    match near {
        Some((_, near)) => format!("`octray render` has no option `{key}`, did you mean `{near}`?"),
        None => format!("`octray render` has no option `{key}`; `octray render --help` lists them"),
    }
}

/// A value as on the command line.
fn text(value: &DeValue<'_>) -> Option<String> {
    Some(match value {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(number) if number.radix() == 10 => number.as_str().into(),
        DeValue::Float(number) => number.as_str().into(),
        DeValue::Array(values) => {
            let texts: Option<Vec<String>> = values.iter().map(|value| text(value.get_ref())).collect();
            texts?.join(",")
        }
        _ => return None,
    })
}

/// Checks the value of an argument of `render`. Returns the options that it needs.
fn check(render: &Command, argument: &str) -> Result<Vec<String>, String> {
    let parsed = |argument: &str| {
        render
            .clone()
            .try_get_matches_from(["render", argument, "--", "scene"])
    };
    // The message repeats the value, from which clap would take escape sequences out.
    match parsed(argument).map_err(|error| parsed(&clip(argument)).err().unwrap_or(error)) {
        Ok(_) => Ok(Vec::new()),
        Err(error) if error.kind() == ErrorKind::MissingRequiredArgument => Ok(missing(render, &error)),
        Err(error) => {
            let message = error.to_string();
            let lines = message.lines().take_while(|line| !line.trim().is_empty());
            let lines: Vec<&str> = lines.map(str::trim).collect();
            let message = lines.join(" ");
            Err(message.strip_prefix("error: ").unwrap_or(&message).to_owned())
        }
    }
}

/// The options that clap misses.
fn missing(render: &Command, error: &clap::Error) -> Vec<String> {
    let Some(ContextValue::Strings(usages)) = error.get(ContextKind::InvalidArg) else {
        return Vec::new();
    };
    // Such as `--compare <REFERENCE>` and `--edges[=<WIDTH>]`.
    let names = usages
        .iter()
        .filter_map(|usage| usage.split([' ', '[']).next()?.strip_prefix("--"));
    let option = |name: &str| options(render).find(|option| option.get_long() == Some(name));
    names
        .filter_map(|name| Some(option(name)?.get_id().to_string()))
        .collect()
}

/// The options that conflict with this one, whichever of the two declares it.
fn excluded(render: &Command, option: &Arg) -> Vec<String> {
    let names = |one: &Arg, other: &Arg| {
        let conflicts = render.get_arg_conflicts_with(one);
        conflicts
            .iter()
            .any(|conflict| conflict.get_id() == other.get_id())
    };
    let others = render.get_arguments();
    others
        .filter(|other| names(option, other) || names(other, option))
        .map(|other| other.get_id().to_string())
        .collect()
}
