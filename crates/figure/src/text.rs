//! Text with mathematical symbols, for HTML, LaTeX and figures alike.
//!
//! Words from a map file enter through [`Rich::foreign`] and are escaped for each format; the program's own
//! words may contain symbols in braces, see [`rich`].

use slipmap_numbers::text::{digits_within, known_part, scientific, without_zeros};

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    Words(String),
    Symbol(Symbol),
    Formula(Formula),
}

/// A formula, set in each format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    pub plain: String,
    /// The contents of an element `math`.
    pub html: String,
    /// Without the dollars.
    pub latex: String,
}

/// A letter with an optional index and an optional exponent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// The letter, or a word where there is no letter.
    pub base: String,
    /// Index, empty if none.
    pub index: String,
    /// Exponent, empty if none.
    pub exponent: String,
}

/// Greek letters: their names in axes and templates, the letter, and the name in LaTeX.
const GREEK: [(&str, &str, &str); 16] = [
    ("alpha", "α", r"\alpha"),
    ("beta", "β", r"\beta"),
    ("gamma", "γ", r"\gamma"),
    ("delta", "δ", r"\delta"),
    ("epsilon", "ε", r"\varepsilon"),
    ("zeta", "ζ", r"\zeta"),
    ("eta", "η", r"\eta"),
    ("theta", "θ", r"\theta"),
    ("kappa", "κ", r"\kappa"),
    ("lambda", "λ", r"\lambda"),
    ("mu", "μ", r"\mu"),
    ("nu", "ν", r"\nu"),
    ("rho", "ρ", r"\rho"),
    ("sigma", "σ", r"\sigma"),
    ("tau", "τ", r"\tau"),
    ("phi", "φ", r"\varphi"),
];

impl Symbol {
    /// The symbol of an axis or quantity: `gamma` is γ, `x_1` is x with an index, `c^*` has an exponent.
    pub fn of(name: &str) -> Self {
        let (rest, exponent) = name.split_once('^').unwrap_or((name, ""));
        let (base, index) = rest.split_once('_').unwrap_or((rest, ""));
        let letter = GREEK.iter().find(|(word, _, _)| *word == base).map_or(base, |(_, letter, _)| letter);
        Self { base: letter.into(), index: index.into(), exponent: exponent.into() }
    }

    /// Returns whether the base is one letter, set in italics; a word is set upright.
    pub fn is_letter(&self) -> bool {
        self.base.chars().count() == 1
    }

    fn latex(&self) -> String {
        let letter = GREEK.iter().find(|(_, letter, _)| *letter == self.base);
        let mut text = match letter {
            Some((_, _, command)) => (*command).to_owned(),
            None if self.is_letter() || self.base.bytes().all(|b| b.is_ascii_digit()) => latex(&self.base),
            None => format!(r"\mathrm{{{}}}", latex(&self.base)),
        };
        if !self.index.is_empty() {
            text.push_str(&format!("_{{{}}}", index_latex(&self.index)));
        }
        match self.exponent.as_str() {
            "" => {}
            "*" => text.push_str(r"^{\ast}"),
            other => text.push_str(&format!("^{{{}}}", latex(other))),
        }
        format!("${text}$")
    }

    fn html(&self) -> String {
        let base = html(&self.base);
        let mut text = if self.is_letter() { format!("<i>{base}</i>") } else { base };
        if !self.index.is_empty() {
            text.push_str(&format!("<sub>{}</sub>", html(&self.index)));
        }
        if !self.exponent.is_empty() {
            text.push_str(&format!("<sup>{}</sup>", html(&self.exponent)));
        }
        text
    }

    /// Plain text, with raised exponents where Unicode has the characters: 10⁻⁶ must not read 10−6.
    fn plain(&self) -> String {
        let exponent: String = self.exponent.chars().map(raised).collect();
        format!("{}{}{exponent}", self.base, self.index)
    }
}

/// A digit or a minus sign above the line; other characters as they are.
pub fn raised(character: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match character.to_digit(10) {
        Some(digit) => DIGITS[digit as usize],
        None if matches!(character, '-' | '−') => '⁻',
        None => character,
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rich {
    /// Its parts, in order.
    pub pieces: Vec<Piece>,
}

/// The program's own words, with symbols in braces: `"share of {c}"`, `"{x_1}"`, `"{c^*}"`.
pub fn rich(template: &str) -> Rich {
    let mut text = Rich::default();
    for (i, part) in template.split(['{', '}']).enumerate() {
        // Braces alternate, so every other part is between braces.
        if i % 2 == 1 {
            text.pieces.push(Piece::Symbol(Symbol::of(part)));
        } else if !part.is_empty() {
            text.pieces.push(Piece::Words(part.into()));
        }
    }
    text
}

/// The words with a capital letter at their beginning.
pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_ascii_uppercase().to_string() + letters.as_str())
}

