//! A configuration file with the `--set` overrides applied. Keeps the place (line or override) of every
//! value, for error messages.

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use slipmap_numbers::text::{quoted, with_short_quotes};
use toml_edit::{Document, DocumentMut, InlineTable, Item, Key, Table, TableLike, Value};

/// An error in a configuration: its place, the problem and the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}\n  help: {remedy}")]
pub struct ConfigError {
    /// `file:line:column`, or the `--set` argument.
    pub(crate) place: String,
    /// The key, its value and what is wrong with it.
    pub problem: String,
    /// What to do instead.
    pub remedy: String,
}

impl ConfigError {
    pub(super) fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { place: place.into(), problem: with_short_quotes(&problem.into()), remedy: remedy.into() }
    }
}

/// One `--set key.path=value`.
#[derive(Clone, Debug)]
struct Override {
    /// The argument as it was typed.
    argument: String,
    /// The key that it sets.
    path: Vec<Step>,
}

/// One step from a table to an entry, or from a list to an element.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Index(usize),
}

/// A configuration file with its overrides applied.
#[derive(Debug)]
pub(super) struct ConfigFile {
    pub(super) file: PathBuf,
    original: Document<String>,
    effective: DocumentMut,
    overrides: Vec<Override>,
}

impl ConfigFile {
    /// Reads `file` and applies the overrides in turn, each `key.path=value`; refuses one that an earlier one would be
    /// lost by.
    pub(super) fn load(file: &Path, sets: &[String]) -> Result<Self, ConfigError> {
        let original = parse(file, read(file)?)?;
        let effective = original.clone().into_mut();
        let mut source = Self { file: file.to_owned(), original, effective, overrides: Vec::new() };
        for argument in sets {
            source.set(argument)?;
        }
        Ok(source)
    }

    /// The text with the overridden values replaced; comments are kept.
    pub(super) fn text(&self) -> String {
        self.effective.to_string()
    }

