//! Compares two maps: every dataset and every attribute, bit for bit, except for time and machine; and makes
//! the map of these tests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use hdf5::types::{IntSize, TypeDescriptor};

use crate::command::Scratch;

/// A map of 40 tiles across the boundary of existence, with an audit; a fifth of a second of work or two.
pub const JOB: &str = "\
title = \"stopped and resumed, or shared\"
[grid]
epsilon = [0.05, 0.2]
alpha = { from = 0.0, to = 0.8, points = 80 }
beta = [0.0, 0.2]
gamma = { from = 0.5, to = 8.0, points = 8, spacing = \"log\" }
V = [0.5, 2.0]
c = { from = 0.0, to = 3.0, points = 32 }
[curves]
planes = [{ x = \"gamma\", y = \"c\" }]
[audit]
cells = 50
[output]
path = \"map.h5\"
fields = [\"verdict\", \"margin\", \"critical_c\", \"regime\"]
";

/// The map of [`JOB`] by one process that nothing stops, for many tests.
static REFERENCE: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reference");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let scratch = scratch();
    scratch.run(&["run", "job.toml", "--threads", "2"]).ends_with(0);
    let path = folder.join("map.h5");
    std::fs::copy(scratch.path().join("map.h5"), &path).unwrap();
    path
});

/// A copy of [`REFERENCE`] beside the map that is compared with it.
pub fn reference(scratch: &Scratch) -> PathBuf {
    let path = scratch.path().join("reference.h5");
    std::fs::copy(&*REFERENCE, &path).unwrap();
    path
}

/// A folder with the configuration [`JOB`].
pub fn scratch() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("job.toml", JOB);
    scratch
}

/// Returns whether an attribute records when, where and how fast a map was made.
fn is_of_time(attribute: &str) -> bool {
    let names = ["history", "machine", "threads"];
    names.contains(&attribute) || attribute.starts_with("seconds_") || attribute.ends_with("_seconds")
}

/// The bytes of a dataset, or of an attribute of a type that maps use.
fn bytes(container: &hdf5::Container) -> Vec<u8> {
    match container.dtype().unwrap().to_descriptor().unwrap() {
        TypeDescriptor::Integer(IntSize::U1) => {
            container.read_raw::<i8>().unwrap().iter().map(|v| v.cast_unsigned()).collect()
        }
        TypeDescriptor::Integer(_) => {
            container.read_raw::<i64>().unwrap().iter().flat_map(|v| v.to_le_bytes()).collect()
        }
        TypeDescriptor::Float(_) => {
            container.read_raw::<f64>().unwrap().iter().flat_map(|v| v.to_bits().to_le_bytes()).collect()
        }
        other => panic!("{other} is not compared here"),
    }
}

/// Everything in a map, by name.
pub fn contents(path: &Path) -> BTreeMap<String, Vec<u8>> {
    let file = hdf5::File::open(path).unwrap();
    let map = slipmap::store::MapFile::open(path).unwrap();
    let mut all = BTreeMap::new();
    for (name, value) in map.attributes().iter().filter(|(name, _)| !is_of_time(name)) {
        all.insert(format!("/ {name}"), format!("{value:?}").into_bytes());
    }
    let mut names = file.member_names().unwrap();
    if let Some(group) = names.iter().position(|name| name == "curves") {
        names.remove(group);
        let columns = file.group("curves").unwrap().member_names().unwrap();
        names.extend(columns.iter().map(|column| format!("curves/{column}")));
    }
    for name in names {
        let dataset = file.dataset(&name).unwrap();
        all.insert(
            format!("{name} shape"),
            format!("{:?} {:?}", dataset.shape(), dataset.chunk()).into_bytes(),
        );
        all.insert(format!("{name} cells"), bytes(&dataset));
        for attribute in dataset.attr_names().unwrap() {
            let content = dataset.attr(&attribute).unwrap();
            let kind = content.dtype().unwrap().to_descriptor().unwrap();
            let value = match kind {
                // Addresses in the file, which `slipmap check` follows.
                _ if ["DIMENSION_LIST", "REFERENCE_LIST"].contains(&attribute.as_str()) => vec![],
                // The attributes of dimension scales.
                TypeDescriptor::FixedAscii(_) => {
                    content.read_raw::<hdf5::types::FixedAscii<64>>().unwrap()[0].as_bytes().to_vec()
                }
                TypeDescriptor::FixedUnicode(size) => {
                    let mut text = vec![0u8; size];
                    read_text(&content, &mut text);
                    text
                }
                _ => bytes(&content),
            };
            all.insert(format!("{name} {attribute}"), value);
        }
    }
    all
}

/// Texts of fixed length have a type of their own for every length; 64, 128 and so on cover them.
fn read_text(attribute: &hdf5::Attribute, text: &mut [u8]) {
    macro_rules! try_sizes {
        ($($size:literal)*) => {
            $(if text.len() <= $size {
                let read = attribute.read_raw::<hdf5::types::FixedUnicode<$size>>().unwrap();
                let found = read[0].as_bytes();
                text[..found.len()].copy_from_slice(found);
                return;
            })*
        };
    }
    try_sizes!(64 128 256 512 1024);
    panic!("a text of {} bytes is not compared here", text.len());
}

/// Asserts that the two maps are equal.
#[track_caller]
pub fn assert_same(one: &Path, other: &Path) {
    let (one, other) = (contents(one), contents(other));
    let names = |map: &BTreeMap<String, Vec<u8>>| map.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&one), names(&other));
    for (name, value) in &one {
        assert!(value == &other[name], "{name} differs");
    }
}
