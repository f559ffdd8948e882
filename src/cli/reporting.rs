//! Output options of long commands (`--quiet`, `--progress`, `--log`), and what Ctrl-C does.

use std::{
    fs::{File, OpenOptions},
    io::{Read, Write},
    path::{Path, PathBuf},
    sync::{
        Arc, Once, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
};

use clap::Args;
use env_logger::{Builder, Target};
use kinetostat::{
    files::{Foreign, check_may_replace, remove_unfinished, visible},
    input::error::{Error, Result},
    page::PAGE,
};
use log::LevelFilter;
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag::{register, register_conditional_shutdown},
};

use super::progress::{Form, Progress};

/// Options of commands that compute for long.
#[derive(Debug, Args)]
pub struct Reporting {
    /// Print nothing but errors and what --progress json asks for
    #[arg(long, short)]
    quiet: bool,
    /// Print everything the answer says, and every file that was written
    #[arg(long, short, conflicts_with = "quiet")]
    verbose: bool,
    /// How progress is shown on standard error
    #[arg(long, value_enum, default_value = "auto")]
    progress: Form,
    /// Append what happens, with the time, to this file
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
}

impl Reporting {
    /// Opens the log file, if one is requested.
    pub fn start_log(&self) -> Result<()> {
        let Some(file) = &self.log else { return Ok(()) };
        check_may_replace(file, Foreign::Kept, || is_log(file))?;
        let opened = OpenOptions::new().create(true).append(true).open(file);
        let opened = opened.map_err(|source| Error::Write { file: file.clone(), source })?;
        let mut builder = Builder::new();
        builder.filter_level(LevelFilter::Info).target(Target::Pipe(Box::new(opened))).format(|out, record| {
            let message = record.args().to_string();
            writeln!(out, "[{} {:<5}] {}", out.timestamp(), record.level(), visible(&message))
        });
        builder.try_init().map_err(|error| Error::argument("--log", error.to_string()))?;
        let text = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
        log::info!("kinetostat {}: {}", env!("CARGO_PKG_VERSION"), text.collect::<Vec<_>>().join(" "));
        Ok(())
    }

    /// Prints `text` unless the command is quiet.
    pub fn print(&self, text: &str) -> Result<()> {
        if self.quiet { Ok(()) } else { super::print(text) }
    }

    /// Prints `text`, already visible, with its styles, unless the command is quiet.
    pub fn print_styled(&self, text: &str) -> Result<()> {
        if self.quiet { Ok(()) } else { super::print_styled(text) }
    }

    /// Returns whether everything is to be printed.
    pub fn is_verbose(&self) -> bool {
        self.verbose
    }

    /// Prints where `files` were written: each of them if verbose, else the folder `out` and its page, if it has one.
    pub fn print_written(&self, out: &Path, files: &[PathBuf], has_page: bool) -> Result<()> {
        let shown = out.display();
        self.print(&match (self.verbose, has_page) {
            (true, _) => {
                let names = files.iter().filter_map(|path| path.file_name());
                let names: String = names.map(|name| format!("  {}\n", name.to_string_lossy())).collect();
                format!("Written to {shown}:\n{names}")
            }
            (false, true) => format!("Results in {shown}, to read as {}\n", out.join(PAGE).display()),
            (false, false) => format!("Results in {shown}\n"),
        })
    }

    /// Returns whether the command was already stopped, and prints that.
    pub fn is_stopped(&self) -> Result<bool> {
        let is_stopped = stop_flag()?.load(Ordering::Relaxed);
        if is_stopped {
            self.print("Stopped before anything was computed.\n")?;
        }
        Ok(is_stopped)
    }

    /// Starts the progress of `total` items called `of`.
    pub fn progress(&self, study: &str, total: usize, of: &str) -> Arc<Progress> {
        let form = if self.quiet && self.progress == Form::Auto { Form::None } else { self.progress };
        Arc::new(Progress::start(form, self.quiet, study, total, of))
    }
}

/// Returns whether `file` is empty or begins as a log of this program does.
fn is_log(file: &Path) -> bool {
    let is_ours = |line: &str| line.is_empty() || line.starts_with('[') && line.contains("] kinetostat ");
    begin_of(file, 200).is_ok_and(|line| is_ours(&line))
}

/// Returns the text of the first bytes of `file`, `most` of them.
pub(super) fn begin_of(file: &Path, most: u64) -> std::io::Result<String> {
    let mut begin = Vec::new();
    File::open(file)?.take(most).read_to_end(&mut begin)?;
    Ok(String::from_utf8_lossy(&begin).into_owned())
}

/// Returns the flag that Ctrl-C or SIGTERM sets, registered at the first call; a second signal ends the program at once. SIGHUP is not handled:
/// `nohup` keeps a run going.
pub fn stop_flag() -> Result<Arc<AtomicBool>> {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    if let Some(stop) = STOP.get() {
        return Ok(Arc::clone(stop));
    }
    let stop = Arc::<AtomicBool>::default();
    for signal in [SIGINT, SIGTERM] {
        // In this order: a signal ends the program only if one before has set the flag.
        register_conditional_shutdown(signal, super::STOPPED.into(), Arc::clone(&stop))
            .and_then(|_| register(signal, Arc::clone(&stop)))
            .map_err(|error| Error::argument("Ctrl-C", error.to_string()))?;
    }
    Ok(Arc::clone(STOP.get_or_init(|| stop)))
}

/// Whether the first signal ends the program.
static ENDS_AT_ONCE: AtomicBool = AtomicBool::new(false);

/// How often is looked for a signal.
const HEEDED: std::time::Duration = std::time::Duration::from_millis(10);

/// Makes the first signal end the program: in a command that cannot be resumed, and while inputs are read. What it has not finished is removed.
pub fn stop_at_once() -> Result<()> {
    static WATCH: Once = Once::new();
    let stop = stop_flag()?;
    if stop.load(Ordering::SeqCst) {
        return Err(Error::Stopped);
    }
    ENDS_AT_ONCE.store(true, Ordering::SeqCst);
    // A handler of signals may do next to nothing itself.
    WATCH.call_once(|| {
        std::thread::spawn(move || {
            while !(stop.load(Ordering::SeqCst) && ENDS_AT_ONCE.load(Ordering::SeqCst)) {
                std::thread::sleep(HEEDED);
            }
            remove_unfinished();
            super::fail("stopped");
            std::process::exit(super::STOPPED.into())
        });
    });
    Ok(())
}

/// Makes the first signal ask to stop, as what follows heeds it, and would leave files.
pub fn heed_stops() {
    ENDS_AT_ONCE.store(false, Ordering::SeqCst);
}