    /// The whole document as a table.
    pub(super) fn root(&self) -> Section<'_> {
        Section { source: self, path: Vec::new(), table: Some(self.effective.as_table()) }
    }

    /// Applies one override.
    fn set(&mut self, argument: &str) -> Result<(), ConfigError> {
        let error =
            |problem: String, remedy: &str| ConfigError::new(format!("--set {argument}"), problem, remedy);
        let usage = "write --set key.path=value, for example --set simulation.tolerance=1e-10";
        let Some((key, value)) = argument.split_once('=') else {
            return Err(error("there is no `=` in it".into(), usage));
        };
        let keys = Key::parse(key.trim())
            .map_err(|e| error(format!("`{key}` is not a key path: {}", e.message().trim()), usage))?;
        let value = override_value(value.trim()).map_err(|why| {
            error(format!("its value is not valid TOML: {why}"), "quote text, close every bracket")
        })?;

        let Some((last, parents)) = keys.split_last() else {
            return Err(error("it names no key".into(), usage));
        };
        let path: Vec<Step> = keys.iter().map(|key| Step::Key(key.get().into())).collect();
        if let Some(twice) = self.overrides.iter().find(|set| set.path.starts_with(&path)) {
            let problem = format!("it is set twice, here and by --set {}", twice.argument);
            return Err(error(problem, "leave one of them out"));
        }
        let mut table: &mut dyn TableLike = self.effective.as_table_mut();
        for (depth, key) in parents.iter().enumerate() {
            // Sections become [tables], anything deeper an inline table, as a person would write them.
            let missing =
                if depth == 0 { Item::Table(Table::new()) } else { Item::Value(InlineTable::new().into()) };
            let item = table.entry(key.get()).or_insert(missing);
            let what = kind_of(item);
            table = item.as_table_like_mut().ok_or_else(|| {
                error(
                    format!("`{}` is {what}, which has no key `{}`", key.get(), last.get()),
                    "set the whole value instead",
                )
            })?;
        }
        match table.get_mut(last.get()).and_then(Item::as_value_mut) {
            Some(old) => {
                // The decoration is the white space and the comment around the old value.
                let decor = old.decor().clone();
                *old = value;
                *old.decor_mut() = decor;
            }
            None => drop(table.insert(last.get(), Item::Value(value))),
        }
        self.overrides.push(Override { argument: argument.into(), path });
        Ok(())
    }

    /// Place where the entry at `path` was written: the place of its key if `at_key`, else of its value. For
    /// a missing entry, the place of its nearest parent.
    fn place(&self, path: &[Step], at_key: bool) -> String {
        if let Some(set) = self.overrides.iter().rev().find(|set| path.starts_with(&set.path)) {
            return format!("--set {}", set.argument);
        }
        let mut offset = 0;
        let mut found = 0;
        let mut at = self.original.as_item();
        for (i, step) in path.iter().enumerate() {
            let next = match step {
                Step::Key(key) => at
                    .as_table_like()
                    .and_then(|table| table.get_key_value(key))
                    .map(|(key, item)| (key.span(), item)),
                Step::Index(index) => at.get(*index).map(|item| (None, item)),
            };
            let Some((key, next)) = next else { break };
            let value = next.span();
            let last = i + 1 == path.len();
            let span = if last && at_key { key.or(value) } else { value.or(key) };
            offset = span.map_or(offset, |span| span.start);
            found = i + 1;
            at = next;
        }
        // An entry that is missing from the file may be missing from a table of an override.
        let maker = path
            .get(..=found)
            .and_then(|made| self.overrides.iter().rev().find(|set| set.path.starts_with(made)));
        if let Some(set) = maker {
            return format!("--set {}", set.argument);
        }
        position(&self.file, self.original.raw(), offset)
    }

    fn error(&self, path: &[Step], at_key: bool, problem: String, remedy: String) -> ConfigError {
        ConfigError::new(self.place(path, at_key), problem, remedy)
    }
}

/// A table of the configuration, or one left out.
pub(super) struct Section<'a> {
    source: &'a ConfigFile,
    path: Vec<Step>,
    table: Option<&'a dyn TableLike>,
}

impl<'a> Section<'a> {
    /// The entry of this name, if there is one.
    pub(super) fn get(&self, key: &str) -> Option<Node<'a>> {
        let item = self.table?.get(key).filter(|item| !item.is_none())?;
        Some(Node { source: self.source, path: self.child(key), item })
    }

    /// A text that the file has for this entry, or in it, and that `is_meant`, also where the entry is overridden.
    pub(super) fn text_in_file(&self, key: &str, is_meant: impl Fn(&str) -> bool) -> Option<&'a str> {
        let mut item = self.source.original.as_item();
        for step in self.child(key) {
            let Step::Key(key) = step else { return None };
            item = item.as_table_like()?.get(&key)?;
        }
        texts(item).find(|text| is_meant(text))
    }

    /// The entry of this name converted by `read`; `default` where there is no such entry.
    pub(super) fn get_or<T>(
        &self,
        key: &str,
        default: T,
        read: impl FnOnce(&Node<'a>) -> Result<T, ConfigError>,
    ) -> Result<T, ConfigError> {
        self.get(key).map_or(Ok(default), |node| read(&node))
    }

    /// The table of this name, or an empty one.
    pub(super) fn section(&self, key: &str) -> Result<Section<'a>, ConfigError> {
        match self.get(key) {
            Some(node) => match node.shape() {
                Shape::Table(table) => Ok(table),
                _ => Err(node.wrong_kind("a table")),
            },
            None => Ok(Section { source: self.source, path: self.child(key), table: None }),
        }
    }

    /// Returns whether the file or an override has this table.
    pub(super) fn is_present(&self) -> bool {
        self.table.is_some()
    }

    pub(super) fn keys(&self) -> Vec<String> {
        self.table.map_or(Vec::new(), |table| {
            table.iter().filter(|(_, item)| !item.is_none()).map(|(key, _)| key.into()).collect()
        })
    }

    pub(super) fn unknown(&self, key: &str, remedy: String) -> ConfigError {
        let place = self.name().map(|section| format!(" in {section}")).unwrap_or_default();
        self.source.error(&self.child(key), true, format!("unknown key `{key}`{place}"), remedy)
    }

    pub(super) fn missing(&self, key: &str, remedy: String) -> ConfigError {
        let place = self.name().map(|section| format!(" from {section}")).unwrap_or_default();
        self.source.error(&self.child(key), true, format!("`{key}` is missing{place}"), remedy)
    }

    /// Name in messages: `[section]`, or `grid.alpha` for a table that is a value; `None` for the whole file.
    fn name(&self) -> Option<String> {
        match self.path.as_slice() {
            [] => None,
            [Step::Key(section)] => Some(format!("[{section}]")),
            path => Some(dotted(path)),
        }
    }

    fn child(&self, key: &str) -> Vec<Step> {
        let mut path = self.path.clone();
        path.push(Step::Key(key.into()));
        path
    }
}

