//! Curves of codimension one that a run stores: their values, their readers, and refused changes.

use std::sync::atomic::AtomicBool;

use hdf5::File;
use slipmap::column::bifurcation::Bifurcation;
use slipmap::map::{Plane, PlaneCurves};
use slipmap::store::MapFile;

use crate::command::{Says, Scratch};
use crate::hostile::damaged_copy;

/// Two planes: one with every kind of curve that the law has, and one with none.
const JOB: &str = "\
title = \"curves\"
[grid]
epsilon = [0.5, 1.0]
alpha = [0.0, 1.0]
beta = 0.0
gamma = { from = 0.1, to = 0.9, points = 3 }
V = { from = 5.0, to = 60.0, points = 12 }
c = { from = 0.0, to = 0.05, points = 11 }
[methods]
run = [\"symmetric\", \"simulation\"]
[curves]
planes = [
    { x = \"V\", y = \"c\", at = { epsilon = 1.0, gamma = 0.1 } },
    { x = \"c\", y = \"gamma\", at = { alpha = 1.0 } },
]
[output]
path = \"map.h5\"
fields = [\"verdict\", \"regime\"]
";

fn scratch() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("job.toml", JOB);
    scratch
}

#[test]
fn stored_curves_are_those_of_their_planes_and_are_drawn() {
    let scratch = scratch();
    let run = scratch.run("run job.toml").ends_with(0);
    run.out.says(&["curves over V and c at epsilon = 1, alpha = 0, gamma = 0.1: "]);
    run.out.says(&["curves over c and gamma at epsilon = 0.5, alpha = 1, V = 30: none"]);
    scratch.run("check map.h5").ends_with(0);

    // Bit for bit the curves that the library computes, for any number of threads.
    let map = MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let planes = [Plane::new(4, 5, vec![1, 0, 0, 0, 0, 0]), Plane::new(5, 3, vec![0, 1, 0, 0, 5, 0])];
    let stop = AtomicBool::new(false);
    let expected = planes.map(|plane| PlaneCurves::of(map.grid(), plane, &stop));
    assert_eq!(map.curves(), expected);
    for kind in [Bifurcation::GrazingSliding, Bifurcation::Landing, Bifurcation::Crossing] {
        assert!(map.curves()[0].curves.iter().any(|curve| curve.bifurcation == kind), "{kind:?}");
    }
    assert!(map.curves()[1].curves.is_empty());
    // A point on an axis that is stored in decimal is inside the axis' range.
    for point in map.curves()[0].curves.iter().flat_map(|curve| &curve.points) {
        assert!(
            (5.0..=60.0).contains(&point.x) && (0.0..=0.05).contains(&point.y) && point.error < 1e-6,
            "{point:?}"
        );
    }

    // Stored curves are drawn in their own plane, in either orientation, and in no other plane.
    let plot = |x: &str, y: &str, epsilon: &str, out: &str| {
        let at = format!("epsilon={epsilon}");
        let plane = ["plot", "map.h5", "--x", x, "--y", y, "--at", &at, "--at", "gamma=0.1"];
        let regimes = ["--variable", "regime", "--no-curves", "--out", out];
        scratch.run(&[&plane[..], &regimes].concat()).ends_with(0);
        scratch.read(out)
    };
    for (x, y) in [("V", "c"), ("c", "V")] {
        let figure = plot(x, y, "1", &format!("{x}.svg"));
        assert!(
            figure.contains(">landing") && figure.contains("Lines: where the long-run behaviour changes"),
            "{x}"
        );
    }
    assert!(!plot("V", "c", "0.5", "elsewhere.svg").contains(">landing"));
    // If requested, their points are written as a table, which equals the stored one.
    let asked = ["plot", "map.h5", "--x", "V", "--y", "c", "--at", "epsilon=1", "--at", "gamma=0.1"];
    let told = scratch.run(&[&asked[..], &["--curves", "--out", "asked.svg"]].concat()).ends_with(0).err;
    assert!(told.ends_with("wrote asked.svg and asked.csv\n"), "{told}");
    let quiet = scratch.run(&[&asked[..], &["--out", "quiet.svg", "--quiet"]].concat()).ends_with(0).err;
    assert_eq!(quiet, "");
    assert_eq!(scratch.read("asked.csv").lines().count(), 1 + map.curves()[0].points());

    scratch.run("report map.h5").ends_with(0);
    assert!(scratch.read("map-report/figures/curves-V-c.svg").contains(">landing"));
    assert!(!scratch.read("map-report/figures/curves-c-gamma.svg").contains(">landing"));
}

#[test]
fn changed_curves_are_refused() {
    let scratch = scratch();
    scratch.run(&["run", "job.toml", "--set", "curves.planes=[{ x = \"V\", y = \"c\" }]"]).ends_with(0);
    std::fs::copy(scratch.path().join("map.h5"), scratch.path().join("good.h5")).unwrap();
    type Damage = fn(&File);
    let cases: [(&str, Damage); 6] = [
        ("curves/point is missing", |file| file.unlink("curves/point").unwrap()),
        ("curves/plane is missing", |file| file.unlink("curves/plane").unwrap()),
        ("curves/error, attribute sha256", |file| {
            file.dataset("curves/error").unwrap().write_slice(&[1.0], 0..1).unwrap();
        }),
        ("curves have a point of plane 7", |file| {
            file.dataset("curves/plane_number").unwrap().write_slice(&[7i32], 0..1).unwrap();
        }),
        ("curves/branch has 3 rows", |file| {
            file.unlink("curves/branch").unwrap();
            file.new_dataset_builder().with_data(&[1i32, 1, 1]).create("curves/branch").unwrap();
        }),
        ("hold gamma at no node", |file| {
            file.dataset("curves/held_gamma").unwrap().write_slice(&[0.2], 0..1).unwrap();
        }),
    ];
    for (part, damage) in cases {
        damaged_copy(&scratch, damage);
        let run = scratch.run("check map.h5").ends_with(1);
        assert!(run.out.contains(part), "no `{part}` in {}", run.out);
        scratch.run("report map.h5").refuses(&["map.h5", part]);
    }
}
