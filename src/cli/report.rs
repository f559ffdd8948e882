//! `kinetostat report`: makes the page of results again, or one that compares several.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use clap::Args;
use kinetostat::{
    input::error::Result,
    report::{
        Manifest, OutputFile, may_replace,
        page::{GENERATOR, PAGE, ResultFolder, comparison, page},
        prepare_beside, write_beside,
    },
};

use super::{Ending, print};

/// Make the page of a result folder again, or one page that compares several. Computes nothing.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat report results/01_workspace_map                    (writes results/01_workspace_map/report.html)
  kinetostat report results/01_workspace_map /tmp/stiffer_feet  (writes comparison.html)
  kinetostat report before after --out before_and_after.html

Results that are compared must be of one kind: two machines, two processes, before and after a change. The page shows
them at the same colour scales, their differences, all quantities side by side with ratios, and which is better where.")]
pub struct ReportArguments {
    /// Result folders as written by `kinetostat run`; the first is what the others are held against
    #[arg(required = true)]
    results: Vec<PathBuf>,
    /// Page to write [default: report.html in the folder, or comparison.html here for several folders]
    #[arg(long)]
    out: Option<PathBuf>,
}

pub fn report(arguments: &ReportArguments) -> Result<Ending> {
    let folders = arguments.results.iter().map(|path| ResultFolder::open(path)).collect::<Result<Vec<_>>>()?;
    let out = match (&arguments.out, folders.as_slice()) {
        (Some(out), _) => out.clone(),
        (None, [folder]) => folder.path.join(PAGE),
        (None, _) => PathBuf::from("comparison.html"),
    };
    let name = prepare_beside(&out)?;
    may_replace(&out, || is_page(&out))?;
    let html = match folders.as_slice() {
        [folder] => page(folder, &out)?,
        several => comparison(several, &out)?,
    };
    write_beside(&out, vec![OutputFile::new(name, html)])?;
    print(&format!("Written to {}\n", out.display()))?;
    Ok(Ending::Complete)
}

/// Whether `file` is a page that this program wrote: it says so, or the manifest beside it does.
pub(super) fn is_page(file: &Path) -> bool {
    let mut begin = Vec::new();
    let read = File::open(file).and_then(|file| file.take(1024).read_to_end(&mut begin));
    let says_so = read.is_ok() && String::from_utf8_lossy(&begin).contains(GENERATOR);
    let is_listed = || {
        let folder = file.parent().unwrap_or(Path::new("."));
        file.file_name().is_some_and(|name| name == PAGE && Manifest::files_in(folder).iter().any(|own| own == PAGE))
    };
    says_so || is_listed()
}
