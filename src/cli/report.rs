//! `kinetostat report`: makes the page of results again, or one that compares several.

use std::path::{Path, PathBuf};

use clap::Args;
use kinetostat::{
    error::{Error, Result},
    report::{
        OutputFile,
        page::{ResultFolder, comparison, page},
        write_all,
    },
};

use super::{Ending, print};

/// Name of the page in a result folder.
pub const PAGE: &str = "report.html";

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
    let (out, html) = match folders.as_slice() {
        [folder] => {
            let out = arguments.out.clone().unwrap_or_else(|| folder.path.join(PAGE));
            (out.clone(), page(folder, &out)?)
        }
        several => {
            let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from("comparison.html"));
            (out.clone(), comparison(several, &out)?)
        }
    };
    let Some(name) = out.file_name() else {
        let problem = "must be the name of the page to write".into();
        return Err(Error::Argument { argument: format!("--out {}", out.display()), problem });
    };
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    write_all(folder, vec![OutputFile::new(name.to_string_lossy(), html)])?;
    print(&format!("Written to {}\n", out.display()))?;
    Ok(Ending::Complete)
}
