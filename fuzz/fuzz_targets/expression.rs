//! Friction laws as text, as configurations give them and as maps keep them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slipmap::friction::Law;

fuzz_target!(|text: &str| {
    // Texts of laws are kept for the life of the program, so that a long run needs bounded ones.
    if text.len() < 200 {
        let _ = Law::from_definition("expression", &format!("1\n{text}"));
        let _ = Law::from_definition("table", text);
    }
});
