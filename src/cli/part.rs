//! `kinetostat run --part`: one part of a study, for others to be computed elsewhere.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, atomic::Ordering},
    time::Instant,
};

use kinetostat::{
    Event,
    files::counted,
    input::error::{Error, Result},
    questions::{Overrides, Study},
    run::parts::{Opened, PartInFolder, PartOptions},
    work::share::Share,
};
use serde_json::json;

use super::{
    Ending,
    reporting::stop_flag,
    results::{Computing, in_options},
};

/// A part that is asked for.
pub struct AskedPart<'a> {
    /// The study.
    pub path: &'a Path,
    pub overrides: Overrides,
    pub share: Share,
    pub round: u32,
    pub out: Option<&'a Path>,
}

/// Computes a part and leaves its file.
pub fn compute(asked: &AskedPart<'_>, computing: &Computing) -> Result<Ending> {
    let (share, round, started) = (asked.share, asked.round, Instant::now());
    let study = Study::open(asked.path, &asked.overrides).map_err(in_options)?;
    let fault = |source| Error::Read { file: asked.path.to_path_buf(), source };
    let opened = Opened { study: asked.path.canonicalize().map_err(fault)?, overrides: asked.overrides.clone() };
    if round > 1 && !study.kind.goes_in_rounds() {
        let problem = format!("expected 1, got {round}: study {} is shared in one round", study.name);
        return Err(Error::Argument { argument: "--round".into(), problem });
    }
    let out = asked.out.map_or_else(|| PathBuf::from("parts").join(&study.name), Path::to_path_buf);
    if stop_flag()?.load(Ordering::Relaxed) {
        computing.reporting.print("Stopped before anything was computed.\n")?;
        return Ok(Ending::Stopped);
    }
    let pieces = study.kind.pieces();
    // How many pieces a later round has is not known before.
    let own = if round == 1 { share.count(pieces) } else { 0 };
    let options = PartOptions { begin: computing.begin(), program: None, opened, round };
    let pool = computing.pool()?;
    let name = format!("{} part {share}", study.name);
    let progress = computing.reporting.progress(&name, own, "pieces");
    let (watcher, stop) = (Arc::clone(&progress), stop_flag()?);
    let watch = move |event| match event {
        Event::Dealt { is_kept: true } => watcher.tell(Event::Kept(1)),
        Event::Dealt { is_kept: false } => watcher.tell(Event::Computed(1)),
        Event::Resumed { .. } => watcher.tell(event),
        _ => {}
    };
    let ended = pool.install(|| study.part_into(share, &out, &options, stop, watch));
    let done = progress.end();
    match ended {
        Ok(part) => {
            let seconds = started.elapsed().as_secs_f64();
            log::info!("{name}: {done} in {seconds:.1} s, written to {}", part.file.display());
            progress.line(json!({
                "event": "finished",
                "study": study.name,
                "part": share.part(),
                "parts": share.of(),
                "round": round,
                "is_complete": part.is_complete,
                "wall_time_s": seconds,
                "threads": pool.current_num_threads(),
                "file": part.file,
            }));
            computing.reporting.print(&told(&study, asked, &out, &part, (pieces, seconds)))?;
            Ok(Ending::Complete)
        }
        Err(Error::Stopped) => computing.tell_stopped(&study, &progress, &done),
        Err(error) => {
            computing.tell_failed(&study, &progress, false, &error);
            Err(in_options(error))
        }
    }
}

/// What there is now, and what comes next.
fn told(
    study: &Study,
    asked: &AskedPart<'_>,
    out: &Path,
    part: &PartInFolder,
    (pieces, seconds): (usize, f64),
) -> String {
    let (share, round, file) = (asked.share, asked.round, part.file.display());
    if part.was_there {
        return format!("Part {share} of {} is there already: {file}. --restart computes it anew.\n", study.name);
    }
    let mut text = match round {
        1 => {
            let own = counted(share.count(pieces), "piece");
            format!("Part {share} of {}, {own} of {pieces}, in {seconds:.1} s: {file}\n", study.name)
        }
        _ => format!("Part {share} of round {round} of {} in {seconds:.1} s: {file}\n", study.name),
    };
    if pieces < share.of() as usize && round == 1 {
        text += &format!("The study has {}: more parts than that have nothing to do.\n", counted(pieces, "piece"));
    }
    text += &format!("With all {} parts: kinetostat merge {}\n", share.of(), out.display());
    if study.kind.goes_in_rounds() && !part.is_complete {
        text += &format!(
            "merge computes what comes next, too; to share that as well, first all parts with --round {}\n",
            round + 1
        );
    }
    text
}
