//! Pictures and plots for reports.
//!
//! - [`line_plot`], [`bar_plot`]: plots as SVG text; [`stacked`]: several [`Plot`]s in one
//! - [`ContactSheet`]: small pictures on one page, in labelled rows and columns
//! - [`Artist`]: renders one character, lit, with joint marks ([`JointMark`]); [`close_up`]:
//!   renders a part of it
//! - [`draw_skeleton`]: draws joints over an existing picture; [`influencing_joints`]: selects the joints
//!   that move vertices
//! - [`face_sheet`]: a face with its feature points
//! - [`shape_sheet`]: the shapes of a face
//! - [`facet_sheet`]: a mesh at several choices of levels, every triangle visible
//! - [`CrowdPicture`]: renders a crowd, coloured by level
//! - [`motion_sheet`], [`camera_path_sheet`], [`rest_sheet`]: a clip under motion level of detail
//!   next to the original clip
//! - [`evenly_spaced_frames`]: the frames of a clip that a sheet shows
//!
//! ```
//! use articula_flat::{Picture, PictureError};
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
//! Out of scope: files, a console, the text of reports, and measuring: the input is values and
//! evaluated clips, the output is pictures and text. Programs use this crate, no library does.

mod artist;
mod contact_sheet;
mod crowd;
mod face_sheet;
mod facet_sheet;
mod motion_sheet;
mod paint;
mod plot;
mod shape_sheet;
mod skeleton;

pub use artist::{Artist, close_up, evenly_spaced_frames};
pub use contact_sheet::{ContactSheet, SheetCell, SheetRow, SheetTile};
pub use crowd::CrowdPicture;
pub use face_sheet::{FaceMark, face_sheet};
pub use facet_sheet::{FacetRow, facet_sheet};
pub use motion_sheet::{MotionLine, camera_path_sheet, motion_sheet, rest_sheet};
pub use plot::{
    BarSeries, Plot, PlotOptions, Scale, Series, ValueFormat, bar_plot, line_plot, stacked,
};
pub use shape_sheet::{FaceShape, shape_sheet};
pub use skeleton::{JointMark, draw_skeleton, influencing_joints};
