//! The map file: data are read back as written, no unfinished file appears, and all damage is found.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use slipmap::column::{Method, Regime, Verdict};
use slipmap::files::Existing;
use slipmap::friction::{Law, Table};
use slipmap::map::{Account, Field, Grid, MethodCells, Plan, Runs, Sink, Tile, TileData};
use slipmap::store::Pick::{Every, Node};
use slipmap::store::{CheckReport, MapFile, Outcome, PartialMap, Provenance, StoreError, Value, check};
use slipmap_model::friction::Source;
use tempfile::TempDir;

/// Axes with lengths that no tile size divides, and axes of one point.
fn grid(lengths: [usize; 6]) -> Grid {
    let nodes = lengths.iter().zip([0.01, 0.1, 0.2, 0.3, 0.4, 0.5]);
    let nodes = nodes.map(|(&len, start)| (0..len).map(|i| start + 0.01 * i as f64).collect());
    Grid::new(Law::Stribeck, nodes.collect()).unwrap()
}

fn plan(lengths: [usize; 6], target_cells: usize, fields: &[Field]) -> Plan {
    let grid = grid(lengths);
    let tile_shape = grid.tile_shape(target_cells);
    Plan::builder(grid)
        .methods(Method::all())
        .fields(fields.iter().copied())
        .audit_cells(0)
        .proof_boxes(0)
        .tile_shape(tile_shape)
        .build()
        .unwrap()
}

fn provenance() -> Provenance {
    Provenance {
        title: "A map of nothing, für tests".into(),
        config_path: "nothing.toml".into(),
        config_text: "title = \"nothing\"\n".into(),
        command_line: "slipmap run nothing.toml".into(),
        git: "a commit".into(),
        threads: 1,
    }
}

fn outcome() -> Outcome {
    let attributes = [
        ("threads", Value::from(3)),
        ("wall_seconds", 1.5.into()),
        ("seconds_simulation", 0.25.into()),
        ("audit_disagreements", 1.into()),
        ("note", "from the test".into()),
    ];
    let attributes = attributes.map(|(name, value)| (name.to_owned(), value));
    Outcome { attributes: attributes.into(), ..Outcome::default() }
}

/// Number of a cell, or of a column, in the whole grid: the source of the synthetic contents.
fn number(index: &[usize], shape: &[usize]) -> usize {
    index.iter().zip(shape).fold(0, |number, (&i, &len)| number * len + i)
}

fn verdict(method: usize, cell: usize) -> i8 {
    [-1, 0, 1, 2][(cell / 3 + method) % 4]
}

fn regime(cell: usize) -> i8 {
    (cell / 5 % 6) as i8
}

/// The value with this code.
fn of_code<T: Copy, const N: usize>(all: [T; N], code_of: fn(T) -> i8, code: i8) -> T {
    all.into_iter().find(|value| code_of(*value) == code).unwrap()
}

fn real(variable: usize, cell: usize) -> f64 {
    if cell % 7 == variable % 7 { f64::NAN } else { (cell as f64 + 0.1) / (variable as f64 + 3.0) }
}

/// Every index in a box, row-major.
fn indices(ranges: &[Range<usize>]) -> Vec<Vec<usize>> {
    ranges.iter().fold(vec![vec![]], |all, range| {
        all.into_iter()
            .flat_map(|index: Vec<usize>| {
                range.clone().map(move |i| index.iter().copied().chain([i]).collect())
            })
            .collect()
    })
}

fn tile_data(plan: &Plan, tile: Tile) -> TileData {
    let shape = plan.grid.shape();
    let outer = shape.len() - 1;
    let cells: Vec<usize> = indices(&tile.ranges).iter().map(|index| number(index, &shape)).collect();
    let columns: Vec<usize> =
        indices(&tile.ranges[..outer]).iter().map(|index| number(index, &shape[..outer])).collect();
    let reals = |field, variable, of: &[usize]| -> Vec<f64> {
        if plan.stores(field) { of.iter().map(|&i| real(variable, i)).collect() } else { Vec::new() }
    };
    TileData {
        methods: plan
            .methods
            .iter()
            .enumerate()
            .map(|(m, &method)| MethodCells {
                method,
                verdicts: cells
                    .iter()
                    .map(|&cell| of_code(Verdict::ALL, Verdict::code, verdict(m, cell)))
                    .collect(),
                margins: reals(Field::Margin, m, &cells),
                critical: reals(Field::CriticalC, m, &columns),
                critical_errors: match method {
                    Method::Simulation => reals(Field::CriticalC, 10 + m, &columns),
                    _ => Vec::new(),
                },
            })
            .collect(),
        regime: if plan.stores(Field::Regime) {
            cells.iter().map(|&cell| of_code(Regime::ALL, Regime::code, regime(cell))).collect()
        } else {
            Runs::new()
        },
        quantities: (20..)
            .zip(plan.quantities())
            .map(|(number, _)| cells.iter().map(|&cell| real(number, cell)).collect())
            .collect(),
        tile,
    }
}

