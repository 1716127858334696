//! What the programs share for reports: pictures, plots, a page, and the clocks by which they measure.
//!
//! - [`line_plot`], [`bar_plot`]: plots as SVG text; [`stacked`]: several [`Plot`]s in one
//! - [`ContactSheet`]: small pictures on one page, in labelled rows and columns
//! - [`Artist`]: renders one character, lit, with joint marks ([`JointMark`]); [`close_up`]:
//!   renders a part of it
//! - [`draw_skeleton`]: draws joints over an existing picture; [`influencing_joints`]: selects the joints
//!   that move vertices
//! - [`face_sheet`]: a face with its feature points
//! - [`morph_target_sheet`], [`clip_sheet`]: the shapes of a face, by morph target and over a clip
//! - [`facet_sheet`]: a mesh at several choices of levels, every triangle visible
//! - [`scene_picture`]: renders the crowds of a scene, in their colours and by level; [`crowd_plots`]: their time and
//!   error
//! - [`crowd_for_sizes`]: the built-in scenes for figures that are larger than a person
//! - [`motion_sheet`], [`camera_path_sheet`], [`rest_sheet`]: a clip under motion level of detail
//!   next to the original clip
//! - [`lines_by_distance`], [`lines_by_method`]: the lines of such a sheet; [`gain_plot`], [`error_plot`],
//!   [`updates_plot`], [`cost_plots`], [`path_plots`], [`schedule_plots`]: the same as plots
//! - [`trace_plot`]: an item played over a trace of bandwidth
//! - [`demo`]: all steps on one character, with a page
//! - [`thread_ns`], [`nanoseconds`], [`FRAME_CLOCKS`]: processor and wall-clock time
//! - [`evenly_spaced_frames`]: the frames of a clip that a sheet shows
//!
//! ```
//! use articula::flat::{Picture, PictureError};
//! use articula_report::{SheetCell, ContactSheet, PlotOptions, SheetRow, Series, line_plot};
//!
//! let options = PlotOptions { title: "Error".into(), ..PlotOptions::default() };
//! let series = Series { points: vec![(1.0, 3.0), (2.0, 1.5)], ..Series::default() };
//! assert!(line_plot(&options, &[series]).starts_with("<svg"));
//!
//! let red = Picture::new(60, 40, [200, 30, 30, 255])?;
//! let row = SheetRow { label: "near".into(), cells: vec![SheetCell::of(red, "5 m")] };
//! let sheet = ContactSheet { title: "Levels".into(), rows: vec![row], ..ContactSheet::default() };
//! assert!(sheet.draw()?.width() > 60);
//! # Ok::<(), PictureError>(())
//! ```
//!
//! Out of scope: files, a console, and what the library measures: the input is values and figures, the
//! output is pictures and text. Programs use this crate, no library does; so the clock is here.

mod artist;
mod clocks;
mod contact_sheet;
mod crowd;
mod crowd_plots;
mod crowd_spacing;
pub mod demo;
mod face_pictures;
mod face_sheet;
mod facet_sheet;
mod method_lines;
mod method_plots;
mod motion_sheet;
mod paint;
mod plot;
mod scene_picture;
mod shape_sheet;
mod skeleton;
mod thin;
mod trace_plots;

pub use artist::{Artist, close_up, evenly_spaced_frames};
pub use clocks::{FRAME_CLOCKS, nanoseconds, thread_ns};
pub use contact_sheet::{ContactSheet, SheetCell, SheetRow, SheetTile};
pub use crowd_plots::crowd_plots;
pub use crowd_spacing::crowd_for_sizes;
pub use face_pictures::{clip_sheet, morph_target_sheet};
pub use face_sheet::{FaceMark, face_sheet};
pub use facet_sheet::{FacetRow, UsedAt, facet_sheet};
pub use method_lines::{lines_by_distance, lines_by_method};
pub use method_plots::{
    cost_plots, error_plot, gain_plot, path_plots, schedule_plots, updates_plot,
};
pub use motion_sheet::{MotionLine, camera_path_sheet, motion_sheet, rest_sheet};
pub use plot::{
    BarSeries, Plot, PlotOptions, Scale, Series, ValueFormat, bar_plot, line_plot, stacked,
};
pub use scene_picture::scene_picture;
pub use skeleton::{JointMark, draw_skeleton, influencing_joints};
pub use trace_plots::trace_plot;
