//! The rows of measured data: both directions of slip folded, phases of rest reduced to the friction at which they
//! end, and the rest sorted by slip speed.

use super::columns::{self, Columns, Header};
use super::text::{self, Decimal, Fields, Line};
use super::{Direction, How, Measured, MeasuredReading, Refused, RowKind, slopes};
use slipmap_fit::breakaway;
use slipmap_numbers::text::rounded;

/// Share of the largest speed within which negative speeds with friction of the same sign are noise about rest.
const NOISE: f64 = 0.03;
/// Least share of the largest speed of a turn from faster to slower or back, and least number of these in a record without
/// times.
const OF_A_TURN: f64 = 0.2;
const TURNS: usize = 2;
/// Least number of rows of a record over time: fewer, even with their times, are readings written down.
const FEWEST_IN_RECORD: usize = 60;
/// Largest mean step of the speed from row to row of a record, in units of that of rows without order.
const LARGEST_STEP: f64 = 0.2;
/// Largest share of rows whose time is before that of the row before: runs may be joined.
const BACK_IN_TIME: f64 = 0.1;
/// Step from one speed to the next of a staircase, in units of the median step, and least number of rows at one.
const OF_A_STAIR: f64 = 5.0;
const ROWS_OF_A_STAIR: usize = 3;
/// Largest plausible coefficient of friction.
const HIGHEST_FRICTION: f64 = 5.0;
/// Number of lines named in a message.
const NAMED: usize = 3;
/// Words of a row that gives the friction at rest.
const AT_REST: [&str; 8] =
    ["static", "rest", "at rest", "breakaway", "stiction", "mu_s", "haften", "static friction"];

/// A row as written: a reading whose speed has its sign.
type Row = MeasuredReading;

pub(super) fn read(name: &str, bytes: &[u8], how: How) -> Result<Measured, Refused> {
    let How { machine, kind, direction, chosen } = how;
    let (decoded, encoding) = text::decode(bytes)?;
    let Fields { lines, first, decimal, comments, said: form } = text::fields(&decoded)?;
    let (header, numeric, start) = layout(&lines, first, &comments, decimal)?;
    let columns = columns::find(header.as_ref(), &numeric, machine, &chosen)?;
    let mut said: Vec<String> =
        encoding.into_iter().chain(form).chain(columns.said.iter().cloned()).collect();
    let Numbers { mut rows, times, left_out } = numbers(&lines, start, &columns, decimal)?;
    let error_of_speed = differentiate(&mut rows, &times, &columns, &mut said)?;
    let backward_steps = times.windows(2).filter(|pair| pair[1] < pair[0]).count();
    let in_time = backward_steps as f64 <= BACK_IN_TIME * times.len() as f64;
    if !left_out.is_empty() {
        let which: Vec<String> = left_out.iter().take(NAMED).map(usize::to_string).collect();
        let more = if left_out.len() > NAMED { ", .." } else { "" };
        let (rows, lines) = if left_out.len() == 1 { ("row", "line") } else { ("rows", "lines") };
        said.push(format!(
            "{} {rows} without numbers left out ({lines} {}{more})",
            left_out.len(),
            which.join(", ")
        ));
    }
    if machine.is_some() && columns.forces.is_none() && rows.iter().any(|row| row.friction > HIGHEST_FRICTION)
    {
        said.push("friction has no unit and is read as a coefficient".into());
    }
    let is_record = match kind {
        Some(kind) => kind == RowKind::Record,
        None => is_record(&rows, columns.time.is_some(), in_time),
    };
    if columns.time.is_some() && !is_record && kind.is_none() && rows.len() >= FEWEST_IN_RECORD {
        said.push("rows taken as independent readings, not as a record over time: their speeds jump".into());
    }
    if is_record {
        number_visits(&mut rows);
    }
    let (folded, noise) = fold(rows, direction, is_record, &mut said)?;
    let (at_rest, mut in_slip) = part(folded, is_record, noise, &mut said)?;
    if in_slip.windows(2).any(|rows| rows[0].speed > rows[1].speed) {
        if !is_record {
            said.push("rows sorted by slip speed".into());
        }
        // Rows of one speed stay in their order.
        in_slip.sort_by(|one, other| one.speed.total_cmp(&other.speed));
    }
    Ok(Measured {
        name: name.to_owned(),
        at_rest,
        in_slip,
        has_errors: columns.error.is_some(),
        is_record,
        is_law: machine.is_none() || kind == Some(RowKind::Rows),
        error_of_speed,
        forces: columns.forces,
        normal_force: None,
        motion: columns.motion,
        said,
    })
}