/// Writes the given tiles in the given order.
fn write_tiles(writer: &PartialMap, plan: &Plan, tiles: impl IntoIterator<Item = usize>) {
    for number in tiles {
        let data = tile_data(plan, plan.grid.tile(&plan.tile_shape, number));
        writer.write(writer.pack(&data).unwrap(), &Account::none(plan)).unwrap();
    }
}

fn tiles(plan: &Plan) -> Range<usize> {
    0..plan.tile_count()
}

fn begin(path: &Path, plan: &Plan) -> PartialMap {
    PartialMap::begin(path, plan, &provenance(), Existing::Refuse).unwrap()
}

fn write_map(path: &Path, plan: &Plan) {
    let writer = begin(path, plan);
    write_tiles(&writer, plan, tiles(plan));
    writer.finish(&outcome()).unwrap();
}

/// A small map with every field, in a folder of its own.
fn small_map() -> (TempDir, PathBuf, Plan) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("map.h5");
    let plan = plan([2, 1, 3, 1, 5, 4], 15, &Field::ALL);
    write_map(&path, &plan);
    (folder, path, plan)
}

fn files(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    // Those of journals without their random letters.
    let known = |name: &str| name.find(".part.").map_or(name.len(), |at| at + ".part".len());
    let mut names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    names.iter_mut().for_each(|name| name.truncate(known(name)));
    names.sort();
    names
}

fn same(a: f64, b: f64) -> bool {
    a == b || (a.is_nan() && b.is_nan())
}

#[track_caller]
fn assert_sound(path: &Path) -> CheckReport {
    let report = check(path, &|_| {}).unwrap();
    assert!(report.is_sound(), "{:#?}", report.problems);
    report
}

#[track_caller]
fn problems(path: &Path) -> Vec<String> {
    let report = check(path, &|_| {}).unwrap();
    assert!(!report.is_sound(), "the damage was not found");
    report.problems.iter().map(ToString::to_string).collect()
}

#[test]
fn data_are_read_as_written() {
    // Tiles of odd sizes, one-point axes, one cell in all, one tile for all, split columns.
    let cases = [
        ([2, 1, 3, 1, 5, 4], 15),
        ([1, 1, 1, 1, 1, 1], 100),
        ([3, 2, 2, 1, 3, 7], 100_000),
        ([2, 1, 2, 2, 1, 11], 4),
        ([1, 5, 1, 7, 3, 1], 6),
    ];
    for (lengths, target) in cases {
        for compression in [0, 1, 9] {
            let folder = TempDir::new().unwrap();
            let path = folder.path().join("map.h5");
            let plan = Plan { compression, ..plan(lengths, target, &Field::ALL) };
            write_map(&path, &plan);
            assert_eq!(assert_sound(&path).tiles, tiles(&plan).len());

            let map = MapFile::open(&path).unwrap();
            assert_eq!(map.grid(), &plan.grid);
            assert_eq!(map.tile_shape(), &plan.tile_shape);
            let all: Vec<Range<usize>> = lengths.iter().map(|&len| 0..len).collect();
            let cells = plan.grid.cells();
            for (m, method) in plan.methods.iter().enumerate() {
                let name = method.name();
                assert_eq!(map.methods()[m].name(), method.name());
                let verdicts = map.codes(&format!("verdict_{name}"), &all).unwrap();
                assert_eq!(verdicts.shape(), lengths);
                assert!(verdicts.iter().copied().eq((0..cells).map(|cell| verdict(m, cell))));
                let counts = map.counts(&format!("verdict_{name}")).unwrap();
                for (verdict, count) in Verdict::ALL.iter().zip(counts) {
                    let found = verdicts.iter().filter(|&&code| code == verdict.code()).count();
                    assert_eq!(found as u64, count);
                }
                let margins = map.reals(&format!("margin_{name}"), &all).unwrap();
                assert!(margins.iter().enumerate().all(|(cell, &value)| same(value, real(m, cell))));
                let critical = map.reals(&format!("critical_c_{name}"), &all[..5]).unwrap();
                assert_eq!(critical.shape(), &lengths[..5]);
                assert!(critical.iter().enumerate().all(|(column, &value)| same(value, real(m, column))));
                let errors = format!("critical_c_error_{name}");
                let errors = map.reals(&errors, &all[..5]);
                assert_eq!(errors.is_ok(), *method == Method::Simulation);
                if let Ok(errors) = errors {
                    assert!(
                        errors.iter().enumerate().all(|(column, &value)| same(value, real(10 + m, column)))
                    );
                }
            }
            let regimes = map.codes("regime", &all).unwrap();
            assert!(regimes.iter().copied().eq((0..cells).map(regime)));
            for (variable, name) in [(20, "landing_x1"), (21, "stick_time"), (22, "slip_time")] {
                let values = map.reals(name, &all).unwrap();
                assert!(values.iter().enumerate().all(|(cell, &value)| same(value, real(variable, cell))));
            }
        }
    }
}

