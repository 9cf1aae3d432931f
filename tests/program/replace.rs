//! `--overwrite` replaces files, and never what is read.

use std::fs;

use crate::command::Scratch;

#[test]
fn figures_and_tables_never_replace_what_is_read() {
    let scratch = Scratch::new();
    scratch.file(
        "job.toml",
        "[grid]\nepsilon = 0.1\nalpha = 0.3\nbeta = 0.1\ngamma = [1.0, 2.0]\nV = 1.0\nc = [0.2, 1.5]\n\
         [methods]\nrun = [\"symmetric\"]\n[output]\npath = \"map.h5\"\n",
    );
    scratch.run("run job.toml").ends_with(0);
    scratch.file("points.csv", "epsilon,alpha,beta,gamma,V,c\n0.1,0.3,0.1,2.0,1.0,0.5\n");
    let before: Vec<Vec<u8>> =
        scratch.names().iter().map(|name| fs::read(scratch.path().join(name)).unwrap()).collect();
    let plot = |out: &str| {
        let plot = "plot map.h5 --x gamma --y c --variable verdict_symmetric --overwrite";
        scratch.run(&format!("{plot} --out {out}"))
    };
    let points = |out: &str| scratch.run(&["probe", "--points", "points.csv", "--out", out, "--overwrite"]);
    plot("map.h5").refuses(&["map.h5: this is what is read"]);
    points("points.csv").refuses(&["points.csv: this is what is read"]);
    points("./points.csv").refuses(&["points.csv: this is what is read"]);
    points("/dev/null").refuses(&["/dev/null: only files are replaced"]);
    let at = ["probe", "--epsilon=0.1", "--alpha=0.3", "--beta=0.1", "--gamma=2", "--V=1", "--c=0.5"];
    let figure = |out: &str| scratch.run(&[&at[..], &["--figure", out, "--overwrite"]].concat());
    let after: Vec<Vec<u8>> =
        scratch.names().iter().map(|name| fs::read(scratch.path().join(name)).unwrap()).collect();
    assert!(before == after);
    // Twice each: the first run makes the file, the second replaces it.
    for _ in 0..2 {
        plot("slice.svg").ends_with(0);
        plot("slice.pdf").ends_with(0);
        points("answers.csv").ends_with(0);
        figure("portrait.png").ends_with(0);
    }
}

/// Every command, with --overwrite: what it reads, through links too, and what it writes by another option.
#[cfg(unix)]
#[test]
fn no_command_replaces_what_it_reads_or_writes_one_file_twice() {
    let scratch = Scratch::new();
    let row = |i: i32| format!("{:?},{:?}\n", 0.05 * f64::from(i), 0.3 + 0.1 * (-0.5 * f64::from(i)).exp());
    scratch.file("rig.csv", format!("u,mu\n{}", (0..30).map(row).collect::<String>()));
    let machine = "[friction]\nlaw = \"table\"\nfile = \"rig.csv\"\n[machine]\nmass = 1\nstiffness = 1000\n\
                   normal_force = 10\nbelt_speed = 0.1\ndamping = 1\n";
    scratch.file("machine.toml", machine);
    scratch.file("speeds.csv", "belt_speed\n0.1\n");
    let grid = "[friction]\nlaw = \"table\"\nfile = \"rig.csv\"\nstatic = 0.4\n[grid]\nepsilon = 1.0\nV = [0.1, 0.2]\n\
                c = [0.1, 0.2]\n[methods]\nrun = [\"symmetric\"]\n[output]\npath = \"map.h5\"\n";
    scratch.file("grid.toml", grid);
    scratch.run("run grid.toml --quiet").ends_with(0);
    scratch.file("marks.csv", "V,c\n0.1,0.1\n");
    std::os::unix::fs::symlink("rig.csv", scratch.path().join("link.csv")).unwrap();
    std::os::unix::fs::symlink(".", scratch.path().join("here")).unwrap();
    let names = scratch.names();
    let read = || -> Vec<Vec<u8>> {
        names.iter().filter_map(|name| fs::read(scratch.path().join(name)).ok()).collect()
    };
    let before = read();
    let plot = "plot map.h5 --x V --y c --variable verdict_symmetric --overwrite";
    let probe = "probe --machine machine.toml --overwrite";
    for (command, place) in [
        ("fit rig.csv --out rig.csv --overwrite", "rig.csv"),
        ("fit rig.csv --out link.csv --overwrite", "link.csv"),
        ("fit link.csv --out here/rig.csv --overwrite", "here/rig.csv"),
        ("fit rig.csv --machine machine.toml --out machine.toml --overwrite", "machine.toml"),
        ("machine machine.toml --out machine.toml --overwrite", "machine.toml"),
        ("machine machine.toml --out rig.csv --overwrite", "rig.csv"),
        (&format!("{plot} --mark marks.csv --out a.svg --data marks.csv"), "marks.csv"),
        (&format!("{plot} --out a.svg --data map.h5"), "map.h5"),
        (&format!("{probe} --proof machine.toml"), "machine.toml"),
        (&format!("{probe} --orbit rig.csv"), "rig.csv"),
        (&format!("{probe} --points speeds.csv --out machine.toml"), "machine.toml"),
        (&format!("{probe} --points speeds.csv --out rig.csv"), "rig.csv"),
        ("run grid.toml --overwrite --set output.path=rig.csv", "rig.csv"),
        ("run grid.toml --overwrite --set output.path=link.csv", "link.csv"),
        (
            "probe --table rig.csv --static 0.4 --epsilon 1 --V 0.1 --c 0.1 --overwrite --figure rig.csv",
            "rig.csv",
        ),
    ] {
        scratch.run(command).refuses(&[&format!("{place}: this is what is read")]);
    }
    for command in [
        "fit rig.csv --out new.toml --figure here/new.toml",
        &format!("{plot} --out a.svg --data a.svg"),
        &format!("{probe} --orbit new.csv --figure here/new.csv"),
    ] {
        scratch.run(command).refuses(&["is written there"]);
    }
    assert!(read() == before);
}
