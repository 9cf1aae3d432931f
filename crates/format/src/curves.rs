//! The stored curves of codimension one, with the points of codimension two on them as curves of one point: the group `curves`
//! with two tables; see the format in [`super`].

use hdf5::types::TypeDescriptor;
use hdf5::{Dataset, File, Group, H5Type};

use slipmap_column::bifurcation::Bifurcation;
use slipmap_map::dataset::curves::{PLANE, POINT, columns, held};
use slipmap_map::dataset::{Value, fingerprint};
use slipmap_map::{Axis, CURVE_COLUMNS, Grid, Plane, PlaneCurve, PlaneCurves, PlanePoint};

use super::create::group_of_tables;
use super::layout::{self, Unfit};
use super::records::write_tables;
use super::value;

pub(super) const GROUP: &str = "curves";

/// Names of all columns and dimensions that the group may have.
pub(super) fn names(grid: &Grid) -> Vec<String> {
    let axes = || grid.axes().iter();
    let own = CURVE_COLUMNS.iter().map(|name| (*name).to_owned());
    own.chain(axes().map(held)).chain(axes().map(|axis| axis.name.clone())).collect()
}

/// The attribute that names the curves whose search was cut by its budget.
const INCOMPLETE: &str = "incomplete";

/// The curves of a kind in a plane, in words.
fn in_plane(kind: Bifurcation, plane: &Plane, grid: &Grid) -> String {
    let [x, y] = [plane.x, plane.y].map(|axis| grid.axes()[axis].name.as_str());
    format!("{} over {x} and {y}", kind.name())
}

/// Writes the curves of `planes`; writes nothing if there are no planes.
pub(super) fn write(file: &File, grid: &Grid, planes: &[PlaneCurves]) -> hdf5::Result<()> {
    if planes.is_empty() {
        return Ok(());
    }
    let group = group_of_tables(file, GROUP)?;
    value::write(
        &group,
        "long_name",
        &"curves of codimension one, by continuation, and points of codimension two on them".into(),
    )?;
    let cut =
        planes.iter().flat_map(|curves| curves.cut.iter().map(|kind| in_plane(*kind, &curves.plane, grid)));
    let cut: Vec<String> = cut.collect();
    if !cut.is_empty() {
        value::write(&group, INCOMPLETE, &cut.join(", ").as_str().into())?;
    }
    write_tables(&group, &columns(grid, planes))
}

/// Reads the group, if the map has one.
pub(super) fn read(file: &File, grid: &Grid) -> Result<Vec<PlaneCurves>, Unfit> {
    if !file.link_exists(GROUP) {
        return Ok(Vec::new());
    }
    let group = file.group(GROUP)?;
    let table = Rows(&group);
    let axes = grid.axes();
    let axis = |word: &str| axes.iter().position(|axis| axis.name == word);
    let (xs, ys) = (table.words("plane_x", axis)?, table.words("plane_y", axis)?);
    let mut planes = Vec::with_capacity(xs.len());
    let cut = match group.attr_names()?.iter().any(|name| name == INCOMPLETE) {
        true => value::read(&group, INCOMPLETE)?,
        false => None,
    };
    let is_cut = |kind: &Bifurcation, plane: &Plane| match &cut {
        Some(Value::Text(names)) => names.split(", ").any(|name| name == in_plane(*kind, plane, grid)),
        _ => false,
    };
    let held_at = axes.iter().map(|axis| table.numbers::<f64>(&held(axis), xs.len()));
    let held_at = held_at.collect::<Result<Vec<_>, _>>()?;
    for (number, (&x, &y)) in xs.iter().zip(&ys).enumerate() {
        let mut nodes = vec![0; axes.len()];
        for (position, values) in held_at.iter().enumerate().filter(|(axis, _)| *axis != x && *axis != y) {
            let node = axes[position].values.binary_search_by(|node| node.total_cmp(&values[number]));
            let nowhere = |_| Unfit::Foreign(format!("its curves hold {} at no node", axes[position].name));
            nodes[position] = node.map_err(nowhere)?;
        }
        if x == y {
            let why = format!("its curves lie in a plane of {} alone", axes[x].name);
            return Err(Unfit::Foreign(why));
        }
        let plane = Plane::new(x, y, nodes);
        let cut = Bifurcation::ALL.into_iter().filter(|kind| is_cut(kind, &plane)).collect();
        planes.push(PlaneCurves { plane, curves: Vec::new(), cut });
    }
    table.numbers::<f64>(PLANE, planes.len())?;
    // A table of points that has lost a column is not a group without points.
    let of_planes = |name: &str| [PLANE, "plane_x", "plane_y"].contains(&name) || name.starts_with("held_");
    if names(grid).iter().any(|name| !of_planes(name) && group.link_exists(name)) {
        read_points(&table, axes, &mut planes)?;
    }
    Ok(planes)
}

