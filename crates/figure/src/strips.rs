//! Strips: several variables along one axis, each as a row of coloured cells.

use super::axis::{AXIS, SMALL_TEXT, Scale};
use super::legend::Legend;
use super::panels::{BOTTOM_MARGIN, Labels, Panel, TITLE_MARGIN, write_heading};
use super::region::{cell_edges, outlines};
use super::scene::{Anchor, Fill, Rect, Scene, Width, text_width};
use super::text::Rich;

const ROW: f64 = 15.0;

/// A row: its name, and the index of each cell's kind.
#[derive(Clone, Debug)]
pub struct Strip {
    pub name: Rich,
    /// The kind of each node's cell.
    pub kinds: Vec<usize>,
}

/// Draws strips over the nodes of an axis; `kinds` are the possible fills with their names.
pub fn draw(
    heading: &Rich,
    nodes: &[f64],
    (scale, x_name): (Scale, &Rich),
    strips: &[Strip],
    kinds: &[(Fill, Rich)],
    width: Width,
) -> Scene {
    let mut scene = Scene::new(width.points(), 0.0);
    let names = strips.iter().map(|strip| text_width(&strip.name, SMALL_TEXT)).fold(0.0, f64::max);
    let left = names + 8.0;
    let top = TITLE_MARGIN + write_heading(&mut scene, 4.0, heading);
    let rect = Rect { x: left, y: top, w: scene.width - left - 12.0, h: ROW * strips.len() as f64 };
    let edges = cell_edges(nodes, scale);
    let mut used = vec![false; kinds.len()];
    for (row, strip) in strips.iter().enumerate() {
        let here = Rect { y: top + ROW * row as f64, h: ROW, ..rect };
        let panel = Panel { rect: here, x: scale, y: Scale::linear(0.0, 1.0) };
        for (kind, (fill, _)) in kinds.iter().enumerate() {
            let areas = outlines(&panel, &edges, &[0.0, 1.0], |i, _| strip.kinds[i] == kind);
            used[kind] |= !areas.is_empty();
            scene.area(&areas, *fill);
        }
        scene.frame(here, &AXIS);
        let baseline = here.y + 0.5 * ROW + 0.36 * SMALL_TEXT;
        scene.text((left - 4.0, baseline), &strip.name, SMALL_TEXT, Anchor::End);
    }
    let panel = Panel { rect, x: scale, y: Scale::linear(0.0, 1.0) };
    panel.x_axis(&mut scene, Labels { x: true, y: false });
    panel.x_name(&mut scene, x_name);
    let mut legend = Legend::default();
    legend.add_used(kinds, &used);
    legend.below(&mut scene, left, rect.y + rect.h + BOTTOM_MARGIN);
    scene
}