/// Joins parts by commas, without those that are empty.
pub fn join(parts: impl IntoIterator<Item = Rich>) -> Rich {
    let mut text = Rich::default();
    for part in parts.into_iter().filter(|part| !part.pieces.is_empty()) {
        let separator = rich(if text.pieces.is_empty() { "" } else { ", " });
        text = text.then(separator).then(part);
    }
    text
}

/// Only words written in the program are parsed as templates, see [`rich`].
impl From<&'static str> for Rich {
    fn from(template: &'static str) -> Self {
        rich(template)
    }
}

impl Rich {
    /// Words from a file or from a user, with arbitrary characters.
    pub fn foreign(words: &str) -> Self {
        Self { pieces: vec![Piece::Words(words.into())] }
    }

    pub fn formula(formula: Formula) -> Self {
        Self { pieces: vec![Piece::Formula(formula)] }
    }

    pub fn symbol(name: &str) -> Self {
        Self { pieces: vec![Piece::Symbol(Symbol::of(name))] }
    }

    /// A number with up to `digits` significant digits, very large and very small ones with a power of ten.
    pub fn number(value: f64, digits: usize) -> Self {
        let (mantissa, exponent) = scientific(value, digits);
        if !value.is_finite() {
            return Self::foreign(&mantissa);
        }
        let minus = |text: &str| text.replace('-', "−");
        if value == 0.0 || (-3..=5).contains(&exponent) {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            return Self::foreign(&minus(without_zeros(&format!("{value:.decimals$}"))));
        }
        let power = Self::power_of_ten(exponent);
        match without_zeros(&mantissa) {
            "1" => power,
            "-1" => Self::foreign("−").then(power),
            mantissa => Self::foreign(&format!("{} × ", minus(mantissa))).then(power),
        }
    }

    /// A number with at most `digits` digits, and with its error where that reaches them: "13.7 ± 0.14", but
    /// "13.71" with an error that is far smaller. Digits beyond the error are not printed.
    pub fn with_error(value: f64, error: f64, digits: usize) -> Self {
        if !Self::shows_error(value, error, digits) {
            return Self::number(value, digits);
        }
        let [value, error] = known_part(value, error);
        Self::number(value, digits + 2).then(" ± ").then(Self::number(error, 2))
    }

    /// Whether [`Rich::with_error`] prints the error: it is at least a tenth of a unit of the last digit.
    pub fn shows_error(value: f64, error: f64, digits: usize) -> bool {
        digits_within(value, error, digits + 3) < digits + 3
    }

    pub fn power_of_ten(exponent: i32) -> Self {
        let exponent = exponent.to_string().replace('-', "−");
        Self { pieces: vec![Piece::Symbol(Symbol { base: "10".into(), index: String::new(), exponent })] }
    }

    pub fn then(mut self, more: impl Into<Rich>) -> Self {
        self.pieces.extend(more.into().pieces);
        self
    }

    /// Appends a unit, if there is one: "0.4 m/s".
    pub fn with_unit(self, unit: &str) -> Self {
        if unit.is_empty() { self } else { self.then(Self::foreign(&format!(" {unit}"))) }
    }

    /// Appends the parameters at which a figure was computed, unless `place` is empty: " at ε = 0.1".
    pub fn taken_at(self, place: Rich) -> Self {
        if place.pieces.is_empty() { self } else { self.then(" at ").then(place) }
    }

    /// Plain text, for file names, CSV and messages.
    pub fn plain(&self) -> String {
        self.write(str::to_owned, Symbol::plain, |formula| formula.plain.clone())
    }

    pub fn html(&self) -> String {
        self.write(html, Symbol::html, |it| format!("<math displaystyle=\"true\">{}</math>", it.html))
    }

    pub fn latex(&self) -> String {
        self.write(latex, Symbol::latex, |it| format!(r"$\displaystyle {}$", it.latex))
    }

    fn write(
        &self,
        words: fn(&str) -> String,
        symbol: fn(&Symbol) -> String,
        formula: fn(&Formula) -> String,
    ) -> String {
        self.pieces
            .iter()
            .map(|piece| match piece {
                Piece::Words(text) => words(text),
                Piece::Symbol(s) => symbol(s),
                Piece::Formula(it) => formula(it),
            })
            .collect()
    }
}

