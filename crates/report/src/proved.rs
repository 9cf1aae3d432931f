//! The proofs of the method `validated` between the nodes of a map: the table, and shares as text.

use super::table::{Cell, ColumnOf, Show, Table};
use slipmap_figure::text::rich;
use slipmap_format::MapFile;

/// Direction in which a bound is rounded, so that it remains a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounded {
    Down,
    Up,
}

/// A bound of a share in per cent, with as many digits as the share `undecided` justifies: rounding moves the
/// bound by less than a tenth of `undecided`.
pub fn proved_percent(share: f64, undecided: f64, rounded: Rounded) -> String {
    if share >= 1.0 && rounded == Rounded::Up {
        return "100".into();
    }
    let (percent, open) = (100.0 * share, 100.0 * undecided);
    // As many decimals as a tenth of the undecided share has; an f64 near 100 has no more than fourteen.
    let decimals = if open > 0.0 { (1.0 - open.log10()).ceil().clamp(0.0, 14.0) } else { 14.0 };
    let unit = 10f64.powi(-(decimals as i32));
    let toward = |x: f64| match rounded {
        Rounded::Down => x.next_down(),
        Rounded::Up => x.next_up(),
    };
    // The nearest decimal, or the next one if that is on the wrong side.
    let text = |x: f64| format!("{x:.*}", decimals as usize);
    let wrong = |text: &str| {
        let read: f64 = text.parse().unwrap_or(f64::NAN);
        match rounded {
            Rounded::Down => !(read <= toward(percent)) && read > 0.0,
            Rounded::Up => !(read >= toward(percent)),
        }
    };
    let nearest = text(percent);
    match (wrong(&nearest), rounded) {
        (false, _) => nearest,
        (true, Rounded::Down) => text((percent - unit).max(0.0)),
        (true, Rounded::Up) => text(percent + unit),
    }
}

/// Proved shares of the whole box of parameters; `None` if the run proved nothing.
pub(super) fn volume(map: &MapFile) -> Option<Table> {
    let share = |name: &str| map.number(name);
    let (present, absent) = (share("proved_present")?, share("proved_absent")?);
    let open = share("proved_undecided_at_most")?;
    let boxes = map.number("proved_boxes")?;
    let rows = [
        ("present at least", present, Rounded::Down),
        ("absent at least", absent, Rounded::Down),
        ("undecided at most", open, Rounded::Up),
    ];
    let percent = |share: f64, rounded| Cell::Words(proved_percent(share, open, rounded));
    let columns: [ColumnOf<(&str, f64, Rounded)>; 2] = [
        ("what", "proved", Show::AsIs, &|(what, ..)| Cell::Words((*what).into())),
        ("percent_of_box", "% of the box", Show::AsIs, &|(_, share, rounded)| percent(*share, *rounded)),
    ];
    let caption = rich(
        "Volume of parameter space in which validated proves that the cycle is present or absent: the whole box \
         from the first to the last node of every axis, with all points between the nodes.",
    );
    let tried = format!(
        "Every point of the first two sets is proved, round-off included, and so are the volumes of the sets, \
         integrated in interval arithmetic. {boxes} boxes of parameters were tried; more of them, validated.boxes in the \
         configuration, leave less undecided."
    );
    Some(Table { notes: vec![rich(&tried)], ..Table::of("proved_volume", caption, &rows, &columns) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_so_that_they_stay_bounds() {
        let down = |share, open| proved_percent(share, open, Rounded::Down);
        let up = |share, open| proved_percent(share, open, Rounded::Up);
        assert_eq!((down(0.274_862_9, 1.7e-4), up(1.7e-4, 1.7e-4)), ("27.486".into(), "0.018".into()));
        assert_eq!((down(0.999, 0.5), up(0.5, 0.5)), ("99".into(), "51".into()));
        assert_eq!((down(0.0, 1.0), up(1.0, 1.0)), ("0".into(), "100".into()));
        for i in 0..1000 {
            let (share, open) = (f64::from(i) / 1000.0 + 1e-7, 10f64.powi(-(i % 12)));
            let read = |text: String| text.parse::<f64>().unwrap();
            let (low, high) = (read(down(share, open)), read(up(share, open)));
            assert!(low <= 100.0 * share && 100.0 * share <= high, "{share} {open}: {low} {high}");
            // A tenth of the undecided share on either side, and the last digits of f64.
            assert!(high - low <= 21.0 * open + 1e-12, "{share} {open}: {low} {high}");
        }
    }
}
