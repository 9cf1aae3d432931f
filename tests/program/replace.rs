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
