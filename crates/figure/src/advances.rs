//! Widths of letters, from a table of those of the font: for a text's width alone the font itself is not needed.

use std::collections::HashMap;
use std::sync::LazyLock;

/// Advances in the regular and in the italic face, in units of 1 / `EM`.
const TABLE: &str = include_str!("advances.txt");
const EM: f64 = 2048.0;

/// The advances of a letter in both faces; `None` for one that a face lacks.
type Advances = [Option<u16>; 2];

static ADVANCES: LazyLock<HashMap<u32, Advances>> = LazyLock::new(|| rows(TABLE).collect());

/// The code and the advances of each letter of a table.
fn rows(table: &str) -> impl Iterator<Item = (u32, Advances)> {
    table.lines().filter(|line| !line.starts_with('#')).flat_map(|line| {
        let mut parts = line.split(" | ");
        let first = u32::from_str_radix(parts.next().unwrap_or_default(), 16).unwrap_or(0);
        let mut face = || parts.next().unwrap_or_default().split(' ').map(|advance| advance.parse().ok());
        face().zip(face()).zip(first..).map(|((regular, italic), code)| (code, [regular, italic]))
    })
}

/// Width of a letter as a share of the font's size; `None` for one of which it is not known.
pub(crate) fn advance(letter: char, italic: bool) -> Option<f64> {
    let advances = ADVANCES.get(&u32::from(letter))?;
    advances[usize::from(italic)].map(|advance| f64::from(advance) / EM)
}

#[cfg(test)]
mod tests {
    use ttf_parser::Face;

    use super::*;

    #[test]
    fn the_table_is_that_of_the_font() {
        let faces = [notosans::REGULAR_TTF, notosans::ITALIC_TTF].map(|font| Face::parse(font, 0).unwrap());
        assert!(faces.iter().all(|face| f64::from(face.units_per_em()) == EM));
        let mut known = 0;
        for (code, advances) in rows(TABLE) {
            let letter = char::from_u32(code).unwrap();
            let of = |face: &Face| face.glyph_hor_advance(face.glyph_index(letter)?);
            assert_eq!(advances, [of(&faces[0]), of(&faces[1])], "{letter}");
            known += usize::from(advances[0].is_some());
        }
        assert!(known > 600 && advance('φ', true) > advance('i', true), "{known}");
    }
}
