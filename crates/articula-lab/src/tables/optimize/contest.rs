//! The files of one character, and the fair ones among those of the peers.

use crate::peers::optimisers::{self, Judge, Judged, Shown};
use anyhow::{Context, Result, ensure};
use articula::Executor;
use articula::optimize::{
    Compression, ErrorBound, OptimizeOptions, TextureFormat, TextureOptions, optimize,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Lines of the picture that the figure at rest fills.
pub(super) const HEIGHT_PX: f64 = 720.0;
/// Errors in pixels: the greatest that ours is asked for, and that of a peer whose motion is not broken.
pub(super) const MOST_ASKED_PX: f64 = 1.0;
pub(super) const MOST_FAIR_PX: f64 = 2.0;
/// The same of surfaces with fewer triangles: what is beyond it is another figure.
pub(super) const MOST_OF_SURFACES_PX: f64 = 5.0;
/// Greatest error of a source beside itself, of its height: distances to its own surface are rounded.
const ROUNDING: f64 = 1e-6;

/// What is compared.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// A character with all its triangles.
    Whole,
    /// Clips alone, which the character of a file plays.
    Clips(PathBuf),
    /// A character with a part of its triangles, as the peers are asked for it.
    Fewer(&'static str),
}

impl Kind {
    fn judge(&self) -> Judge<'_> {
        match self {
            Self::Whole => Judge::Vertices,
            Self::Clips(skin) => Judge::VerticesOf(skin),
            Self::Fewer(_) => Judge::Surfaces,
        }
    }

    /// The part of the triangles that peers are asked for.
    pub(super) fn part(&self) -> Option<&'static str> {
        match self {
            Self::Fewer(part) => Some(part),
            Self::Whole | Self::Clips(_) => None,
        }
    }

    /// The greatest error of a peer that counts, and the greatest that ours is asked for, in pixels.
    fn most_px(&self) -> [f64; 2] {
        match self {
            Self::Whole | Self::Clips(_) => [MOST_FAIR_PX, MOST_ASKED_PX],
            Self::Fewer(_) => [MOST_OF_SURFACES_PX; 2],
        }
    }
}

/// A file of a contestant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entrant {
    pub(super) who: String,
    pub(super) setting: String,
    /// Whether it needs KHR_meshopt_compression.
    pub(super) is_khr: bool,
    /// The error that was asked for, of ours.
    pub(super) asked_mm: Option<f64>,
    /// Bytes of the whole file.
    pub(super) file_bytes: usize,
    /// `None` without a judge.
    pub(super) judged: Option<Judged>,
    /// How Babylon.js shows it, of ours; `None` without a judge.
    pub(super) shown: Option<Shown>,
}

impl Entrant {
    /// Bytes without pictures.
    pub(super) fn bytes(&self) -> Option<usize> {
        self.judged.as_ref().map(|j| j.bytes)
    }

    pub(super) fn brotli(&self) -> Option<usize> {
        self.judged.as_ref().map(|j| j.brotli)
    }

    pub(super) fn error_mm(&self) -> Option<f64> {
        self.judged.as_ref().and_then(|j| j.error_mm)
    }

    /// Greatest distance of a vertex between Babylon.js and three.js, of ours; not a number if it cannot be read.
    pub(super) fn apart_mm(&self) -> Option<f64> {
        let shown = self.shown.as_ref()?;
        Some(shown.apart_mm.unwrap_or(f64::NAN))
    }

    /// The error in pixels.
    pub(super) fn error_px(&self) -> Option<f64> {
        let judged = self.judged.as_ref()?;
        Some(judged.error_mm? * HEIGHT_PX / judged.height_mm)
    }
}

/// All files of one character, or of one library of clips.
#[derive(Debug, Clone)]
pub(super) struct Contest {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    /// Bytes of the source.
    pub(super) source_bytes: usize,
    /// The source; `None` without a judge.
    pub(super) source: Option<Judged>,
    pub(super) peers: Vec<Entrant>,
    /// Peers without a file, and why.
    pub(super) faults: Vec<(String, String)>,
    /// Ours with EXT_meshopt_compression, and with KHR_meshopt_compression.
    pub(super) ours: Vec<Entrant>,
}

