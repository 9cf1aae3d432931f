//! Renders SVG to PNG and PDF with the bundled font only, so that figures are the same on every machine.

use std::sync::{Arc, LazyLock};

use krilla::Document;
use krilla::geom::Size;
use krilla::page::PageSettings;
use krilla_svg::{SurfaceExt as _, SvgSettings};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::fontdb::{Database, Source};
use resvg::usvg::{Options, Tree};

/// A figure could not be converted from SVG.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw {figure}: {why}")]
pub struct RenderError {
    pub figure: String,
    pub why: String,
}

/// Resolution of PNG files in dots per inch: the usual minimum for printed line art.
const RESOLUTION: f32 = 300.0;

static OPTIONS: LazyLock<Options<'static>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    for face in [notosans::REGULAR_TTF, notosans::ITALIC_TTF] {
        fonts.load_font_source(Source::Binary(Arc::new(face)));
    }
    fonts.set_sans_serif_family("Noto Sans");
    Options { fontdb: Arc::new(fonts), font_family: "Noto Sans".into(), ..Options::default() }
});

fn tree(name: &str, svg: &str) -> Result<Tree, RenderError> {
    Tree::from_str(svg, &OPTIONS).map_err(|error| failed(name, error))
}

fn failed(name: &str, why: impl std::fmt::Display) -> RenderError {
    RenderError { figure: name.into(), why: why.to_string() }
}

pub fn png(name: &str, svg: &str) -> Result<Vec<u8>, RenderError> {
    raster(name, &tree(name, svg)?)
}

/// The figure as PNG and as PDF with text as text, on two cores.
pub fn png_and_pdf(name: &str, svg: &str) -> Result<(Vec<u8>, Vec<u8>), RenderError> {
    let tree = tree(name, svg)?;
    let (png, pdf) = rayon::join(|| raster(name, &tree), || page(name, &tree));
    Ok((png?, pdf?))
}

fn raster(name: &str, tree: &Tree) -> Result<Vec<u8>, RenderError> {
    // usvg uses 96 pixels per inch.
    let scale = RESOLUTION / 96.0;
    let size = tree.size().to_int_size().scale_by(scale).ok_or_else(|| failed(name, "it has no size"))?;
    let mut pixels =
        Pixmap::new(size.width(), size.height()).ok_or_else(|| failed(name, "it is too large"))?;
    // The last row and column are covered only in part and must not be transparent.
    pixels.fill(Color::WHITE);
    resvg::render(tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    // Opaque: a twentieth of the size that resvg's own encoder gives these figures. Flat colours compress best
    // without a filter.
    let colors: Vec<u8> =
        pixels.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::NoFilter);
    let dots_per_metre = (RESOLUTION / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: dots_per_metre,
        yppu: dots_per_metre,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(|error| failed(name, error))?;
    writer.write_image_data(&colors).map_err(|error| failed(name, error))?;
    writer.finish().map_err(|error| failed(name, error))?;
    Ok(file)
}

/// The figure as PDF, text as text.
pub fn pdf(name: &str, svg: &str) -> Result<Vec<u8>, RenderError> {
    page(name, &tree(name, svg)?)
}

fn page(name: &str, tree: &Tree) -> Result<Vec<u8>, RenderError> {
    // 96 pixels of a figure are an inch, and so are 72 points of a page.
    let size = tree.size();
    let page = Size::from_wh(0.75 * size.width(), 0.75 * size.height());
    let page = page.ok_or_else(|| failed(name, "it has no size"))?;
    let mut document = Document::new();
    let mut sheet = document.start_page_with(PageSettings::new(page));
    let mut surface = sheet.surface();
    surface.draw_svg(tree, page, SvgSettings::default());
    surface.finish();
    sheet.finish();
    document.finish().map_err(|error| failed(name, format!("{error:?}")))
}