/// Speeds in place of positions; returns their standard error.
fn differentiate(
    rows: &mut Vec<Row>,
    times: &[f64],
    columns: &Columns,
    said: &mut Vec<String>,
) -> Result<f64, Refused> {
    let Some(position) = &columns.position else { return Ok(0.0) };
    let Some((found, width, error)) =
        slopes::speeds(std::mem::take(rows), times).filter(|of| of.0.len() >= 3)
    else {
        return Err(Refused::whole(
            &format!("speeds do not follow from `{position}`: too few rows are in order of time"),
            "give ten rows at least, by increasing time, or slip speeds in place of positions",
        ));
    };
    *rows = found;
    let unit = columns.motion.unit(slipmap_machine::Dimension::Velocity);
    said.push(format!(
        "speeds are slopes of `{position}` over {width} rows, with an error of {} {unit}",
        rounded(error, 2)
    ));
    Ok(error)
}

/// The header, the columns that hold numbers, and the position of the row with which the data start.
fn layout(
    lines: &[Line],
    first: usize,
    comments: &[Vec<Line>],
    decimal: Decimal,
) -> Result<(Option<Header>, Vec<usize>, usize), Refused> {
    let is_number = |field: &String| text::number(field, decimal).is_some_and(f64::is_finite);
    let rows = &lines[first..];
    let width = rows.iter().map(|line| line.fields.len()).max().unwrap_or(0);
    // A column of numbers has them in more than half of the rows, but for a standard error, which may lack some.
    let numeric = |column: usize| {
        let filled =
            rows.iter().filter_map(|line| line.fields.get(column)).filter(|field| !text::is_missing(field));
        let (count, numbers) =
            filled.fold((0, 0), |(count, of), field| (count + 1, of + usize::from(is_number(field))));
        2 * numbers > count
    };
    let numeric: Vec<usize> = (0..width).filter(|&column| numeric(column)).collect();
    // A row such as `static;0.42` may be above the data, and the units may be in a line of their own.
    let above = lines[..first].iter().filter(|line| line.fields.len() >= 2 && !is_rest(&line.fields[0]));
    let mut above: Vec<&Line> = above.filter(|line| !line.fields.iter().any(is_number)).collect();
    let are_names = |line: &&Line| columns::are_names(&line.fields);
    if !above.iter().any(are_names) {
        // Some programs write the header as comments.
        let of_rows = |line: &&Line| line.fields.len() == width && line.number < rows[0].number;
        above.extend(comments.iter().filter_map(|divided| divided.iter().find(of_rows)));
    }
    let joined = |names: &Line, units: &Line| {
        let unit = |i: usize| units.fields.get(i).map_or("", |unit| unit.trim_matches(['[', ']', '(', ')']));
        let names = names.fields.iter().enumerate();
        names
            .map(|(i, name)| match unit(i) {
                "" => name.clone(),
                unit => format!("{name} [{unit}]"),
            })
            .collect()
    };
    // The last line that names both, with the line of the units below it, beyond other lines that programs write; else the
    // last line.
    let named = above.iter().rposition(are_names);
    let units = |names: usize| above[names + 1..].iter().find(|units| are_units(above[names], units));
    let header = match (named, above.as_slice()) {
        (Some(at), _) => {
            let names = above[at];
            Some((names.number, units(at).map_or_else(|| names.fields.clone(), |units| joined(names, units))))
        }
        (None, [.., names, units]) if are_units(names, units) => Some((names.number, joined(names, units))),
        (None, [.., names]) => Some((names.number, names.fields.clone())),
        (None, []) => None,
    };
    // A comma in a number makes two cells of it.
    if let Some(named) =
        header.as_ref().and_then(|(_, names)| names.iter().rposition(|name| !name.is_empty()))
        && let Some(&beyond) = numeric.iter().find(|&&column| column > named)
        && let Some(line) = rows.iter().find(|line| line.fields.get(beyond).is_some_and(is_number))
    {
        return Err(Refused {
            line: Some(line.number),
            problem: format!("a number in column {}, and the header names {} columns", beyond + 1, named + 1),
            remedy: "if these are decimal commas, separate the columns by semicolons; if they separate thousands, leave \
                     them out; else name every column"
                .into(),
        });
    }
    // A row below the header that has a number, and no word in its first column, is no title.
    let begins = |line: &Line| {
        let field = numeric.first().and_then(|column| line.fields.get(*column));
        field.is_some_and(|field| is_number(field) || text::is_missing(field))
    };
    let below_header = |line: &Line| {
        header.as_ref().is_some_and(|(names, _)| line.number > *names)
            && begins(line)
            && line.fields.iter().any(is_number)
    };
    let is_row = |line: &Line| is_rest(&line.fields[0]) || below_header(line);
    let start = lines[..first].iter().position(is_row).unwrap_or(first);
    Ok((header, numeric, start))
}