#[test]
fn a_map_describes_itself() {
    let (_folder, path, plan) = small_map();
    let map = MapFile::open(&path).unwrap();
    assert_eq!(map.text("Conventions"), Some("CF-1.11"));
    assert_eq!(map.text("title"), Some("A map of nothing, für tests"));
    assert_eq!(map.text("config"), Some("title = \"nothing\"\n"));
    assert_eq!(map.text("law"), Some("stribeck"));
    assert_eq!(map.text("note"), Some("from the test"));
    assert!(map.text("history").unwrap().ends_with(": slipmap run nothing.toml"));
    assert_eq!(map.number("tolerance"), Some(1e-9));
    assert_eq!(map.number("threads"), Some(3.0));
    assert_eq!(map.number("seconds_simulation"), Some(0.25));
    assert_eq!(map.number("audit_disagreements"), Some(1.0));
    assert_eq!(map.fields(), &plan.fields);
    assert_eq!(map.attributes()["complete"], Value::Integers(vec![1]));
    // The output of `printf 'title = "nothing"\n' | sha256sum`.
    assert_eq!(
        map.text("config_sha256"),
        Some("cfd6cb16d3eeca57f19afc464cf20ba0bd01c239949c018fa0e919f0e26d3a0b")
    );
}

#[test]
fn slices_drop_the_axes_that_are_held() {
    let (_folder, path, plan) = small_map();
    let map = MapFile::open(&path).unwrap();
    let shape = plan.grid.shape();
    let slice = map
        .code_slice("verdict_simulation", &[Node(1), Node(0), Every(1), Node(0), Every(1), Node(2)])
        .unwrap();
    assert_eq!(slice.shape(), [3, 5]);
    let simulation = plan.methods.iter().position(|method| method.name() == "simulation").unwrap();
    for beta in 0..3 {
        for v in 0..5 {
            let cell = number(&[1, 0, beta, 0, v, 2], &shape);
            assert_eq!(slice[[beta, v]], verdict(simulation, cell));
        }
    }
    let line =
        map.real_slice("critical_c_simulation", &[Node(0), Node(0), Node(2), Node(0), Every(1)]).unwrap();
    assert_eq!(line.shape(), [5]);

    let outside =
        map.code_slice("regime", &[Node(2), Every(1), Every(1), Every(1), Every(1), Every(1)]).unwrap_err();
    assert!(outside.to_string().contains("Index 2 out of bounds for axis 0"), "{outside}");
    let short = map.codes("regime", &[0..1, 0..1]).unwrap_err();
    assert!(short.to_string().starts_with("cannot read regime in "), "{short}");
    let unknown = map.codes("verdict_of_the_jury", &[]).unwrap_err();
    assert!(unknown.to_string().contains("it has verdict_"), "{unknown}");
}

