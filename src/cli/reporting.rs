//! What a long command tells while it runs and where.

use std::{
    fs::OpenOptions,
    io::Write,
    path::PathBuf,
    sync::{Arc, OnceLock, atomic::AtomicBool},
};

use clap::Args;
use env_logger::{Builder, Target};
use kinetostat::{
    error::{Error, Result},
    report::visible,
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
    /// How progress is shown on standard error
    #[arg(long, value_enum, default_value = "auto")]
    progress: Form,
    /// Append what happens, with the time, to this file
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
}

impl Reporting {
    /// Opens the log, if there is to be one.
    pub fn start_log(&self) -> Result<()> {
        let Some(file) = &self.log else { return Ok(()) };
        let opened = OpenOptions::new().create(true).append(true).open(file);
        let opened = opened.map_err(|source| Error::Write { file: file.clone(), source })?;
        let mut builder = Builder::new();
        builder.filter_level(LevelFilter::Info).target(Target::Pipe(Box::new(opened))).format(|out, record| {
            let message = record.args().to_string();
            writeln!(out, "[{} {:<5}] {}", out.timestamp(), record.level(), visible(&message))
        });
        builder.try_init().map_err(|error| Error::Argument { argument: "--log".into(), problem: error.to_string() })?;
        let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
        log::info!("kinetostat {}: {}", env!("CARGO_PKG_VERSION"), words.collect::<Vec<_>>().join(" "));
        Ok(())
    }

    /// Prints `text`, unless the command is to be quiet.
    pub fn print(&self, text: &str) -> Result<()> {
        if self.quiet { Ok(()) } else { super::print(text) }
    }

    /// The progress of `total` items called `of`.
    pub fn progress(&self, study: &str, total: usize, of: &'static str) -> Arc<Progress> {
        let form = if self.quiet && self.progress == Form::Auto { Form::None } else { self.progress };
        Arc::new(Progress::start(form, study, total, of))
    }
}

/// A flag that Ctrl-C, or a polite request to end, sets; a second one ends the program at once. A hang-up is left alone: a
/// run that is begun with `nohup` goes on.
pub fn stop_flag() -> Result<Arc<AtomicBool>> {
    static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    if let Some(flag) = FLAG.get() {
        return Ok(Arc::clone(flag));
    }
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: a signal ends the program only if one before has set the flag.
        let ending = register_conditional_shutdown(signal, super::STOPPED.into(), Arc::clone(&flag));
        ending
            .and_then(|_| register(signal, Arc::clone(&flag)))
            .map_err(|error| Error::Argument { argument: "Ctrl-C".into(), problem: error.to_string() })?;
    }
    Ok(Arc::clone(FLAG.get_or_init(|| flag)))
}
