//! Single figures in files.

use std::path::{Path, PathBuf};

use super::render::{self, RenderError};
use super::scene::Scene;
use super::text::Rich;
use slipmap_files::{Existing, WriteError, write_file};

/// Reason why there is no file of a figure.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    #[error("{0} does not end in .svg, .pdf or .png; give the figure one of these endings")]
    Format(PathBuf),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Writes one figure, in the format given by the extension of `path`.
///
/// # Errors
/// [`FigureError::Format`] for another extension than svg, png or pdf, or why it could not be drawn or written.
pub fn write_figure(
    scene: &Scene,
    caption: &Rich,
    path: &Path,
    existing: Existing,
) -> Result<(), FigureError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let name = path.file_stem().map_or("figure".into(), |stem| stem.to_string_lossy());
    let svg = scene.svg(&name, caption);
    let contents = match ending.as_deref() {
        Some("svg") => svg.into_bytes(),
        Some("png") => render::png(&name, &svg)?,
        Some("pdf") => render::pdf(&name, &svg)?,
        _ => return Err(FigureError::Format(path.to_path_buf())),
    };
    Ok(write_file(&contents, path, existing)?)
}