/// One value of the configuration.
pub(super) struct Node<'a> {
    source: &'a ConfigFile,
    path: Vec<Step>,
    item: &'a Item,
}

/// Kind of a value, for callers that accept several kinds.
pub(super) enum Shape<'a> {
    Number,
    List(Vec<Node<'a>>),
    Table(Section<'a>),
    Text,
    /// Anything else.
    Other,
}

impl<'a> Node<'a> {
    /// The value, by kind.
    pub(super) fn shape(&self) -> Shape<'a> {
        if as_number(self.item).is_some() {
            Shape::Number
        } else if let Some(elements) = self.elements() {
            Shape::List(elements)
        } else if let Some(table) = self.item.as_table_like() {
            Shape::Table(Section { source: self.source, path: self.path.clone(), table: Some(table) })
        } else if self.item.is_str() {
            Shape::Text
        } else {
            Shape::Other
        }
    }

    /// The entry as a table of the document.
    pub(super) fn entries(&self) -> Option<&'a dyn TableLike> {
        self.item.as_table_like()
    }

    /// The value as a number, whole or not.
    pub(super) fn number(&self) -> Result<f64, ConfigError> {
        as_number(self.item).ok_or_else(|| self.wrong_kind("a number"))
    }

    /// The value as a whole number from `lo` to `hi`, as far as the type `T` holds them.
    pub(super) fn integer<T: TryFrom<i64>>(&self, lo: i64, hi: i64) -> Result<T, ConfigError> {
        let value = self.item.as_integer();
        let value = value.ok_or_else(|| self.wrong_kind("a whole number"))?;
        let legal = Some(value).filter(|value| (lo..=hi).contains(value));
        legal.and_then(|value| T::try_from(value).ok()).ok_or_else(|| {
            let (problem, remedy) = if hi == i64::MAX {
                (format!("must be at least {lo}"), format!("choose a whole number of at least {lo}"))
            } else {
                (format!("must be from {lo} to {hi}"), format!("choose a whole number from {lo} to {hi}"))
            };
            self.error(&problem, remedy)
        })
    }

    pub(super) fn text(&self) -> Result<&'a str, ConfigError> {
        self.item.as_str().ok_or_else(|| self.wrong_kind("text in quotes"))
    }

    /// Whether it is, or has in it, a text that `is_meant`.
    pub(super) fn has_text(&self, is_meant: impl Fn(&str) -> bool) -> bool {
        texts(self.item).any(is_meant)
    }

    /// The value as true or false.
    pub(super) fn truth(&self) -> Result<bool, ConfigError> {
        self.item.as_bool().ok_or_else(|| self.wrong_kind("true or false"))
    }

    /// The value as a list; `wanted` describes the elements in messages.
    pub(super) fn list(&self, wanted: &str) -> Result<Vec<Node<'a>>, ConfigError> {
        self.elements().ok_or_else(|| self.wrong_kind(wanted))
    }

    fn elements(&self) -> Option<Vec<Node<'a>>> {
        let element = |i| {
            let path = [&self.path[..], &[Step::Index(i)]].concat();
            Some(Node { source: self.source, path, item: self.item.get(i)? })
        };
        (0..self.item.as_array()?.len()).map(element).collect()
    }

    pub(super) fn error(&self, problem: &str, remedy: impl Into<String>) -> ConfigError {
        let problem = format!("{} = {}: {problem}", dotted(&self.path), self.written());
        self.source.error(&self.path, false, problem, remedy.into())
    }

    /// Error: this value is of another kind than `wanted`.
    pub(super) fn wrong_kind(&self, wanted: &str) -> ConfigError {
        let number = self.item.as_str().filter(|_| wanted.contains("number"));
        let remedy = number.and_then(|text| match text.trim().parse::<f64>() {
            Ok(number) => Some(format!("write it without quotes: {number}")),
            Err(_) => decimal_comma(text),
        });
        let remedy = remedy.unwrap_or_else(|| format!("write {wanted}"));
        self.error(&format!("this is {}, not {wanted}", kind_of(self.item)), remedy)
    }

    /// The value as written, shortened to fit into a line.
    fn written(&self) -> String {
        match self.item {
            // Without the comment that may follow it.
            Item::Value(value) => quoted(&value.clone().decorated("", "").to_string()),
            _ => "[..]".into(),
        }
    }
}

