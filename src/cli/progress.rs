//! Progress of a long computation: a bar on a terminal, or lines of JSON for programs that watch; and the warning that hardly any point is solved.

use std::{
    io::{IsTerminal, Write},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use kinetostat::{
    files::{counted, per_second, visible, visible_json},
    work::{Event, Stage, Work},
};
use serde_json::{Value, json};

/// Form of the progress display, `--progress`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Form {
    /// A bar where standard error is a terminal
    Auto,
    /// One JSON object a line on standard error: event, study, done, not_solved, total, per_second, seconds_left
    Json,
    /// Nothing
    None,
}

/// Numbers of computed items and time after which a warning is given if this share of them has no solution: many items, or few in a long time.
const ENOUGH_TO_TELL: usize = 32;
const FEW: usize = 4;
const LONG: Duration = Duration::from_secs(3);
const HOPELESS: f64 = 0.9;

/// Time between two lines of JSON, and between two lines of the log.
const JSON_INTERVAL: Duration = Duration::from_millis(500);
const LOG_INTERVAL: Duration = Duration::from_secs(10);

/// Counts and reports the items done of a computation, or of its current stage.
pub struct Progress {
    bar: ProgressBar,
    form: Form,
    is_quiet: bool,
    study: String,
    /// Name of the items, in the plural.
    of: String,
    total: usize,
    state: Mutex<State>,
}

/// Counters of a computation and times of its reports.
struct State {
    computed: usize,
    kept: usize,
    unsolved: usize,
    /// Whether the warning that hardly any point is solved was given.
    is_warned: bool,
    /// Time from which the rate is measured, and the number of items done then.
    rate_from: (Instant, usize),
    best: Option<f64>,
    /// Stage after the first, and the number of its items done.
    stage: Option<(Stage, usize)>,
    json_at: Instant,
    logged_at: Instant,
}

impl State {
    /// Returns the number of items done, of the current stage.
    fn done(&self) -> usize {
        self.stage.map_or(self.computed + self.kept, |(_, done)| done)
    }
}

impl Progress {
    /// Starts the progress of `total` items called `of`, 0 where the number is unknown; `is_quiet` suppresses all but errors.
    pub fn start(form: Form, is_quiet: bool, study: &str, total: usize, of: &str) -> Self {
        let is_drawn = form == Form::Auto && std::io::stderr().is_terminal();
        let target = if is_drawn { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(total as u64), target);
        let bar = match bar_style(of, total > 0) {
            Some(style) => bar.with_style(style),
            None => bar,
        };
        let now = Instant::now();
        let state = Mutex::new(State {
            computed: 0,
            kept: 0,
            unsolved: 0,
            is_warned: false,
            rate_from: (now, 0),
            best: None,
            stage: None,
            json_at: now,
            logged_at: now,
        });
        let progress = Self { bar, form, is_quiet, study: study.into(), of: of.into(), total, state };
        progress.line(json!({ "event": "started", "study": study, "total": total, "of": of }));
        match total {
            0 => log::info!("{study}: {of} to compute"),
            total => log::info!("{study}: {total} {of} to compute"),
        }
        progress
    }

    /// Locks the counters.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts an event, and reports progress if it is time to.
    pub fn record(&self, event: Event) {
        let mut state = self.state();
        match event {
            Event::Computed(items) => {
                match &mut state.stage {
                    Some((_, done)) => *done += items,
                    None => state.computed += items,
                }
                self.bar.inc(items as u64);
                self.warn_if_hopeless(&mut state);
            }
            Event::Unsolved(items) => {
                state.unsolved += items;
                self.bar.set_message(format!("{} not solved", state.unsolved));
            }
            Event::Stage(stage) => {
                // What was sought before leads back to what was to be computed.
                let is_first = stage.of == self.of && stage.items == self.total;
                state.stage = (!is_first).then_some((stage, 0));
                state.rate_from = (Instant::now(), state.done());
                if let Some(style) = bar_style(stage.of, true) {
                    self.bar.set_style(style);
                }
                self.bar.set_length(stage.items as u64);
                self.bar.set_position(0);
                self.bar.reset_eta();
            }
            Event::Resumed { pieces, lost } => {
                if pieces > 0 {
                    log::info!("{}: going on with {}", self.study, counted(pieces, "piece"));
                }
                if lost > 0 {
                    let damaged = counted(lost, "damaged piece");
                    let text = format!("{}: {damaged} of the unfinished run to compute again", self.study);
                    self.warn(&text);
                    if self.form == Form::None && !self.is_quiet {
                        eprintln!("{}", visible(&text));
                    }
                }
            }
            Event::Kept(items) => {
                match &mut state.stage {
                    Some((_, done)) => *done += items,
                    None => state.kept += items,
                }
                self.bar.inc(items as u64);
                // What is taken over says nothing of the time that is left.
                self.bar.reset_eta();
                state.rate_from = (Instant::now(), state.done());
            }
            // Told of parts by whoever watches them.
            Event::Shard { .. } => {}
            Event::Stock { cell_mm, bytes } => {
                let megabytes = (bytes as f64 / 1e6).ceil();
                let text = format!("{}: the stock, in cells of {cell_mm} mm, takes at most {megabytes} MB", self.study);
                log::info!("{text}");
                match self.form {
                    Form::Auto => self.bar.suspend(|| eprintln!("{}", visible(&text))),
                    Form::Json => {
                        self.line(json!({ "event": "stock", "study": self.study, "cell_mm": cell_mm, "bytes": bytes }));
                    }
                    Form::None => {}
                }
            }
            Event::Best(best) => {
                state.best = Some(best);
                self.bar.set_message(format!("refining, best {best:.6}"));
            }
        }
        let now = Instant::now();
        let begins = matches!(event, Event::Stage(_));
        if self.form == Form::Json && (begins || now - state.json_at >= JSON_INTERVAL) {
            state.json_at = now;
            self.line(self.progress_json(&state));
        }
        if now - state.logged_at >= LOG_INTERVAL {
            state.logged_at = now;
            let report = self.progress_json(&state);
            let one_decimal = |key: &str| report[key].as_f64().map_or("?".into(), |value| format!("{value:.1}"));
            let (done, total, of) = self.done_of_total(&state);
            let (rate, seconds_left) = (one_decimal("per_second"), one_decimal("seconds_left"));
            log::info!("{}: {done} of {total} {of}, {rate} per second, {seconds_left} s left", self.study);
        }
    }

