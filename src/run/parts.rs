//! Studies in parts that several machines compute, each into a file or into memory, and merged into the results of a single run.

use std::{
    io::{BufWriter, ErrorKind, Write},
    path::{Path, PathBuf},
    sync::{Arc, atomic::AtomicBool},
};

use serde::{Deserialize, Serialize};

use super::{FinishedRun, RunOptions, Start, open_checkpoint, protect_unfinished_run};
use crate::{
    files::{OutputFile, PartialFile, lock_folder, prepare, prepare_beside, remove, temporary_beside, write_beside},
    input::error::{Error, Result},
    questions::{Overrides, Study},
    work::{
        Event, Work,
        checkpoint::{Checkpoint, Origin},
        if_this_shard,
        part_file::{Part, PartHead, PartSource, Parts},
        share::Share,
    },
};

/// Place of the study of a part, and what was changed in it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StudySource {
    /// The folder or file.
    pub study: PathBuf,
    /// What was changed in it.
    pub overrides: Overrides,
}

impl StudySource {
    /// Returns where the study of `part` is found; `None` if the part does not say.
    ///
    /// # Errors
    /// The text in its head cannot be read.
    pub fn of(part: &Part) -> Result<Option<Self>> {
        let opened = &part.head().opened;
        if opened.is_empty() {
            return Ok(None);
        }
        serde_json::from_str(opened).map(Some).map_err(|fault| unreadable_text(&fault))
    }

    /// Returns the source as JSON text, for the head of a part.
    fn to_json(&self) -> Result<String> {
        serde_json::to_string(self).map_err(|fault| unreadable_text(&fault))
    }
}

/// Returns the error that a study's name or settings are no readable text.
fn unreadable_text(fault: &serde_json::Error) -> Error {
    let problem = format!("expected the name of a study and its settings in letters that can be read: {fault}");
    Error::argument("study of a part", problem)
}

/// How a part is computed into a folder.
#[derive(Debug, Clone)]
pub struct PartOptions {
    /// What becomes of an unfinished run of the same part in the folder.
    pub begin: Start,
    /// As in [`RunOptions`].
    pub program: Option<String>,
    /// Where whoever merges the parts finds the study.
    pub opened: StudySource,
    /// Which round, from 1; later ones than the first go on from all parts of the rounds before, which are in the folder.
    pub round: u32,
}

/// A part computed into a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartInFolder {
    /// Its file.
    pub file: PathBuf,
    /// Whether it was there before.
    pub was_there: bool,
    /// Whether nothing is left to other parts or a later round.
    pub is_complete: bool,
}

/// Ending of the names of files of parts.
const PART: &str = "kpart";
/// Ending of the names of what an unfinished part has computed.
const STATE: &str = "state";

/// Reads all parts in `folder`, in the order of their names.
///
/// # Errors
/// It cannot be read, a file in it that is called like one is no part or not whole, or there is none.
pub fn read_parts(folder: &Path) -> Result<Vec<Part>> {
    let parts = part_files_in(folder)?.into_iter().map(|file| Part::read(PartSource::File(file)));
    let parts = parts.collect::<Result<Vec<Part>>>()?;
    if parts.is_empty() {
        let problem =
            format!("has no part files (part_….{PART}): `kinetostat run STUDY --part 1/3 --out FOLDER` writes them");
        return Err(Error::argument(folder.display().to_string(), problem));
    }
    Ok(parts)
}

/// Removes all parts in `folder`, and the folder if nothing else is in it.
///
/// # Errors
/// It cannot be read, or a part cannot be removed.
pub fn remove_parts(folder: &Path) -> Result<()> {
    part_files_in(folder)?.iter().try_for_each(|file| remove(file))?;
    lock_folder(folder).map(drop)?;
    match std::fs::remove_dir(folder) {
        Err(source) if source.kind() != ErrorKind::DirectoryNotEmpty => {
            Err(Error::Write { file: folder.to_path_buf(), source })
        }
        _ => Ok(()),
    }
}

