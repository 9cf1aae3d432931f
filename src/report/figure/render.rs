//! SVG into PNG and PDF, with the bundled font alone, so that figures are the same on every machine.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::fontdb::{Database, Source};
use resvg::usvg::{Options, Tree};

use super::super::ReportError;

/// Resolution of PNG files in dots per inch, that of printed line art at its usual minimum.
const RESOLUTION: f32 = 300.0;

static OPTIONS: LazyLock<Options<'static>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    for face in [notosans::REGULAR_TTF, notosans::ITALIC_TTF] {
        fonts.load_font_source(Source::Binary(Arc::new(face)));
    }
    fonts.set_sans_serif_family("Noto Sans");
    Options { fontdb: Arc::new(fonts), font_family: "Noto Sans".into(), ..Options::default() }
});

fn tree(name: &str, svg: &str) -> Result<Tree, ReportError> {
    Tree::from_str(svg, &OPTIONS).map_err(|error| failed(name, error))
}

fn failed(name: &str, why: impl std::fmt::Display) -> ReportError {
    ReportError::Render { figure: name.into(), why: why.to_string() }
}

/// The figure as PNG.
///
/// # Errors
/// [`ReportError::Render`].
pub fn png(name: &str, svg: &str) -> Result<Vec<u8>, ReportError> {
    let tree = tree(name, svg)?;
    // usvg counts 96 pixels to the inch.
    let scale = RESOLUTION / 96.0;
    let size = tree.size().to_int_size().scale_by(scale).ok_or_else(|| failed(name, "it has no size"))?;
    let mut pixels =
        Pixmap::new(size.width(), size.height()).ok_or_else(|| failed(name, "it is too large"))?;
    // The last row and column are covered in part only; nothing of the page may show through there.
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| failed(name, error))
}

/// The figure as PDF, text as text.
///
/// # Errors
/// [`ReportError::Render`].
pub fn pdf(name: &str, svg: &str) -> Result<Vec<u8>, ReportError> {
    svg2pdf::to_pdf(
        &tree(name, svg)?,
        svg2pdf::ConversionOptions::default(),
        svg2pdf::PageOptions { dpi: 96.0 },
    )
    .map_err(|error| failed(name, error))
}
