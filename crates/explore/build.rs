//! Puts this crate as WebAssembly, which `scripts/setup.sh` builds, into the program; without it the program says how to
//! get it.

use std::path::Path;
use std::{env, fs};

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-env-changed=SLIPMAP_WASM");
    let built = env::var("SLIPMAP_WASM").unwrap_or_default();
    let wasm = match built.as_str() {
        "" => String::new(),
        path => {
            println!("cargo::rerun-if-changed={path}");
            fs::read_to_string(path)?
        }
    };
    fs::write(Path::new(&env::var("OUT_DIR").unwrap_or_default()).join("wasm.txt"), wasm)
}