/// The text of an item, and those in it.
fn texts(item: &Item) -> impl Iterator<Item = &str> {
    let of_list = item.as_array().into_iter().flatten().filter_map(Value::as_str);
    let of_table = item.as_table_like().into_iter().flat_map(TableLike::iter);
    let of_table = of_table.filter_map(|(_, item)| item.as_str());
    item.as_str().into_iter().chain(of_list).chain(of_table)
}

/// A whole or a real number.
fn as_number(item: &Item) -> Option<f64> {
    item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64))
}

fn kind_of(item: &Item) -> &'static str {
    match item {
        Item::None => "nothing",
        Item::Value(Value::String(_)) => "text",
        Item::Value(Value::Integer(_)) => "a whole number",
        Item::Value(Value::Float(_)) => "a number",
        Item::Value(Value::Boolean(_)) => "a truth value",
        Item::Value(Value::Datetime(_)) => "a date",
        Item::Value(Value::Array(_)) => "a list",
        Item::Value(Value::InlineTable(_)) | Item::Table(_) => "a table",
        Item::ArrayOfTables(_) => "a list of tables",
    }
}

/// A key path as text: `grid.alpha[2]`.
fn dotted(path: &[Step]) -> String {
    let mut text = String::new();
    for step in path {
        match step {
            Step::Key(key) if text.is_empty() => text.push_str(key),
            Step::Key(key) => drop(write!(text, ".{key}")),
            Step::Index(i) => drop(write!(text, "[{i}]")),
        }
    }
    text
}

/// Parses the value of an override: TOML, or bare words taken as text.
fn override_value(text: &str) -> Result<Value, String> {
    match text.parse::<Value>() {
        Ok(value) => Ok(value),
        // A value that opens like a TOML string, list or table was meant as one.
        Err(error) if text.is_empty() || text.starts_with(['"', '\'', '[', '{']) => {
            Err(error.message().trim().replace('\n', " "))
        }
        Err(_) => Ok(Value::from(text)),
    }
}

/// Largest size of a configuration in bytes.
const LONGEST: u64 = 16 << 20;