/// Returns the paths of the files in `folder` that are named like parts, sorted.
fn part_files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let fault = |source| Error::Read { file: folder.to_path_buf(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        if path.extension().is_some_and(|ending| ending == PART) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

impl Study {
    /// Computes the part that `share` holds, as bytes. `before` are all parts of earlier rounds, or their [excerpt](Study::excerpt), of a study that
    /// [goes in rounds](crate::StudyKind::goes_in_rounds); `program` as in [`RunOptions`]. It is computed on the current rayon pool; whoever sets
    /// `stop` stops it, and `watch` is told how far it is. The bytes do not depend on the number of threads.
    ///
    /// # Errors
    /// [`Error::Stopped`], parts of something else, and those of the work.
    pub fn part(
        &self,
        share: Share,
        before: Vec<Part>,
        program: Option<&str>,
        stop: Arc<AtomicBool>,
        watch: impl Fn(Event) + Send + Sync + 'static,
    ) -> Result<Vec<u8>> {
        let origin = Origin::of(program, self.inputs.clone())?;
        let before = if before.is_empty() { None } else { Some(Parts::before(before, &origin)?) };
        before.as_ref().map_or(Ok(()), |before| check_same_division(before, share))?;
        let mut head = self.part_head(&origin, share, before.as_ref().map_or(1, |parts| parts.rounds() + 1));
        let checkpoint = Some(Checkpoint::unnamed(&origin)?);
        let work = Work::with_parts(checkpoint, before, Some(share), stop, Box::new(watch));
        head.is_complete = if_this_shard(self.kind.compute(&work))?.is_some();
        let mut bytes = Vec::new();
        work.write_part(head, &mut bytes)?;
        Ok(bytes)
    }

    /// Returns what the next round needs of `parts`, all parts of the rounds so far, as bytes: those of its parts are the same as from all of them.
    ///
    /// # Errors
    /// [`Error::Stopped`], parts of something else, and those of the work.
    pub fn excerpt(&self, parts: Vec<Part>, program: Option<&str>, stop: Arc<AtomicBool>) -> Result<Vec<u8>> {
        let origin = Origin::of(program, self.inputs.clone())?;
        let parts = Parts::new(parts, &origin)?;
        let share = Share::new(1, parts.part_count()).map_err(|problem| Error::argument("parts", problem))?;
        let head = PartHead { is_excerpt: true, ..self.part_head(&origin, share, parts.rounds()) };
        let work = Work::replay(parts, stop);
        if_this_shard(self.kind.compute(&work))?;
        let mut bytes = Vec::new();
        work.write_excerpt(head, &mut bytes)?;
        Ok(bytes)
    }

    /// Computes a part as [`Study::part`] does, into a file in the folder `out`, where finished pieces are kept, so that it can be stopped and gone
    /// on with. A part that is there already is not computed again, unless it is to begin anew.
    ///
    /// # Errors
    /// As [`Study::part`]; what cannot be read or written; an unfinished run of the part that is not to be gone on with; a part
    /// of something else in its place.
    pub fn part_into(
        &self,
        share: Share,
        out: &Path,
        options: &PartOptions,
        stop: Arc<AtomicBool>,
        watch: impl Fn(Event) + Send + Sync + 'static,
    ) -> Result<PartInFolder> {
        let origin = Origin::of(options.program.as_deref(), self.inputs.clone())?;
        let stem = share.stem(options.round);
        let (file, state) = (out.join(format!("{stem}.{PART}")), out.join(format!("{stem}.{STATE}")));
        prepare(out)?;
        if options.begin != Start::Restart && file.exists() {
            let part = Part::read(PartSource::File(file.clone()))?;
            part.check(&origin)?;
            if (part.head().share, part.head().round) != (share, options.round) {
                let problem =
                    format!("is part {}, expected part {share}: remove it, or choose another folder", part.text());
                return Err(Error::argument(file.display().to_string(), problem));
            }
            return Ok(PartInFolder { file, was_there: true, is_complete: part.head().is_complete });
        }
        let before = parts_before(out, options.round, share, &origin)?;
        prepare_beside(&file).map(drop)?;
        protect_unfinished_run(&state, &origin, options.begin)?;
        let checkpoint = open_checkpoint(&state, &origin, options.begin)?;
        let resumed = Event::Resumed { pieces: checkpoint.len(), lost: checkpoint.damaged_count() };
        let work = Work::with_parts(Some(checkpoint), before, Some(share), stop, Box::new(watch));
        work.tell(resumed);
        let mut head = self.part_head(&origin, share, options.round);
        head.opened = options.opened.to_json()?;
        match if_this_shard(self.kind.compute(&work)) {
            Ok(result) => head.is_complete = result.is_some(),
            Err(error) => {
                if work.pieces() == 0 {
                    remove(&state)?;
                }
                return Err(error);
            }
        }
        let is_complete = head.is_complete;
        write_file(&file, |to| work.write_part(head, to))?;
        remove(&state)?;
        Ok(PartInFolder { file, was_there: false, is_complete })
    }

    /// Writes `part`, the bytes of one that [`Study::part`] has computed, into a file in the folder `out`, whole or not at all.
    ///
    /// # Errors
    /// It is no part of this study by the build that `program` names, as in [`RunOptions`]; the file cannot be written.
    pub fn keep_part(&self, part: &[u8], out: &Path, program: Option<&str>) -> Result<Part> {
        let kept = Part::read(PartSource::Bytes("a part that was computed".into(), part.into()))?;
        kept.check(&Origin::of(program, self.inputs.clone())?)?;
        prepare(out)?;
        let file = out.join(format!("{}.{PART}", kept.head().share.stem(kept.head().round)));
        write_file(&file, |to| to.write_all(part).map_err(|source| Error::Write { file: file.clone(), source }))?;
        Ok(kept)
    }

    /// Reads all parts in the folder `out`, none if there is no such folder.
    ///
    /// # Errors
    /// It cannot be read; a file that is called like a part and is none of this study by the build that `program` names, or not whole.
    pub fn kept_parts(&self, out: &Path, program: Option<&str>) -> Result<Vec<Part>> {
        if !out.exists() {
            return Ok(Vec::new());
        }
        let origin = Origin::of(program, self.inputs.clone())?;
        let read = |file| {
            let part = Part::read(PartSource::File(file))?;
            part.check(&origin).map(|()| part)
        };
        part_files_in(out)?.into_iter().map(read).collect()
    }

    /// Merges all `parts` of one division, in any order, into results in the folder `out`, as [`Study::run_into`] writes them. Rounds that the
    /// parts do not contain yet are computed here. The results are those of a single run, byte for byte.
    ///
    /// # Errors
    /// As [`Study::run_into`]; parts of other inputs or of another build, parts that are missing or there twice.
    pub fn merge_into(
        &self,
        parts: Vec<Part>,
        out: &Path,
        options: &RunOptions,
        stop: Arc<AtomicBool>,
        watch: impl Fn(Event) + Send + Sync + 'static,
    ) -> Result<FinishedRun> {
        self.prepare_run(out, options)?.begin_from(parts)?.run(stop, watch)
    }

    /// Returns the head of a part of this study; not complete and without pieces yet.
    fn part_head(&self, origin: &Origin, share: Share, round: u32) -> PartHead {
        PartHead {
            program: origin.program.clone(),
            inputs: origin.inputs.digests(),
            study: self.name.clone(),
            opened: String::new(),
            share,
            round,
            is_complete: false,
            is_excerpt: false,
            pieces: 0,
        }
    }
}

/// Returns all parts in `out` of the rounds before `round`; `None` for the first round. An error if a round is missing.
fn parts_before(out: &Path, round: u32, share: Share, origin: &Origin) -> Result<Option<Parts>> {
    if round == 1 {
        return Ok(None);
    }
    let parts = read_parts(out)?.into_iter().filter(|part| part.head().round < round);
    let parts = Parts::new(parts.collect(), origin)?;
    if parts.rounds() + 1 != round {
        let next = parts.rounds() + 1;
        let problem = format!("expected {next} or an earlier round, got {round}: the rounds before are not there");
        return Err(Error::argument("round", problem));
    }
    check_same_division(&parts, share)?;
    Ok(Some(parts))
}

/// Returns an error if `share` is of another number of parts than in the rounds before.
fn check_same_division(before: &Parts, share: Share) -> Result<()> {
    let of = before.part_count();
    let fault = || Error::argument("part", format!("expected one of {of} parts, as in the rounds before, got {share}"));
    if of == share.of() { Ok(()) } else { Err(fault()) }
}

/// Writes `file` with the function `write`, whole or not at all, in place of what was there.
fn write_file(file: &Path, write: impl FnOnce(&mut BufWriter<PartialFile>) -> Result<()>) -> Result<()> {
    let fault = |source| Error::Write { file: file.to_path_buf(), source };
    let (name, _lock) = prepare_beside(file)?;
    let mut writer = BufWriter::new(temporary_beside(file).map_err(fault)?);
    write(&mut writer)?;
    let finished = writer.into_inner().map_err(|e| fault(e.into_error()))?;
    finished.file.sync_all().map_err(fault)?;
    write_beside(file, vec![OutputFile::from_temporary(name, finished)])
}