    /// Warns once, on standard error, if hardly any point is solved.
    fn warn_if_hopeless(&self, state: &mut State) {
        let (unsolved, computed) = (state.unsolved, state.computed);
        let is_slow = computed >= FEW && state.rate_from.0.elapsed() >= LONG;
        let is_hopeless = (computed >= ENOUGH_TO_TELL || is_slow) && unsolved as f64 >= HOPELESS * computed as f64;
        if state.is_warned || !is_hopeless {
            return;
        }
        state.is_warned = true;
        let text = format!("{}: {unsolved} of the first {computed} {} not solved; going on", self.study, self.of);
        self.warn(&text);
    }

    /// Writes a warning to standard error, for readers or as JSON, and to the log.
    fn warn(&self, text: &str) {
        log::warn!("{text}");
        match self.form {
            Form::Auto => self.bar.suspend(|| eprintln!("{}", visible(text))),
            Form::Json => self.line(json!({ "event": "warning", "study": self.study, "message": text })),
            Form::None => {}
        }
    }

    /// Returns items done, their total and their name in the current stage.
    fn done_of_total(&self, state: &State) -> (usize, usize, &str) {
        let (total, of) = state.stage.map_or((self.total, &*self.of), |(stage, _)| (stage.items, stage.of));
        (state.done(), total, of)
    }

    /// Returns the progress as JSON.
    fn progress_json(&self, state: &State) -> Value {
        let (done, total, of) = self.done_of_total(state);
        let (since, before) = state.rate_from;
        let (seconds, computed) = (since.elapsed().as_secs_f64(), done.saturating_sub(before));
        let rate = (computed > 0 && seconds > 0.0).then(|| computed as f64 / seconds);
        // How long a search that has no items takes is not known before.
        let is_counted = state.best.is_none() || state.stage.is_some();
        let left = rate.filter(|_| is_counted && total > 0).map(|rate| total.saturating_sub(done) as f64 / rate);
        let mut report = json!({
            "event": "progress",
            "study": self.study,
            "done": done,
            "not_solved": state.unsolved,
            "total": total,
            "of": of,
            "per_second": rate.filter(|_| is_counted),
            "seconds_left": left,
        });
        if let Some(best) = state.best {
            report["best"] = json!(best);
        }
        report
    }

    /// Returns work that reports to this progress and that nothing stops.
    pub fn work(self: &Arc<Self>) -> Work {
        let watcher = Arc::clone(self);
        Work::new(None, Arc::default(), Box::new(move |event| watcher.record(event)))
    }

    /// Ends the display; returns how many items were done of how many, in words.
    pub fn end(&self) -> String {
        self.bar.finish_and_clear();
        let state = self.state();
        self.line(self.progress_json(&state));
        let done = state.computed + state.kept;
        let first = match self.total {
            0 => format!("{done} {}", self.of),
            total => format!("{done} of {total} {}", self.of),
        };
        match state.stage {
            Some((stage, done)) => format!("{first}, then {done} of {} {}", stage.items, stage.of),
            None => first,
        }
    }

    /// Writes a line of JSON for programs that watch. A failure to write is ignored.
    pub fn line(&self, value: Value) {
        if self.form == Form::Json {
            let _ = writeln!(std::io::stderr().lock(), "{}", visible_json(&value.to_string()));
        }
    }
}

/// Returns the style of a bar of items called `of`; `is_counted` if their number is known. `None` if its template is invalid.
fn bar_style(of: &str, is_counted: bool) -> Option<ProgressStyle> {
    let style = ProgressStyle::with_template(&match is_counted {
        true => format!("{{bar:30}} {{human_pos}} of {{human_len}} {of}, {{rate}}, {{eta}} left {{msg}}"),
        false => format!("{{human_pos}} {of}, {{rate}} {{msg}}"),
    });
    let style = style.ok()?;
    Some(style.with_key("rate", |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        // A bar has nobody to tell that a line could not be made.
        let _ = out.write_str(&per_second(state.per_sec()));
    }))
}