/// Whether a line below the names holds their units: all are known, or of columns that are named most are.
fn are_units(names: &Line, line: &Line) -> bool {
    use super::super::units::{Match, compare};
    let units = line.fields.iter().map(|field| field.trim_matches(['[', ']', '(', ')']));
    let units: Vec<&str> = units.filter(|unit| !unit.is_empty()).collect();
    if names.fields.len() != line.fields.len() || units.is_empty() {
        return false;
    }
    let known = units.iter().filter(|unit| !matches!(compare(unit, ""), Match::Unknown)).count();
    known == units.len() || 2 * known > units.len() && columns::are_names(&names.fields)
}

/// Whether the first field of a row says that it gives the friction at rest.
fn is_rest(field: &str) -> bool {
    AT_REST.contains(&field.trim().to_lowercase().as_str())
}

/// The rows as numbers.
struct Numbers {
    rows: Vec<Row>,
    /// Their times; none where there is no such column.
    times: Vec<f64>,
    /// The lines of those without numbers.
    left_out: Vec<usize>,
}

/// The rows from the `first` on as numbers.
fn numbers(lines: &[Line], first: usize, columns: &Columns, decimal: Decimal) -> Result<Numbers, Refused> {
    let (mut rows, mut left_out, mut times) = (Vec::new(), Vec::new(), Vec::new());
    let [of_speed, of_friction] = columns.factors;
    let last = lines.last().map_or(0, |line| line.number);
    let (above, lines) = lines.split_at(first);
    for line in lines {
        let field = |column: usize| line.fields.get(column).map_or("", String::as_str);
        let value = |column: usize| text::number(field(column), decimal).filter(|value| !value.is_nan());
        let refuse = |problem: String, remedy: &str| {
            Err(Refused { line: Some(line.number), problem, remedy: remedy.to_owned() })
        };
        let rest = line.fields.iter().any(|field| is_rest(field));
        let speed = if rest { Some(0.0) } else { value(columns.speed) };
        // The friction of a row `static;0.42` follows the word, wherever the columns are.
        let after = || line.fields.iter().find_map(|field| text::number(field, decimal));
        let friction = value(columns.friction).or_else(|| if rest { after() } else { None });
        let (Some(speed), Some(friction)) = (speed, friction) else {
            let is_missing = |column: usize| text::is_missing(field(column));
            // Files that were joined repeat their header, and some programs end with a word.
            let is_repeated = || above.iter().any(|above| above.fields == line.fields);
            let is_end = line.number == last
                && !line.fields.iter().any(|field| text::number(field, decimal).is_some());
            if is_missing(columns.speed) || is_missing(columns.friction) || is_repeated() || is_end {
                left_out.push(line.number);
                continue;
            }
            let row = line.fields.join(",");
            return refuse(
                format!("`{row}` is not a pair of numbers"),
                "write slip speed and friction, or take it out",
            );
        };
        if !(speed.is_finite() && friction.is_finite()) {
            return refuse("a datum is not finite".into(), "correct or remove this row");
        }
        // That a rig presses backward is a matter of its signs.
        let load = match columns.normal.map(|column| value(column).filter(|load| *load != 0.0)) {
            None => 1.0,
            Some(Some(load)) => 1.0 / load.abs(),
            Some(None) => {
                left_out.push(line.number);
                continue;
            }
        };
        let error = match columns.error {
            None => f64::NAN,
            Some(column) => match value(column) {
                Some(error) if error >= 0.0 && error.is_finite() => error * of_friction,
                Some(error) => {
                    return refuse(
                        format!("the standard error {error} is not a valid error bar"),
                        "write a finite number that is at least 0, in the units of the friction",
                    );
                }
                None => {
                    return refuse(
                        "this row has no standard error, and others have".into(),
                        "give one in every row, in the units of the friction, or none",
                    );
                }
            },
        };
        if let Some((column, unit)) = columns.time {
            times.extend(value(column).map(|time| time * unit));
        }
        let (speed, friction, error) = (speed * of_speed, friction * load * of_friction, error * load);
        rows.push(Row { speed, friction, error, line: line.number, visit: 0, backward: speed < 0.0 });
    }
    if rows.len() < 3 {
        let problem = match rows.len() {
            1 => "there is only one row of data".to_owned(),
            count => format!("there are only {count} rows of data"),
        };
        return Err(Refused::whole(&problem, "give at least three"));
    }
    if columns.position.is_some() && times.len() < rows.len() {
        return Err(Refused::whole("some rows have no time", "give the time of every row, or slip speeds"));
    }
    Ok(Numbers { rows, times, left_out })
}

