//! `kinetostat report`: makes the page of results again, or one that compares several.

use std::path::{Path, PathBuf};

use clap::Args;
use kinetostat::{
    files::{Foreign, OutputFile, check_may_replace, prepare_beside, write_beside},
    input::error::{Error, Result},
    page::{GENERATOR, PAGE, ResultFolder, comparison, page},
    questions::page_kind,
};

use super::{Ending, headline::headline_text, print, print_styled, reporting::begin_of};

/// Make the page of a result folder again, or one page that compares several. Computes nothing.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat report results/01_workspace_map                    (writes results/01_workspace_map/report.html)
  kinetostat report results/01_workspace_map /tmp/stiffer_feet  (writes comparison.html)
  kinetostat report before after --out before_and_after.html --tolerance 0.05

Results that are compared must be of one kind: two machines, two processes, before and after a change. The page says which
is better where and by how much, whether that matters, and what differs in machine, process and study, key by key.")]
pub struct ReportArguments {
    /// Result folders as written by `kinetostat run`; the first is what the others are held against
    #[arg(required = true)]
    pub(super) results: Vec<PathBuf>,
    /// Page to write [default: report.html in the folder, or comparison.html here for several folders]
    #[arg(long)]
    pub(super) out: Option<PathBuf>,
    /// Replace the page even if it was not written by kinetostat
    #[arg(long)]
    pub(super) force: bool,
    /// From which difference on one matters, mm; for several folders [default: tolerance_mm of their studies]
    #[arg(long, value_name = "MM", value_parser = super::number)]
    pub(super) tolerance: Option<f64>,
}

/// Runs `kinetostat report`: writes the page of one result folder, or one that compares several.
pub fn report(arguments: &ReportArguments) -> Result<Ending> {
    super::check_tolerance(arguments.tolerance)?;
    if arguments.tolerance.is_some() && arguments.results.len() < 2 {
        return Err(Error::argument("--tolerance", "is for the comparison of several result folders, got one"));
    }
    let folders =
        arguments.results.iter().map(|path| ResultFolder::open(path, page_kind)).collect::<Result<Vec<_>>>()?;
    let out = match (&arguments.out, folders.as_slice()) {
        (Some(out), _) => out.clone(),
        (None, [folder]) => folder.path.join(PAGE),
        (None, _) => PathBuf::from("comparison.html"),
    };
    write_page(&out, arguments.force, || match folders.as_slice() {
        [folder] => page(folder, &out),
        several => {
            let found = comparison(several, &out, arguments.tolerance)?;
            found.headline.map_or(Ok(()), |headline| print_styled(&headline_text(&headline)))?;
            Ok(found.page)
        }
    })
}

/// Writes the page that `make` returns as `out`, in place of a page of this program, or of anything with `--force`.
pub(super) fn write_page(out: &Path, force: bool, make: impl FnOnce() -> Result<String>) -> Result<Ending> {
    let (name, _lock) = prepare_beside(out)?;
    let is_page = || begin_of(out, 1024).is_ok_and(|begin| begin.contains(GENERATOR));
    check_may_replace(out, Foreign::forced(force), is_page)?;
    write_beside(out, vec![OutputFile::new(name, make()?)])?;
    print(&format!("Written to {}\n", out.display()))?;
    Ok(Ending::Complete)
}