fn read_points(table: &Rows, axes: &[Axis], planes: &mut [PlaneCurves]) -> Result<(), Unfit> {
    let known = |word: &str| Bifurcation::ALL.into_iter().find(|bifurcation| bifurcation.name() == word);
    let kinds = table.words("curve", known)?;
    let number = table.numbers::<i32>("plane_number", kinds.len())?;
    table.numbers::<f64>(POINT, kinds.len())?;
    let branch = table.numbers::<i32>("branch", kinds.len())?;
    let error = table.numbers::<f64>("error", kinds.len())?;
    let values = axes.iter().map(|axis| table.numbers::<f64>(&axis.name, kinds.len()));
    let values = values.collect::<Result<Vec<_>, _>>()?;
    let mut before = None;
    for (row, bifurcation) in kinds.into_iter().enumerate() {
        let place = usize::try_from(number[row]).ok().and_then(|number| number.checked_sub(1));
        let Some(curves) = place.and_then(|place| planes.get_mut(place)) else {
            let why = format!("its curves have a point of plane {}, which is not there", number[row]);
            return Err(Unfit::Foreign(why));
        };
        let key = (number[row], bifurcation, branch[row]);
        if before.replace(key) != Some(key) {
            curves.curves.push(PlaneCurve { bifurcation, points: Vec::new() });
        }
        let point =
            PlanePoint { x: values[curves.plane.x][row], y: values[curves.plane.y][row], error: error[row] };
        if let Some(curve) = curves.curves.last_mut() {
            curve.points.push(point);
        }
    }
    Ok(())
}

/// The columns of the group.
struct Rows<'a>(&'a Group);

impl Rows<'_> {
    /// Opens a column with numbers of type `kind`.
    fn column(&self, name: &str, kind: &TypeDescriptor) -> Result<Dataset, Unfit> {
        if !self.0.link_exists(name) {
            return Err(Unfit::Foreign(format!("{GROUP}/{name} is missing")));
        }
        let dataset = self.0.dataset(name)?;
        let stored = layout::kind(&dataset)?;
        if dataset.ndim() == 1 && stored == *kind {
            return Ok(dataset);
        }
        let shape = dataset.shape();
        let why = format!(
            "{GROUP}/{name} holds {stored} in the shape {shape:?}, which no version of slipmap writes"
        );
        Err(Unfit::Foreign(why))
    }

    /// The numbers of a column, which must have `rows` rows.
    fn numbers<T: H5Type>(&self, name: &str, rows: usize) -> Result<Vec<T>, Unfit> {
        let dataset = self.column(name, &T::type_descriptor())?;
        match dataset.size() {
            found if found == rows => Ok(dataset.read_raw::<T>()?),
            found => Err(Unfit::Foreign(format!("{GROUP}/{name} has {found} rows instead of {rows}"))),
        }
    }

    /// A column of words, each as what `known` makes of it.
    fn words<T: Copy>(&self, name: &str, known: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, Unfit> {
        let dataset = self.column(name, &i8::type_descriptor())?;
        let meanings = match value::read(&dataset, "flag_meanings")? {
            Some(Value::Text(text)) => text,
            _ => String::new(),
        };
        let meanings: Vec<Option<T>> = meanings.split_whitespace().map(known).collect();
        let word = |code: &i8| {
            let word = usize::try_from(*code).ok().and_then(|code| meanings.get(code).copied().flatten());
            word.ok_or_else(|| Unfit::Foreign(format!("{GROUP}/{name} has a code without a meaning")))
        };
        dataset.read_raw::<i8>()?.iter().map(word).collect()
    }
}

/// Fingerprint of a column, for comparison with its attribute `sha256`; `None` for a type that no column has.
pub(super) fn fingerprint_of(column: &Dataset) -> hdf5::Result<Option<Value>> {
    let digest = match layout::kind(column)? {
        kind if kind == f64::type_descriptor() => fingerprint::reals(&column.read_raw()?),
        kind if kind == i32::type_descriptor() => fingerprint::integers(&column.read_raw()?),
        kind if kind == i8::type_descriptor() => fingerprint::codes(&column.read_raw()?),
        _ => return Ok(None),
    };
    Ok(Some(fingerprint::of_one_tile(&digest)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::Law;

    #[test]
    fn cut_curves_and_points_of_codimension_two_are_named() {
        let axes = vec![vec![0.1], vec![0.2], vec![0.1], vec![1.0, 2.0], vec![1.0], vec![0.0, 1.0]];
        let grid = Grid::new(Law::Stribeck, axes).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = File::create(folder.path().join("map.h5")).unwrap();
        let plane = Plane::new(3, 5, vec![0; 6]);
        let at = |x: f64| PlanePoint { x, y: 0.5, error: 1e-9 };
        let of = |bifurcation, points: &[PlanePoint]| PlaneCurve { bifurcation, points: points.to_vec() };
        let curves = vec![
            of(Bifurcation::Hopf, &[at(1.0), at(1.5)]),
            of(Bifurcation::Bautin, &[at(1.1)]),
            of(Bifurcation::Bautin, &[at(1.4)]),
        ];
        let planes = [PlaneCurves { plane, curves, cut: vec![Bifurcation::Fold] }];
        write(&file, &grid, &planes).unwrap();
        let told = value::read(&file.group(GROUP).unwrap(), "incomplete").unwrap();
        assert_eq!(told, Some("fold over gamma and c".into()));
        assert_eq!(read(&file, &grid).unwrap(), planes);
        for column in ["plane", "plane_x", "held_V"] {
            let column = file.group(GROUP).unwrap().dataset(column).unwrap();
            let stored = value::read(&column, "sha256").unwrap();
            assert!(stored.is_some() && fingerprint_of(&column).unwrap() == stored);
        }
    }
}