/// Whether rows are a record over time: many, in order of time, whose speed changes little from one to the next. Without
/// times it goes up and down, since rows that are sorted by speed are none.
fn is_record(rows: &[Row], has_times: bool, in_time: bool) -> bool {
    let count = rows.len() as f64;
    let steps = rows.windows(2).map(|pair| (pair[1].speed - pair[0].speed).abs());
    let step = steps.sum::<f64>() / (count - 1.0);
    // The mean difference of two rows without order.
    let mut speeds: Vec<f64> = rows.iter().map(|row| row.speed).collect();
    speeds.sort_by(f64::total_cmp);
    let weights = (0..rows.len()).map(|i| 2.0 * i as f64 - (count - 1.0));
    let without_order = speeds.iter().zip(weights).map(|(speed, weight)| speed * weight).sum::<f64>() * 2.0
        / (count * (count - 1.0));
    rows.len() >= FEWEST_IN_RECORD
        && step <= LARGEST_STEP * without_order
        && if has_times { in_time } else { turns(&mut rows.to_vec()) >= TURNS }
}

/// Numbers the sweeps of the speed up and down; returns the number of turns.
fn turns(rows: &mut [Row]) -> usize {
    let largest = rows.iter().map(|row| row.speed.abs()).fold(0.0, f64::max);
    let (mut turns, mut rises, mut extreme) = (0, true, 0.0);
    for row in rows {
        let speed = row.speed.abs();
        let further = if rises { speed - extreme } else { extreme - speed };
        if further > 0.0 {
            extreme = speed;
        } else if -further > OF_A_TURN * largest {
            (turns, rises, extreme) = (turns + 1, !rises, speed);
        }
        row.visit = turns;
    }
    turns
}

