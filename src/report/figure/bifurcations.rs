//! Curves of codimension one in the plane of a slice, by continuation.

use std::fmt::Write as _;

use super::super::text::rich;
use super::axis::{Panel, Scale};
use super::legend::{Legend, Sample};
use super::palette;
use super::scene::{Place, Scene, Stroke};
use super::slice::Slice;
use super::slices::{EXACT, HALO};
use crate::filippov::Oscillator;
use crate::simulate::bifurcation::Bifurcation;
use crate::simulate::continuation::Branch;

/// Accuracy of the test functions.
const TOLERANCE: f64 = 1e-10;

/// The curves of a slice.
#[derive(Clone, Debug)]
pub struct PlaneCurves {
    axes: [(String, Scale); 2],
    /// Those that there are, in the order of [`Bifurcation::ALL`]; places are positions along the two scales.
    pub curves: Vec<(Bifurcation, Vec<Branch>)>,
}

impl PlaneCurves {
    /// The curves of a slice between its first and last nodes.
    #[must_use]
    pub fn of(slice: &Slice) -> Self {
        let scales = [slice.x_axis(), slice.y_axis()].map(|axis| Scale::of_nodes(&axis.values));
        let at = |[s, t]: [f64; 2]| {
            Oscillator::new(slice.law(), &slice.point(scales[0].value(s), scales[1].value(t)))
        };
        let curves = Bifurcation::ALL.map(|bifurcation| (bifurcation, bifurcation.curves(&at, TOLERANCE)));
        let names = [slice.x_axis(), slice.y_axis()].map(|axis| axis.name.clone());
        Self {
            axes: [(names[0].clone(), scales[0]), (names[1].clone(), scales[1])],
            curves: curves.into_iter().filter(|(_, branches)| !branches.is_empty()).collect(),
        }
    }

    /// The values of both axes at a place.
    fn values(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.axes[axis].1.value(place[axis]))
    }

    /// All points as a table: the curve, the number of its branch from 1, the values of both axes, and the error,
    /// a distance in sides of the plotted rectangle.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = format!("curve,branch,{},{},error\n", self.axes[0].0, self.axes[1].0);
        for (bifurcation, branches) in &self.curves {
            for (number, branch) in branches.iter().enumerate() {
                for point in &branch.points {
                    let [x, y] = self.values(point.place);
                    let (name, number) = (bifurcation.name(), number + 1);
                    // Writing to a string does not fail.
                    let _ = writeln!(text, "{name},{number},{x:?},{y:?},{:e}", point.error);
                }
            }
        }
        text
    }

    /// Draws them into the panel of the slice.
    pub(super) fn draw(&self, scene: &mut Scene, panel: &Panel, legend: &mut Legend) {
        for (bifurcation, branches) in &self.curves {
            let stroke = style(*bifurcation);
            scene.clipped(panel.rect, |scene| {
                for branch in branches {
                    let place = |place: [f64; 2]| {
                        let [x, y] = self.values(place);
                        panel.place(x, y)
                    };
                    let places: Vec<Place> = branch.points.iter().map(|point| place(point.place)).collect();
                    scene.line(&places, &HALO);
                    scene.line(&places, &stroke);
                }
            });
            legend.add(Sample::Line(stroke), rich(words(*bifurcation)));
        }
    }
}

/// Lines that differ in their dashes; colours must show on every area.
fn style(bifurcation: Bifurcation) -> Stroke {
    match bifurcation {
        Bifurcation::Hopf => Stroke { color: palette::BLACK, width: 1.0, dash: &[5.0, 2.0] },
        Bifurcation::GrazingSliding => EXACT,
        Bifurcation::Landing => Stroke { color: palette::VERMILION, width: 1.2, dash: &[1.4, 1.4] },
        Bifurcation::Crossing => Stroke { color: palette::BLUE, width: 1.2, dash: &[3.0, 1.4] },
        Bifurcation::Fold => Stroke { color: palette::PURPLE, width: 1.2, dash: &[6.0, 1.6, 1.2, 1.6] },
    }
}

fn words(bifurcation: Bifurcation) -> &'static str {
    match bifurcation {
        Bifurcation::Hopf => "Hopf",
        Bifurcation::GrazingSliding => "grazing",
        Bifurcation::Landing => "landing",
        Bifurcation::Crossing => "crossing",
        Bifurcation::Fold => "fold",
    }
}
