//! `slipmap init`, and the first words of the program.

use crate::command::{Says, Scratch};

/// Each configuration is accepted by the command that its first lines and `init` itself name first.
#[test]
fn what_init_writes_can_be_used_at_once() {
    for (kind, first) in [
        ("grid", ["run", "grid.toml"]),
        ("machine", ["machine", "machine.toml"]),
        ("table", ["machine", "table.toml"]),
    ] {
        let scratch = Scratch::new();
        let told = scratch.run(&["init", kind]).ends_with(0).err;
        assert!(told.trim_end().ends_with(&format!("next: slipmap {}", first.join(" "))), "{told}");
        assert!(scratch.read(first[1]).contains(&format!("#   slipmap {}", first.join(" "))), "{kind}");
        scratch.run(&first).ends_with(0);
        scratch.run(&["init", kind]).refuses(&[first[1], "exists already", "mv "]);
    }
}

#[test]
fn without_arguments_the_program_says_how_to_begin() {
    let scratch = Scratch::new();
    let bare = scratch.run(&[]).ends_with(2).err;
    bare.says(&["slipmap explore", "slipmap init machine", "slipmap init grid", "slipmap --help"]);
    // The help opens with the same.
    let help = scratch.run("--help").ends_with(0).out;
    assert_eq!(help.lines().next(), bare.lines().next());
}