impl Contest {
    /// Writes and judges all files of a character, or of clips.
    pub(super) fn run(
        name: &'static str,
        path: &Path,
        kind: Kind,
        has_peers: bool,
    ) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let source = folder.path().join("source.glb");
        std::fs::copy(path, &source).with_context(|| path.display().to_string())?;
        let mut contest = Self {
            name,
            kind,
            source_bytes: std::fs::metadata(&source)?.len() as usize,
            source: None,
            peers: Vec::new(),
            faults: Vec::new(),
            ours: Vec::new(),
        };
        if has_peers {
            contest.add_peers(&source, folder.path())?;
        }
        // With fewer triangles all contestants are beside the smallest alone, whatever it needs.
        let extensions = match contest.kind {
            Kind::Fewer(_) => &[true][..],
            Kind::Whole | Kind::Clips(_) => &[false, true],
        };
        for &is_khr in extensions {
            let ours = contest.ours(path, &source, folder.path(), is_khr)?;
            contest.ours.push(ours);
        }
        Ok(contest)
    }

    fn add_peers(&mut self, source: &Path, folder: &Path) -> Result<()> {
        let written = optimisers::files(source, folder, self.kind.part())?;
        let mut paths = vec![source];
        paths.extend(written.iter().filter_map(|peer| peer.file.as_deref()));
        let mut judged = optimisers::judged(self.kind.judge(), source, &paths)?.into_iter();
        self.source = judged.next();
        let own = self.source.as_ref();
        let own = own.and_then(|own| Some(own.error_mm? / own.height_mm));
        let is_same = own.is_some_and(|own| own <= ROUNDING);
        ensure!(is_same, "the source differs from itself: {own:?}");
        for peer in &written {
            let who = format!("{} {}", peer.peer, peer.setting);
            let Some(file) = &peer.file else {
                let why = peer.fault.clone().unwrap_or_default();
                self.faults.push((who, why));
                continue;
            };
            self.peers.push(Entrant {
                who: peer.peer.clone(),
                setting: peer.setting.clone(),
                is_khr: peer.setting.contains("-cz"),
                asked_mm: None,
                file_bytes: std::fs::metadata(file)?.len() as usize,
                judged: judged.next(),
                shown: None,
            });
        }
        Ok(())
    }

    /// Ours at the error of the smallest peer, and at most the greatest that is asked for.
    fn ours(&self, path: &Path, source: &Path, folder: &Path, is_khr: bool) -> Result<Entrant> {
        let error = match (self.smallest(is_khr), &self.source) {
            (Some(peer), Some(own)) => {
                let [_, most_px] = self.kind.most_px();
                let most = most_px * own.height_mm / HEIGHT_PX;
                let asked_mm = peer.error_mm().unwrap_or(most).min(most);
                ErrorBound::Metres(1e-3 * asked_mm as f32)
            }
            _ => ErrorBound::Pixels {
                px: MOST_ASKED_PX as f32,
                height_px: HEIGHT_PX as f32,
            },
        };
        let skin = match &self.kind {
            Kind::Clips(skin) => Some(articula::fs::open(skin)?),
            Kind::Whole | Kind::Fewer(_) => None,
        };
        let options = OptimizeOptions {
            error,
            skin: skin.map(|skin| Arc::new(skin.into_character())),
            compression: match is_khr {
                true => Compression::Khr,
                false => Compression::Ext,
            },
            // Peers keep pictures too.
            simplify: matches!(self.kind, Kind::Fewer(_)),
            textures: TextureOptions {
                format: TextureFormat::Keep,
                ..TextureOptions::default()
            },
            ..OptimizeOptions::default()
        };
        let opened = articula::fs::open(path)?;
        let optimized = optimize(&opened, &options, &Executor::default())?;
        let extension = if is_khr { "KHR" } else { "EXT" };
        let file = folder.join(format!("ours-{extension}.glb"));
        std::fs::write(&file, &optimized.glb)?;
        let (judged, shown) = match self.source {
            Some(_) => (
                optimisers::judged(self.kind.judge(), source, &[&file])?.pop(),
                Some(optimisers::shown_by_babylon(&file)?),
            ),
            None => (None, None),
        };
        Ok(Entrant {
            who: "ours".into(),
            setting: extension.into(),
            is_khr,
            asked_mm: Some(f64::from(optimized.report.bound_mm)),
            file_bytes: optimized.glb.len(),
            judged,
            shown,
        })
    }

    /// Whether the motion of a peer is not broken, nor its surface another.
    pub(super) fn is_fair(&self, peer: &Entrant) -> bool {
        let [most_px, _] = self.kind.most_px();
        peer.error_px().is_some_and(|px| px <= most_px)
    }

    /// The smallest fair file of a peer; without KHR_meshopt_compression only those that do not need it.
    pub(super) fn smallest(&self, with_khr: bool) -> Option<&Entrant> {
        let all = self.peers.iter();
        let fair = all.filter(|peer| self.is_fair(peer) && (with_khr || !peer.is_khr));
        fair.min_by_key(|peer| peer.bytes())
    }

    /// Bytes of ours over those of the smallest fair file of a peer.
    pub(super) fn ratio(&self, ours: &Entrant) -> Option<f64> {
        let peer = self.smallest(ours.is_khr)?;
        Some(ours.bytes()? as f64 / peer.bytes()? as f64)
    }

    /// The same after brotli.
    pub(super) fn brotli_ratio(&self, ours: &Entrant) -> Option<f64> {
        let peer = self.smallest(ours.is_khr)?;
        Some(ours.brotli()? as f64 / peer.brotli()? as f64)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A file of some bytes, half of them after brotli, of a figure 720 mm high: a millimetre is a pixel.
    pub(in super::super) fn entrant(setting: &str, bytes: usize, error_mm: f64) -> Entrant {
        Entrant {
            who: "peer".into(),
            setting: setting.into(),
            is_khr: setting.contains("-cz"),
            asked_mm: None,
            file_bytes: bytes + 10,
            judged: Some(Judged {
                error_mm: Some(error_mm),
                height_mm: 720.0,
                bytes,
                json: bytes / 4,
                pictures: 10,
                brotli: bytes / 2,
            }),
            shown: None,
        }
    }

    pub(in super::super) fn contest() -> Contest {
        Contest {
            name: "a figure",
            kind: Kind::Whole,
            source_bytes: 1010,
            source: entrant("", 1000, 0.0).judged,
            peers: vec![
                entrant("-cz", 80, 90.0),
                entrant("-cz -af 0", 160, 1.5),
                entrant("-cc", 200, 0.5),
            ],
            faults: Vec::new(),
            ours: vec![entrant("EXT", 150, 0.5), entrant("-cz ours", 120, 0.9)],
        }
    }

    #[test]
    fn with_fewer_triangles_a_greater_error_is_fair() {
        let fewer = Contest {
            kind: Kind::Fewer("0.7"),
            peers: vec![
                entrant("-cz -si 0.7", 80, 5.5),
                entrant("-cz -af 0 -si 0.7", 90, 4.5),
                entrant("-cc -si 0.7", 100, 1.0),
            ],
            ..contest()
        };
        assert_eq!(fewer.smallest(true).unwrap().bytes(), Some(90));
    }

    #[test]
    fn broken_motion_is_no_peer_and_each_extension_has_its_own() {
        let contest = contest();
        assert_eq!(contest.smallest(true).unwrap().bytes(), Some(160));
        assert_eq!(contest.smallest(false).unwrap().bytes(), Some(200));
        assert_eq!(contest.ratio(&contest.ours[0]), Some(0.75));
        assert_eq!(contest.ratio(&contest.ours[1]), Some(0.75));
        assert_eq!(contest.brotli_ratio(&contest.ours[1]), Some(0.75));
    }
}