/// Measured friction without a row at rest, of many readings, with a drop.
#[test]
fn a_law_is_read_as_written() {
    let (folder, data) = (TempDir::new().unwrap(), [(0.0, 0.42), (0.1, 0.4), (0.2, 0.38), (0.5, 0.3)]);
    let source = Source {
        lines: vec![0, 2, 3, 7],
        readings: 300,
        told: Some("rig.csv: \"both\"\ndirections".into()),
        forces: true,
        no_rest: true,
        named_errors: true,
    };
    let table = Table::new("rig.csv", &data, 0.42).unwrap().with_standard_errors(&[0.01; 4]).unwrap();
    let known = table.with_error_of_curve().with_source(source);
    for (i, law) in
        [Law::Table(table), Law::Table(known.clone()), Law::Table(known).with_drop().read_as_small()]
            .into_iter()
            .enumerate()
    {
        let nodes = law.axis_names().iter().map(|_| vec![0.5]).collect();
        let plan =
            Plan::builder(Grid::new(law, nodes).unwrap()).audit_cells(0).proof_boxes(0).build().unwrap();
        let path = folder.path().join(format!("{i}.h5"));
        write_map(&path, &plan);
        assert_eq!(MapFile::open(&path).unwrap().grid().law(), plan.grid.law());
    }
}

#[test]
fn the_order_of_tiles_leaves_no_trace() {
    let folder = TempDir::new().unwrap();
    let plan = plan([2, 1, 3, 1, 5, 4], 15, &Field::ALL);
    let forwards = folder.path().join("forwards.h5");
    write_map(&forwards, &plan);
    let backwards = folder.path().join("backwards.h5");
    let writer = begin(&backwards, &plan);
    // Packed by several threads at once, as the engine does.
    std::thread::scope(|scope| {
        for half in 0..2 {
            let (writer, plan) = (&writer, &plan);
            scope.spawn(move || {
                for tile in tiles(plan).rev().filter(|tile| tile % 2 == half) {
                    writer.pack(&tile_data(plan, plan.grid.tile(&plan.tile_shape, tile))).unwrap();
                }
            });
        }
    });
    write_tiles(&writer, &plan, tiles(&plan).rev());
    writer.finish(&outcome()).unwrap();

    let fingerprint = |path: &Path, name: &str| {
        let file = hdf5::File::open(path).unwrap();
        let dataset = file.dataset(name).unwrap();
        // The order of compressed chunks in the file may differ, but not their contents.
        (dataset.storage_size(), read_text(&dataset, "sha256"))
    };
    for name in MapFile::open(&forwards).unwrap().variables() {
        assert_eq!(fingerprint(&forwards, name), fingerprint(&backwards, name), "{name}");
    }
}

/// A text of fixed length, 64 digits long.
fn read_text(place: &hdf5::Location, name: &str) -> String {
    place.attr(name).unwrap().read_scalar::<hdf5::types::FixedUnicode<64>>().unwrap().to_string()
}

#[test]
fn a_configuration_of_any_length_fits() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("map.h5");
    let plan = plan([1, 1, 1, 1, 2, 2], 100, &[Field::Verdict]);
    // HDF5 keeps attributes of up to 64 KiB in an object's header and must put longer ones elsewhere.
    let long = "# µ\n".repeat(100_000);
    let provenance = Provenance { config_text: long.clone(), ..provenance() };
    let writer = PartialMap::begin(&path, &plan, &provenance, Existing::Refuse).unwrap();
    write_tiles(&writer, &plan, tiles(&plan));
    writer.finish(&outcome()).unwrap();
    assert_sound(&path);
    assert_eq!(MapFile::open(&path).unwrap().text("config"), Some(long.as_str()));
}

#[test]
fn nothing_half_done_appears() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("map.h5");
    let plan = plan([2, 1, 3, 1, 5, 4], 15, &[Field::Verdict, Field::CriticalC]);
    let start = || PartialMap::begin(&path, &plan, &provenance(), Existing::Replace).unwrap();

    drop(start());
    assert_eq!(files(folder.path()), Vec::<String>::new());

    let writer = start();
    write_tiles(&writer, &plan, tiles(&plan));
    drop(writer);
    assert_eq!(files(folder.path()), ["map.h5.part"], "the journal holds what was computed");

    let writer = start();
    write_tiles(&writer, &plan, tiles(&plan).filter(|tile| ![1, 3].contains(tile)));
    let error = writer.finish(&outcome()).unwrap_err();
    assert!(matches!(error, StoreError::Incomplete { missing: 2, first: 1, .. }), "{error}");
    assert_eq!(files(folder.path()), ["map.h5.part"]);
}