/// Numbers the visits of a record: the steps of a staircase, or else the sweeps up and down.
fn number_visits(rows: &mut [Row]) {
    let mut steps: Vec<f64> = rows.windows(2).map(|pair| (pair[1].speed - pair[0].speed).abs()).collect();
    let limit = |steps: &mut Vec<f64>| {
        let middle = steps.len() / 2;
        OF_A_STAIR * *steps.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let limit = if steps.is_empty() { 0.0 } else { limit(&mut steps) };
    let mut stairs = 0;
    let mut visits = vec![0];
    for pair in rows.windows(2) {
        stairs += usize::from((pair[1].speed - pair[0].speed).abs() > limit);
        visits.push(stairs);
    }
    if stairs > 0 && (stairs + 1) * ROWS_OF_A_STAIR <= rows.len() {
        rows.iter_mut().zip(visits).for_each(|(row, visit)| row.visit = visit);
    } else {
        turns(rows);
    }
}

/// Friction against slip in the directions that are taken, and the largest speed that is noise about rest.
fn fold(
    rows: Vec<Row>,
    direction: Direction,
    is_record: bool,
    said: &mut Vec<String>,
) -> Result<(Vec<Row>, f64), Refused> {
    let largest = rows.iter().map(|row| row.speed.abs()).fold(0.0, f64::max);
    let slowest = rows.iter().map(|row| -row.speed).fold(0.0, f64::max);
    let forward: Vec<&Row> = rows.iter().filter(|row| row.speed > 0.0).collect();
    let backward: Vec<&Row> = rows.iter().filter(|row| row.speed < 0.0).collect();
    let lacks = match direction {
        Direction::Mean => false,
        Direction::Forward => forward.is_empty(),
        Direction::Backward => backward.is_empty(),
    };
    if lacks {
        return Err(Refused::whole("no row has this direction of slip", "take the other direction, or both"));
    }
    if backward.is_empty() {
        return Ok((rows, 0.0));
    }
    let negative = |rows: &[&Row]| rows.iter().filter(|row| row.friction < 0.0).count();
    let mostly = |rows: &[&Row]| 2 * negative(rows) > rows.len();
    if !forward.is_empty() && slowest <= NOISE * largest && mostly(&forward) == mostly(&backward) {
        let at_rest = |row: Row| Row { speed: row.speed.max(0.0), backward: false, ..row };
        said.push(format!("speeds down to -{} taken as noise about rest", rounded(slowest, 3)));
        return Ok((rows.into_iter().map(at_rest).collect(), slowest));
    }
    // Friction against slip is positive; a coefficient may be written without a direction.
    let sign = |mostly_negative: bool| if mostly_negative { -1.0 } else { 1.0 };
    let signs = [sign(mostly(&forward)), sign(mostly(&backward))];
    let both = match direction {
        Direction::Forward => "forward slip alone",
        Direction::Backward => "backward slip alone",
        Direction::Mean => "the mean of both directions of slip",
    };
    said.push(match (forward.is_empty(), backward_over_forward(forward, &backward)) {
        (true, _) => "slip is negative in all rows: taken as the direction of slip".into(),
        (false, None) => format!("{both}: they have no slip speeds in common"),
        (false, Some(ratio)) => {
            format!("{both}: backward friction is on average {} % of that forward", rounded(100.0 * ratio, 3))
        }
    });
    let mut folded = Vec::new();
    // At rest the sign may be that of either direction, in a record the same in all of a phase.
    for phase in rows.chunk_by(|one, next| is_record && one.speed == 0.0 && next.speed == 0.0) {
        let of_phase = sign(phase.iter().map(|row| row.friction).sum::<f64>() < 0.0);
        folded.extend(phase.iter().map(|row| {
            let sign = match row.speed {
                speed if speed > 0.0 => signs[0],
                speed if speed < 0.0 => signs[1],
                _ => of_phase,
            };
            let backward = row.speed < 0.0 || row.speed == 0.0 && sign < 0.0;
            Row { speed: row.speed.abs(), friction: sign * row.friction, backward, ..*row }
        }));
    }
    // Without a sign friction at rest may be that of both directions.
    let is_taken = |row: &Row| match direction {
        _ if row.speed == 0.0 && signs[0] == signs[1] => true,
        Direction::Mean => true,
        Direction::Forward => !row.backward,
        Direction::Backward => row.backward,
    };
    folded.retain(is_taken);
    Ok((folded, 0.0))
}

/// The mean friction of backward slip over that of forward slip at the same slip speeds, between the rows of which it
/// is interpolated; `None` where they have none in common.
fn backward_over_forward(mut forward: Vec<&Row>, backward: &[&Row]) -> Option<f64> {
    forward.sort_by(|one, other| one.speed.total_cmp(&other.speed));
    let at = |speed: f64| {
        let above = forward.partition_point(|row| row.speed < speed);
        let (high, low) = (forward.get(above)?, forward.get(above.saturating_sub(1))?);
        let share = if high.speed > low.speed { (speed - low.speed) / (high.speed - low.speed) } else { 1.0 };
        let friction = low.friction.abs() + share * (high.friction.abs() - low.friction.abs());
        (low.speed <= speed).then_some(friction)
    };
    let pairs = backward.iter().filter_map(|row| Some([row.friction.abs(), at(-row.speed)?]));
    let [back, ahead] = pairs.fold([0.0; 2], |sums, pair| [sums[0] + pair[0], sums[1] + pair[1]]);
    (ahead > 0.0).then(|| back / ahead)
}

/// The readings at rest and those in slip, in the order of the file.
fn part(
    rows: Vec<Row>,
    is_record: bool,
    noise: f64,
    said: &mut Vec<String>,
) -> Result<(Vec<MeasuredReading>, Vec<MeasuredReading>), Refused> {
    if !is_record {
        return Ok(rows.into_iter().partition(|row| row.speed == 0.0));
    }
    // While it sticks the friction is what pulls; it breaks loose as the phase ends, but for one that goes on at the end of the
    // record.
    let (mut at_rest, mut in_slip): (Vec<MeasuredReading>, Vec<MeasuredReading>) = (Vec::new(), Vec::new());
    let last = rows.last().map_or(0, |row| row.line);
    for phase in rows.chunk_by(|one, next| (one.speed <= noise) == (next.speed <= noise)) {
        match phase {
            [row, ..] if row.speed > noise => in_slip.extend(phase),
            [.., row] if row.line < last => {
                let samples: Vec<f64> = phase.iter().map(|row| row.friction).collect();
                at_rest.push(MeasuredReading { speed: 0.0, friction: breakaway(&samples), ..*row });
            }
            _ => {}
        }
    }
    said.push(match at_rest.len() {
        0 => "a record over time that never rests".into(),
        1 => "a record over time: friction at rest is that at the end of its phase of rest".into(),
        phases => format!(
            "a record over time: friction at rest is the mean of that at the end of {phases} phases of rest"
        ),
    });
    if in_slip.len() < 3 {
        return Err(Refused::whole(
            "hardly any row is in slip",
            "give at least three with a slip speed above 0",
        ));
    }
    Ok((at_rest, in_slip))
}
