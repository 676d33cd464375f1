//! The one drawing kit of all pictures, as SVG and with characters: scales with round ticks, panels
//! with named axes, legends with swatches, labels that keep off each other. The same input gives
//! the same bytes, text is escaped, and what is not finite is not drawn. Nothing depends on
//! scripts, or on the metrics of a font.
//!
//! No plotting crate does this: plotters draws SVG on whole pixels, which breaks heat maps and
//! smooth curves, and kuva writes NaN.

mod canvas;
mod characters;
mod legend;
mod palette;
mod panel;
mod scale;
mod thinned;

pub use canvas::Canvas;
pub(super) use canvas::{Anchor, Face, Frame, Stroke, escaped};
pub(super) use legend::{
    Entry, Label, Swatch, column, height_beside, labels_beside, labels_on_top, row,
};
pub(super) use palette::{
    CERTAIN, CLOSED, GREY, INK, POSSIBLE, SAFE, curve_style, dark_rules, heat,
};
pub(super) use panel::{Axis, Panel};
pub(super) use scale::{Scale, bounds, label};