#[test]
fn a_finished_map_is_kept_when_its_name_was_taken_meanwhile() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("map.h5");
    let plan = plan([1, 1, 1, 1, 5, 4], 100, &[Field::Verdict]);
    let writer = begin(&path, &plan);
    write_tiles(&writer, &plan, tiles(&plan));
    fs::write(&path, "somebody else's").unwrap();
    match writer.finish(&outcome()).unwrap_err() {
        StoreError::Overtaken { kept, .. } => assert_sound(&kept),
        error => panic!("{error}"),
    };
    assert_eq!(fs::read_to_string(&path).unwrap(), "somebody else's");
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = TempDir::new().unwrap();
    let plan = plan([1, 1, 1, 1, 5, 4], 100, &[Field::Verdict]);
    let create =
        |path: PathBuf| PartialMap::begin(&path, &plan, &provenance(), Existing::Refuse).unwrap_err();
    let error = create(folder.path().join("absent").join("map.h5"));
    assert!(matches!(error, StoreError::NoFolder { .. }) && error.to_string().contains("absent"), "{error}");
    fs::write(folder.path().join("file"), "").unwrap();
    let error = create(folder.path().join("file").join("map.h5"));
    assert!(matches!(error, StoreError::NoFolder { .. }), "{error}");
}

#[test]
fn a_flipped_byte_inside_a_chunk_is_located() {
    let (_folder, path, _) = small_map();
    let name = "verdict_simulation";
    let chunk = {
        let file = hdf5::File::open(&path).unwrap();
        let dataset = file.dataset(name).unwrap();
        (0..dataset.num_chunks().unwrap()).map(|i| dataset.chunk_info(i).unwrap()).nth(1).unwrap()
    };
    let mut bytes = fs::read(&path).unwrap();
    // Past the two bytes of the zlib header, within the deflate stream or its checksum.
    bytes[(chunk.addr + chunk.size / 2) as usize] ^= 0x10;
    fs::write(&path, &bytes).unwrap();
    // A place reads "tile [0..1, 0..1, 2..3, ...]".
    let starts = |place: &str| -> Vec<u64> {
        let ranges = place.trim_start_matches("tile [").split(", ");
        ranges.map(|range| range.split_once("..").unwrap().0.parse().unwrap()).collect()
    };
    let report = check(&path, &|_| {}).unwrap();
    let of_variable: Vec<_> =
        report.problems.iter().filter(|p| p.variable.as_deref() == Some(name)).collect();
    assert_eq!(of_variable.len(), 1, "{of_variable:#?}");
    assert_eq!(starts(of_variable[0].place.as_deref().unwrap()), chunk.offset);
}

/// Changes a map in a copy of it, which takes its place: a program that another test starts meanwhile inherits the
/// file that is open, and HDF5's lock with it.
fn change(path: &Path, edit: impl FnOnce(&hdf5::File)) {
    let work = path.with_extension("work");
    fs::copy(path, &work).unwrap();
    let file = hdf5::File::open_rw(&work).unwrap();
    edit(&file);
    file.close().unwrap();
    fs::remove_file(path).unwrap();
    fs::copy(&work, path).unwrap();
    fs::remove_file(&work).unwrap();
}

#[test]
fn a_changed_cell_is_found_behind_a_valid_checksum() {
    let (_folder, path, _) = small_map();
    let edit = |cell: i8| {
        change(&path, |file| {
            let dataset = file.dataset("verdict_simulation").unwrap();
            let mut cells = dataset.read_dyn::<i8>().unwrap();
            *cells.iter_mut().last().unwrap() = cell;
            dataset.write(&cells).unwrap();
        });
    };
    edit(Verdict::NotComputed.code());
    let found = problems(&path);
    assert!(found.iter().any(|problem| problem.contains("seal")), "{found:#?}");
    for sign in
        ["tile [1..2, 0..1, 2..3, 0..1, 3..5, 0..4]: 1 cells were not computed", "sha256:", "flag_counts:"]
    {
        assert!(
            found.iter().any(|problem| problem.starts_with("verdict_simulation, ") && problem.contains(sign)),
            "{sign}: {found:#?}"
        );
    }
    edit(99);
    let found = problems(&path);
    assert!(found.iter().any(|problem| problem.contains("1 cells have unknown codes")), "{found:#?}");
}

