//! Paragraphs: texts broken into lines of a width.

use super::scene::text_width;
use super::text::{Piece, Rich};

/// Breaks a text of size `size` into at most `most` lines of at most `width`; "…" marks omitted text. Numbers
/// stay with their units, and operators at the end of their line.
pub fn paragraph(text: &Rich, size: f64, width: f64, most: usize) -> Vec<Rich> {
    let fits = |line: &Rich| text_width(line, size) <= width;
    // A part that is too wide is broken between any two letters.
    let parts =
        atoms(text).into_iter().flat_map(|atom| if fits(&atom) { vec![atom] } else { letters(&atom) });
    let mut lines = lines_of(parts, size, width);
    if lines.len() > most {
        lines.truncate(most);
        if let Some(last) = lines.last_mut() {
            let mut parts = letters(last);
            while parts.pop().is_some() {
                *last = parts.iter().cloned().fold(Rich::default(), Rich::then).then(" …");
                if fits(last) {
                    break;
                }
            }
        }
    }
    lines.iter().map(in_few_pieces).collect()
}

/// Lines of as many of the parts each as fit into `width`.
pub(super) fn lines_of(parts: impl IntoIterator<Item = Rich>, size: f64, width: f64) -> Vec<Rich> {
    let mut lines: Vec<Rich> = Vec::new();
    for part in parts {
        let longer = lines.last().map(|line| line.clone().then(part.clone()));
        match (lines.last_mut(), longer) {
            (Some(line), Some(longer)) if text_width(&longer, size) <= width => *line = longer,
            _ => lines.push(part),
        }
    }
    lines
}

/// The text with successive words merged into one piece, which becomes one element of SVG.
fn in_few_pieces(text: &Rich) -> Rich {
    let mut pieces: Vec<Piece> = Vec::new();
    for piece in &text.pieces {
        match (pieces.last_mut(), piece) {
            (Some(Piece::Words(before)), Piece::Words(words)) => before.push_str(words),
            _ => pieces.push(piece.clone()),
        }
    }
    Rich { pieces }
}

/// The parts between which a line may be broken.
fn atoms(text: &Rich) -> Vec<Rich> {
    let mut atoms = vec![Rich::default()];
    // The word before, which may consist of several pieces.
    let mut before = String::new();
    for piece in &text.pieces {
        let words = match piece {
            Piece::Words(words) => words.split_inclusive(' ').collect(),
            Piece::Symbol(_) | Piece::Formula(_) => vec![""],
        };
        for word in words {
            let ended = before.ends_with(' ');
            let number = before.trim_end().ends_with(|last: char| last.is_ascii_digit() || last == '±');
            let short = word.trim().chars().count() <= 2 || word.contains('/');
            if ended && !number && !short {
                atoms.push(Rich::default());
            }
            before = if ended { word.to_owned() } else { before + word };
            let part = match piece {
                Piece::Words(_) => Rich::foreign(word),
                Piece::Symbol(_) | Piece::Formula(_) => Rich { pieces: vec![piece.clone()] },
            };
            if let Some(atom) = atoms.last_mut() {
                atom.pieces.extend(part.pieces);
            }
        }
    }
    atoms
}

/// Every letter and every symbol of a text.
fn letters(text: &Rich) -> Vec<Rich> {
    let of = |piece: &Piece| match piece {
        Piece::Words(words) => words.chars().map(|letter| Rich::foreign(&letter.to_string())).collect(),
        Piece::Symbol(_) | Piece::Formula(_) => vec![Rich { pieces: vec![piece.clone()] }],
    };
    text.pieces.iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::super::text::rich;
    use super::*;

    fn broken(text: &Rich, width: f64, most: usize) -> Vec<String> {
        let lines = paragraph(text, 8.0, width, most);
        for line in &lines {
            // A space at the end of a line is not seen.
            let seen = Rich::foreign(line.plain().trim_end());
            assert!(text_width(&seen, 8.0) <= width, "{line:?}");
        }
        lines.iter().map(|line| line.plain().trim_end().to_owned()).collect()
    }

    #[test]
    fn numbers_stay_with_their_units() {
        let number = |value: f64| Rich::number(value, 3).with_unit("N s/m");
        let text = rich("Stick-slips at ").then(number(30.0)).then("; more than ").then(number(481.0));
        let text = text.then(" ends stick-slip.");
        let all = broken(&text, 1000.0, 9);
        assert_eq!(paragraph(&text, 8.0, 1000.0, 9)[0].pieces.len(), 1, "one element of a figure");
        assert_eq!(all, ["Stick-slips at 30 N s/m; more than 481 N s/m ends stick-slip."]);
        let with_error = rich("more than 157.6 ± 6.5").with_unit("N s/m").then(" ends the vibration");
        let widths = [90.0, 100.0, 110.0, 130.0, 150.0];
        for (text, width) in widths.map(|width| [(&text, width), (&with_error, width)]).concat() {
            let lines = broken(text, width, 9);
            assert_eq!(lines.join(" "), text.plain());
            for line in lines {
                let last = line.chars().last().unwrap();
                assert!(
                    !last.is_ascii_digit() && last != '±' && !line.ends_with(" N") && !line.ends_with(" s"),
                    "{line}"
                );
            }
        }
    }

    #[test]
    fn long_words_are_broken_and_long_texts_end_in_dots() {
        let word = Rich::foreign(&"x".repeat(100));
        assert_eq!(broken(&word, 100.0, 99).concat(), "x".repeat(100));
        let lines = broken(&word, 100.0, 2);
        assert!(lines.len() == 2 && lines[1].ends_with('…') && lines[1].len() > 10, "{lines:?}");
        let formula = "muk + (mus - muk)*exp(-u/vs) + bump*exp(-((u - 0.3)/0.05)^2)";
        let lines = broken(&Rich::foreign(formula), 150.0, 9);
        assert_eq!(lines, ["muk + (mus - muk)*exp(-u/vs) +", "bump*exp(-((u - 0.3)/0.05)^2)"]);
    }
}