/// Escapes words for HTML and for SVG, in elements and in quoted attributes. Characters that XML forbids
/// become spaces.
pub fn html(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for c in words.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\'' => text.push_str("&#39;"),
            '\n' | '\t' => text.push(c),
            '\u{fffe}' | '\u{ffff}' => text.push(' '),
            c if c.is_control() => text.push(' '),
            c => text.push(c),
        }
    }
    text
}

/// Escapes words for LaTeX. Characters that pdfLaTeX does not know by default are written as their number.
pub fn latex(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    let mut letters = words.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '\\' => text.push_str(r"\textbackslash{}"),
            '~' => text.push_str(r"\textasciitilde{}"),
            '^' => text.push_str(r"\textasciicircum{}"),
            '{' | '}' | '$' | '&' | '#' | '%' | '_' => {
                text.push('\\');
                text.push(c);
            }
            '<' => text.push_str(r"\textless{}"),
            '>' => text.push_str(r"\textgreater{}"),
            '|' => text.push_str(r"\textbar{}"),
            '"' => text.push_str(r"\textquotedbl{}"),
            '`' => text.push_str(r"\textasciigrave{}"),
            // Prevents ligatures: `--` would print as one long dash.
            '-' | '\'' | ',' if letters.peek() == Some(&c) => {
                text.push(c);
                text.push_str("{}");
            }
            '×' => text.push_str(r"\ensuremath{\times}"),
            '−' => text.push_str(r"\ensuremath{-}"),
            '≥' => text.push_str(r"\ensuremath{\ge}"),
            '≤' => text.push_str(r"\ensuremath{\le}"),
            '±' => text.push_str(r"\ensuremath{\pm}"),
            '²' => text.push_str(r"\ensuremath{^{2}}"),
            '·' => text.push_str(r"\ensuremath{\cdot}"),
            '–' => text.push_str("--"),
            c if c.is_control() => text.push(' '),
            c if c.is_ascii() || ('\u{c0}'..'\u{180}').contains(&c) => text.push(c),
            c => match GREEK.iter().find(|(_, letter, _)| letter.chars().eq([c])) {
                Some((_, _, command)) => text.push_str(&format!(r"\ensuremath{{{command}}}")),
                None => text.push_str(&format!("[U+{:04X}]", u32::from(c))),
            },
        }
    }
    text
}

fn index_latex(index: &str) -> String {
    if index.chars().count() == 1 { latex(index) } else { format!(r"\mathrm{{{}}}", latex(index)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_are_equal_in_all_formats() {
        let text = rich("error of {c^*} at {epsilon}, {x_1}");
        assert_eq!(text.plain(), "error of c* at ε, x1");
        assert_eq!(Rich::number(-1.579e-16, 4).plain(), "−1.579 × 10⁻¹⁶");
        assert_eq!(text.latex(), r"error of $c^{\ast}$ at $\varepsilon$, $x_{1}$");
        assert_eq!(text.html(), "error of <i>c</i><sup>*</sup> at <i>ε</i>, <i>x</i><sub>1</sub>");
        assert_eq!(Rich::symbol("width").latex(), r"$\mathrm{width}$");
    }

    #[test]
    fn errors_are_told_where_they_reach_the_digits() {
        let text = |error: f64, digits: usize| Rich::with_error(13.7128, error, digits).plain();
        assert_eq!(text(0.14, 3), "13.71 ± 0.15");
        assert_eq!(text(0.14, 4), "13.71 ± 0.15");
        assert_eq!([text(1e-3, 3), text(1e-9, 4), text(0.0, 4)], ["13.7", "13.71", "13.71"]);
    }

    #[test]
    fn foreign_words_are_escaped() {
        let hostile = "<script>alert('x')</script> & \\input{/etc/passwd} $x$ | `rm` {c}\n# d\0";
        let text = Rich::foreign(hostile);
        let html = text.html();
        assert!(!html.contains('<') && !html.contains('\0') && html.contains("&lt;script&gt;"), "{html}");
        let latex = text.latex();
        assert!(latex.contains(r"\textbackslash{}input\{/etc/passwd\} \$x\$"), "{latex}");
        assert!(!latex.contains('\n'), "{latex}");
        assert_eq!(super::latex("中é"), "[U+4E2D]é");
    }
}