/// An entry of a dimension's list of the variables that have it.
#[derive(Clone, Copy, hdf5::H5Type)]
#[repr(C)]
struct Use {
    dataset: hdf5::ObjectReference1,
    dimension: i32,
}

#[test]
fn a_changed_attribute_or_layout_is_found() {
    type Damage = fn(&hdf5::File);
    let cases: [(&str, Damage); 7] = [
        ("verdict_simulation, attribute _FillValue", |file| {
            let dataset = file.dataset("verdict_simulation").unwrap();
            dataset.new_attr::<i8>().create("_FillValue").unwrap().write_scalar(&3i8).unwrap();
        }),
        ("regime, attribute flag_values", |file| {
            let dataset = file.dataset("regime").unwrap();
            dataset.attr("flag_values").unwrap().write(&[1_i8; Regime::ALL.len()]).unwrap();
        }),
        ("regime, attribute DIMENSION_LIST", |file| {
            let dataset = file.dataset("regime").unwrap();
            dataset.delete_attr("DIMENSION_LIST").unwrap();
        }),
        ("alpha, attribute REFERENCE_LIST", |file| {
            // Links of the right kind, but of another axis.
            let uses = |name: &str| file.dataset(name).unwrap().attr("REFERENCE_LIST").unwrap();
            let of_beta = uses("beta").read_raw::<Use>().unwrap();
            uses("alpha").write(&of_beta).unwrap();
        }),
        ("V, attribute sha256", |file| {
            file.dataset("V").unwrap().write_slice(&[0.405], 0..1).unwrap();
        }),
        ("stick_time: missing", |file| file.unlink("stick_time").unwrap()),
        ("stowaway: does not belong", |file| {
            file.new_dataset::<i8>().create("stowaway").unwrap();
        }),
    ];
    for (expected, damage) in cases {
        let (_folder, path, _) = small_map();
        change(&path, damage);
        let found = problems(&path);
        assert!(found.iter().any(|problem| problem.starts_with(expected)), "{expected}: {found:#?}");
    }
}

#[cfg(unix)]
#[test]
fn a_map_is_readable_while_a_process_of_its_writing_runs() {
    // A child process inherits the open file, and with it the lock.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.h5");
    let plan = plan([1, 1, 1, 1, 1, 2], 100, &[Field::Verdict]);
    let writer = begin(&path, &plan);
    let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
    let tile = plan.grid.tile(&plan.tile_shape, 0);
    writer.write(writer.pack(&tile_data(&plan, tile)).unwrap(), &Account::none(&plan)).unwrap();
    writer.finish(&outcome()).unwrap();
    let opened = MapFile::open(&path);
    child.kill().unwrap();
    child.wait().unwrap();
    opened.unwrap();
}

#[test]
fn regimes_and_verdicts_have_the_documented_codes() {
    // Other people's scripts rely on these numbers.
    let verdicts: Vec<(i8, &str)> = Verdict::ALL.iter().map(|v| (v.code(), v.name())).collect();
    assert_eq!(
        verdicts,
        [(-1, "absent"), (0, "undecided"), (1, "present"), (2, "failed"), (3, "not_computed")]
    );
    let regimes: Vec<(i8, &str)> = Regime::ALL.iter().map(|r| (r.code(), r.name())).collect();
    let names = "equilibrium stick_slip bistable pure_slip crossing failed pure_slip_and_stick_slip \
                 pure_slip_and_equilibrium equilibrium_pure_slip_and_stick_slip equilibrium_and_crossing \
                 pure_slip_and_crossing equilibrium_pure_slip_and_crossing stick_slip_and_crossing \
                 equilibrium_stick_slip_and_crossing pure_slip_stick_slip_and_crossing \
                 equilibrium_pure_slip_stick_slip_and_crossing neutral";
    assert_eq!(regimes, (0..).zip(names.split(' ')).collect::<Vec<(i8, &str)>>());
}