fn read(file: &Path) -> Result<String, ConfigError> {
    let error = |problem: &str, remedy: &str| ConfigError::new(file.display().to_string(), problem, remedy);
    if file.is_dir() {
        return Err(error("this is a folder, not a configuration file", "name a TOML file inside it"));
    }
    let mut bytes = Vec::new();
    // The length is limited because some files never end.
    let read = std::fs::File::open(file).and_then(|open| open.take(LONGEST + 1).read_to_end(&mut bytes));
    read.map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => error(
            "there is no such file",
            "check the path; a configuration to start from is written by: slipmap init",
        ),
        _ => error(&format!("cannot be read: {e}"), "check the file's permissions"),
    })?;
    if bytes.len() as u64 > LONGEST {
        return Err(error(
            &format!("this is longer than {} MiB, and no configuration", LONGEST >> 20),
            "name a configuration; a long axis is written { from = 0.0, to = 1.0, points = 100000 }",
        ));
    }
    if bytes.starts_with(b"\x89HDF\r\n\x1a\n") {
        return Err(error(
            "this is a map, not a configuration file",
            "name the configuration to run; `slipmap report` and `slipmap plot` read maps",
        ));
    }
    // The byte order marks that some editors write.
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(error("this file is written in UTF-16", "save it as UTF-8"));
    }
    String::from_utf8(bytes).map_err(|e| {
        let valid = String::from_utf8_lossy(&e.as_bytes()[..e.utf8_error().valid_up_to()]).into_owned();
        let (problem, remedy) =
            ("the text is not UTF-8 from here on", "save the file with the encoding UTF-8");
        ConfigError::new(position(file, &valid, valid.len()), problem, remedy)
    })
}

/// The remedy for a number with a decimal comma; `None` for other texts.
pub fn decimal_comma(text: &str) -> Option<String> {
    let (whole, decimals) = text.trim().split_once(',')?;
    let number = format!("{}.{}", whole.trim(), decimals.trim());
    number.parse::<f64>().ok().map(|_| match decimals.trim().len() == 3 && !whole.trim().starts_with('0') {
        // A separator of thousands, or a decimal comma.
        true => format!(
            "write {}{} without a separator, or {number} with a decimal point",
            whole.trim(),
            decimals.trim()
        ),
        false => format!("write decimals with a point: {number}"),
    })
}

/// The remedy for a number with a unit behind it; `None` for other texts.
fn without_unit(text: &str) -> Option<String> {
    let text = text.trim();
    let ends = text.char_indices().map(|(at, _)| at).rev();
    let number = ends.map(|end| text[..end].trim_end()).find(|part| part.parse::<f64>().is_ok())?;
    Some(format!("write the number alone, in SI units: {number}"))
}

fn parse(file: &Path, text: String) -> Result<Document<String>, ConfigError> {
    Document::parse(text.clone()).map_err(|e| {
        let offset = e.span().map_or(0, |span| span.start);
        let line_ends = |part: &str| part.find(['\n', '#']).unwrap_or(part.len());
        let start = text.get(..offset).and_then(|before| before.rfind(['\n', '='])).map_or(0, |at| at + 1);
        let value = text.get(start..).map_or("", |rest| &rest[..line_ends(rest)]);
        let problem = format!("not valid TOML: {}", e.message().trim().replace('\n', " "));
        let shown = || "correct this line; how values are written shows the file of: slipmap init".into();
        // Such as .5 or 5., which TOML does not take.
        let number = || value.trim().parse::<f64>().ok().map(|number| format!("write {number:?}"));
        let remedy =
            decimal_comma(value).or_else(number).or_else(|| without_unit(value)).unwrap_or_else(shown);
        ConfigError::new(position(file, &text, offset), problem, remedy)
    })
}

/// Place as `file:line:column`, counted from 1 in characters.
fn position(file: &Path, text: &str, offset: usize) -> String {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |rest| rest.chars().count()) + 1;
    format!("{}:{line}:{column}", file.display())
}
