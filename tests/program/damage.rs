//! Damaged maps: every command that reads one refuses it before it answers, and names the remedy.

use std::fs;

use hdf5::File;
use slipmap::column::Verdict;

use crate::command::{Says, Scratch, random};
use crate::hostile::{LABEL, PLOT, assert_no_control_characters, bounded, damaged_copy, forge, scratch};

/// Flips single bits: `check` finds each, and every other command refuses the map, in bounded memory and
/// time.
///
/// The exception is the label of the seal: without it the file has no seal, as after a copy by another
/// program. Its contents, in which no bit was flipped, are then compared with their fingerprints and used.
///
/// The other commands take turns: all of them read a map through the same verification, whichever bit was
/// flipped.
fn flip(flips: usize, seed: u64) {
    let scratch = scratch();
    let whole = fs::read(scratch.path().join("good.h5")).unwrap();
    let label = whole.len() - LABEL.len() - 65..whole.len() - 65;
    assert!(whole[label.clone()] == *LABEL);
    let mut state = seed;
    let mut ended = std::collections::BTreeMap::new();
    // The first flip is in the label, for every seed.
    for number in 0..flips {
        let among = if number == 0 { LABEL.len() } else { whole.len() };
        let place = (random(&mut state) * among as f64) as usize;
        let place = if number == 0 { label.start + place } else { place };
        let bit = (random(&mut state) * 8.0) as usize;
        let mut bytes = whole.clone();
        bytes[place] ^= 1 << bit;
        scratch.file("map.h5", &bytes);
        let report: &[&str] = &["report", "map.h5", "--overwrite"];
        let others = [&PLOT, report, &["run", "job.toml", "--resume"]];
        let turn = if number == 0 { &others[..] } else { &others[number % 3..][..1] };
        for arguments in [&["check", "map.h5"][..]].iter().chain(turn) {
            let run = bounded(&scratch, arguments);
            let what = format!("bit {bit} of byte {place}, {}: {run:?}", arguments[0]);
            assert_no_control_characters(&run);
            match arguments[0] {
                "check" => assert!((1..=2).contains(&run.code), "{what}"),
                _ if label.contains(&place) => assert_eq!(run.code, 0, "{what}"),
                _ => {
                    assert_eq!(run.code, 2, "{what}");
                    run.err.says(&["map.h5 is damaged", "sealed", "help: `slipmap check"]);
                }
            }
            assert!(!run.err.contains("panicked"), "{what}");
            *ended.entry((arguments[0], run.code)).or_insert(0) += 1;
        }
    }
    println!("{flips} flips; command and exit code: {ended:?}");
}

#[test]
fn a_dozen_flipped_bits_are_refused() {
    flip(12, 1);
}

#[test]
#[ignore = "minutes: two thousand flipped bits; cargo test --test program damage:: -- --ignored"]
fn two_thousand_flipped_bits_are_refused() {
    flip(2000, 2);
}

/// Asserts that report and plot refuse `map.h5` with one message that has these parts.
#[track_caller]
fn assert_refused(scratch: &Scratch, parts: &[&str]) {
    for arguments in [&["report", "map.h5"][..], &PLOT] {
        bounded(scratch, arguments).refuses(parts);
    }
    assert_eq!(scratch.names(), ["good.h5", "job.toml", "map.h5"]);
}

#[test]
fn maps_without_a_seal_are_compared_with_their_fingerprints() {
    let scratch = scratch();
    // Opened for writing without writing anything: the HDF5 library removes the seal.
    damaged_copy(&scratch, |_| ());
    let run = bounded(&scratch, &PLOT).ends_with(0);
    assert!(run.err.contains("note: map.h5 has no seal"), "{run:?}");
    fs::remove_file(scratch.path().join("plot.svg")).unwrap();
    // A cell of the last chunk of a variable that no slice shows, behind valid checksums of HDF5.
    damaged_copy(&scratch, |file| {
        let cells = file.dataset("margin_symmetric").unwrap();
        let mut all = cells.read_dyn::<f64>().unwrap();
        *all.iter_mut().last().unwrap() = 0.125;
        cells.write(&all).unwrap();
    });
    assert_refused(
        &scratch,
        &["map.h5 is damaged", "margin_symmetric, attribute sha256", "slipmap check map.h5"],
    );
    // An attribute alone: `check` tells that the map is not as it was, the others that its seal is missing.
    damaged_copy(&scratch, |file| file.attr("tolerance").unwrap().write_scalar(&1e-12).unwrap());
    let run = bounded(&scratch, &["check", "map.h5"]).ends_with(1);
    assert!(run.out.contains("does not end with the seal"), "{run:?}");
    let run = bounded(&scratch, &PLOT).ends_with(0);
    assert!(run.err.contains("its attributes are taken as they are"), "{run:?}");
    fs::remove_file(scratch.path().join("plot.svg")).unwrap();
    damaged_copy(&scratch, |file| {
        let alpha = file.dataset("alpha").unwrap();
        alpha.write(&[0.1, 0.6]).unwrap();
    });
    assert_refused(&scratch, &["map.h5 is damaged", "alpha, attribute sha256"]);
    damaged_copy(&scratch, |file| {
        let cells = file.dataset("verdict_simulation").unwrap();
        let mut all = cells.read_dyn::<i8>().unwrap();
        all.fill(Verdict::Present.code());
        cells.write(&all).unwrap();
        cells.attr("flag_counts").unwrap().write(&[0i64, 0, 512, 0, 0]).unwrap();
    });
    assert_refused(&scratch, &["map.h5 is damaged", "verdict_simulation, attribute sha256"]);
}

#[test]
fn damage_found_while_reading_is_bad_input_too() {
    let scratch = scratch();
    fs::copy(scratch.path().join("good.h5"), scratch.path().join("map.h5")).unwrap();
    let path = scratch.path().join("map.h5");
    // Every chunk of the variable is damaged, so that any slice contains a damaged one.
    let chunks: Vec<_> = {
        let file = File::open(&path).unwrap();
        let cells = file.dataset("verdict_simulation").unwrap();
        (0..cells.num_chunks().unwrap()).map(|i| cells.chunk_info(i).unwrap()).collect()
    };
    let mut bytes = fs::read(&path).unwrap();
    for chunk in chunks {
        // Past the two bytes of the zlib header.
        let (from, to) = (chunk.addr as usize + 2, (chunk.addr + chunk.size) as usize);
        bytes[from..to].fill(0xff);
    }
    fs::write(&path, bytes).unwrap();
    assert_refused(&scratch, &["map.h5 is damaged", "sealed"]);
    // Sealed in that state, the damage is found chunk by chunk.
    forge(&scratch);
    assert_refused(&scratch, &["cannot read verdict_simulation in map.h5"]);
}
