//! The source itself, where nothing worth an error was saved.

use super::Optimized;
use articula_formats::gltf::has_compressed_views;

/// Share of the bytes of a file with compressed arrays above which another one is not worth its error, since
/// errors of one pass add to those of the pass before.
const AGAIN_BELOW: f64 = 0.95;

impl Optimized {
    /// The source, if it is a GLB, in place of the file that was made of it, if that is not smaller; or, of a source
    /// whose arrays were compressed before, if it is smaller by less than 5 %. So a file that is optimised
    /// again at the same error stays as it is, and no file grows. [`OptimizeReport::is_kept`] tells it, and
    /// the errors of the source are 0.
    ///
    /// [`OptimizeReport::is_kept`]: super::OptimizeReport::is_kept
    #[must_use]
    pub fn or_source(self, source: &[u8]) -> Self {
        let most = match has_compressed_views(source) {
            true => AGAIN_BELOW * source.len() as f64,
            false => source.len() as f64,
        };
        let is_glb = source.starts_with(b"glTF");
        if !is_glb || (self.glb.len() as f64) < most {
            return self;
        }
        Self {
            glb: source.to_vec(),
            report: self.report.kept(source),
        }
    }
}
