//! Friction laws as text, as configurations give them and as maps keep them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slipmap::friction::Law;
use slipmap::point::LawParameters;

fuzz_target!(|text: &str| {
    // Texts of laws are kept until the program ends, so they are bounded in a long run.
    if text.len() < 200 {
        if let Some(Law::Expression(law)) = Law::from_definition("expression", &format!("1\n{text}")) {
            let parameters = LawParameters::new(&vec![0.5; law.parameters().len()]);
            let _ = law.check(0.1, &parameters, 2.0);
        }
        let _ = Law::from_definition("table", text);
    }
});
