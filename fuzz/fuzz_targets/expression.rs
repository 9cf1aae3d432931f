//! Friction laws as text, as configurations give them and as maps keep them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slipmap::friction::Law;

fuzz_target!(|text: &str| {
    // Texts of laws are kept until the program ends, so they are bounded in a long run.
    if text.len() < 200 {
        if let Some(law) = Law::from_definition("expression", &format!("1\n{text}")) {
            let _ = law.point(0.1, &vec![0.5; law.parameters().len()], 2.0, 0.1);
        }
        let _ = Law::from_definition("table", text);
    }
});
