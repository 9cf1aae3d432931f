//! Points that were measured or published, to mark in a figure: tables as spreadsheets write them.

use std::fs;
use std::path::Path;

use super::Failure;
use slipmap_config::{head_of, number_in};
use slipmap_machine::Machine;
use slipmap_report::View;
use slipmap_report::figure::Marks;

/// The columns of a table: those of both axes, with the factors to the units of the figure, and one of words.
struct Columns {
    axes: [(usize, f64); 2],
    observed: Option<usize>,
}

/// Reads a table whose columns are the values of the `axes` across and upwards and perhaps a word for what was observed,
/// in any order where the headers name the axes. Numbers may have decimal commas where semicolons or tabs separate them.
/// What has the same word is a series; without words the file is one.
pub(super) fn read(path: &Path, view: &View, axes: [&str; 2]) -> Result<Vec<Marks>, Failure> {
    let file = path.file_stem().unwrap_or_default().to_string_lossy().replace('_', " ");
    let told = |line: usize, problem: &str, remedy: &str| {
        let at = if line > 0 { format!(":{line}") } else { String::new() };
        Failure::bad_input(format!("--mark {}{at}: {problem}", path.display()), remedy)
    };
    if !path.is_file() {
        return Err(told(0, "there is no such file", "check the path"));
    }
    let text = fs::read(path).map_err(|error| told(0, &error.to_string(), "check the file"))?;
    let text = String::from_utf8_lossy(&text).trim_start_matches('\u{feff}').to_owned();
    let first = text.lines().next().unwrap_or_default();
    let separator = [';', '\t'].into_iter().find(|it| first.contains(*it)).unwrap_or(',');
    let number = |text: &str| {
        let text = if separator == ',' { text.to_owned() } else { text.replace(',', ".") };
        text.parse::<f64>().ok().filter(|number| number.is_finite())
    };
    let usage = "write a line of headers, and below it lines of two numbers, and perhaps a word";
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.flexible(true).trim(csv::Trim::All).delimiter(separator as u8);
    let mut reader = reader.from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| told(1, &error.to_string(), usage))?.clone();
    let rows: Vec<csv::StringRecord> = reader
        .into_records()
        .collect::<Result<_, _>>()
        .map_err(|error| told(0, &error.to_string(), usage))?;
    let is_word =
        |column: &usize| rows.first().and_then(|row| row.get(*column)).is_some_and(|it| number(it).is_none());
    let words: Vec<usize> = (0..header.len()).filter(is_word).collect();
    let columns = columns(&header, view, axes, &words);
    let columns = columns.map_err(|(problem, remedy)| told(1, &problem, &remedy))?;
    let mut all: Vec<Marks> = Vec::new();
    for row in &rows {
        let line = row.position().map_or(0, |position| position.line() as usize);
        let value = |(column, factor): (usize, f64)| Some(factor * number(row.get(column)?)?);
        let [Some(across), Some(up)] = columns.axes.map(value) else {
            let row = row.iter().collect::<Vec<_>>().join(",");
            return Err(told(line, &format!("two numbers are not in it: {row}"), usage));
        };
        let word = columns.observed.and_then(|column| row.get(column)).unwrap_or_default();
        let name = if word.is_empty() { file.clone() } else { format!("{file}: {word}") };
        match all.iter_mut().find(|marks| marks.name == name) {
            Some(marks) => marks.points.push([across, up]),
            None => all.push(Marks { name, points: vec![[across, up]] }),
        }
    }
    if all.is_empty() {
        return Err(told(0, "there are no numbers below its first line", usage));
    }
    Ok(all)
}

/// The column of each axis, and the factor from its unit to that of the figure; `words` are the columns without numbers.
fn columns(
    header: &csv::StringRecord,
    view: &View,
    axes: [&str; 2],
    words: &[usize],
) -> Result<Columns, (String, String)> {
    let heads: Vec<(String, Option<&str>)> = header
        .iter()
        .map(head_of)
        .map(|(name, unit)| (name.trim().to_lowercase().replace([' ', '-'], "_"), unit))
        .collect();
    let place = |axis: &str| heads.iter().position(|(name, _)| *name == axis.to_lowercase());
    let all = view.map.grid().axes();
    let quantities = view.map.grid().machine().map(Machine::quantities).unwrap_or_default();
    let names = all.iter().map(|axis| axis.name.as_str()).chain(quantities.iter().map(|(name, _)| *name));
    let mut others = names.filter(|name| !axes.contains(name));
    if let Some(other) = others.find(|name| place(name).is_some()) {
        let problem = format!("the column `{other}` is none of the axes of the figure");
        return Err((problem, format!("write {}, then {}", axes[0], axes[1])));
    }
    let free = |taken: Option<usize>| (0..heads.len()).find(|it| Some(*it) != taken && !words.contains(it));
    let columns = match axes.map(place) {
        [Some(across), Some(up)] => [Some(across), Some(up)],
        // A name that is no axis is that of the other column.
        [Some(across), None] => [Some(across), free(Some(across))],
        [None, Some(up)] => [free(Some(up)), Some(up)],
        [None, None] => [free(None), free(free(None))].map(|it| it.filter(|_| heads.len() > 1)),
    };
    let columns = match columns {
        [Some(across), Some(up)] if across != up => [across, up],
        _ => {
            let problem = "it needs a column for each axis".to_owned();
            return Err((problem, format!("write {}, then {}", axes[0], axes[1])));
        }
    };
    let mut found = columns.map(|column| (column, 1.0));
    for ((column, factor), axis) in found.iter_mut().zip(axes) {
        let known = all.iter().find(|known| known.name == axis);
        let wanted = known.map(|axis| view.units.axis(axis).unit.to_string()).unwrap_or_default();
        let Some(unit) = heads.get(*column).and_then(|(_, unit)| *unit) else { continue };
        if unit == wanted {
            continue;
        }
        let (number, _) = number_in(&format!("1 {unit}"), &wanted)
            .map_err(|why| (format!("column {}: {why}", *column + 1), format!("write {axis} in {wanted}")))?;
        *factor = number;
    }
    Ok(Columns { axes: found, observed: words.iter().copied().find(|word| !columns.contains(word)) })
}
