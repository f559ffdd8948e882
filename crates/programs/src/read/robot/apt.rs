//! APT and the CLDATA of CAM systems as text: `GOTO/x,y,z,i,j,k` and the records that set feed, units and tool.
//!
//! Followed are FROM, GOTO, GODLTA, RAPID, FEDRAT, SPINDL, UNITS, LOADTL and MULTAX, circles (`apt_circles.rs`), drilling cycles
//! (`apt_cycles.rs`), and where CAM systems say in which frame points are. Other records that do not move the tool are ignored; rotary tables
//! and the geometry of APT are refused.

use std::ops::Range;

use nalgebra::Vector3;

use crate::{
    model::robot::{
        AptCircle, AptParts, Component, CutcomPoints, Drilling, Frames, INCH_MM, MotionKind, Number, RobotFault,
        RobotOptions, Statement, Target,
    },
    read::{
        robot::{LineCursor, LocatedFault, trimmed},
        scan::Scan,
    },
};

/// Bytes of a record, its first line, and its text.
type Record = (Range<usize>, usize, Vec<u8>);

/// Unit of a feed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FeedUnit {
    /// mm/min per unit.
    PerMinute(f64),
    /// mm per spindle revolution and unit.
    PerTurn(f64),
    /// A unit that is not followed.
    Other,
}

/// A reader of APT records with the modes in force.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    pub(crate) source: &'a [u8],
    options: &'a RobotOptions,
    lines: LineCursor<'a>,
    pub(crate) unit_mm: f64,
    feed: Option<(f64, FeedUnit)>,
    spindle_rev_per_min: Option<f64>,
    tool: Option<u32>,
    pub(crate) is_rapid: bool,
    /// Words of the first record that says in which frame coordinates are.
    system: Option<Vec<String>>,
    /// The first work offset that PREFUN has set, 54 to 59.
    work_offset: Option<u32>,
    /// Whether coordinates stay in one frame whatever CSYS says (`TRNTYP/WORLD,0,0,0`).
    is_in_world: bool,
    /// Lines of `$$*CATIA0` that are still to come.
    catia_lines: usize,
    catia_words: Vec<String>,
    /// Whether a header of Pro/CLfile was read.
    pub(crate) is_creo: bool,
    cutcom_points: Option<CutcomPoints>,
    /// The tool axis that TLAXIS or CSYS sets for the next motion, from which on it stays.
    tool_axis: Option<Vector3<f64>>,
    /// Whether the last tool axis is not +z, whether a record set it, and whether it ended at MULTAX/OFF.
    is_tilted: bool,
    is_tilted_by_record: bool,
    axis_is_open: bool,
    /// The circle on which the next GOTO ends.
    circle: Option<AptCircle>,
    /// Direction in which the next motion starts (INDIRV), with the bytes of its record.
    pub(crate) direction: Option<(Vector3<f64>, Range<usize>)>,
    /// The cycle in force with its feed.
    pub(crate) cycle: Option<(Drilling, Option<(f64, FeedUnit)>)>,
    /// Line of FINI, at which the program ends.
    end_line: Option<usize>,
}

impl<'a> Reader<'a> {
    /// Starts at the first record of `source`.
    pub fn new(source: &'a [u8], options: &'a RobotOptions) -> Self {
        Self {
            source,
            options,
            lines: LineCursor::new(source),
            unit_mm: 1.0,
            feed: None,
            spindle_rev_per_min: None,
            tool: None,
            is_rapid: false,
            system: None,
            work_offset: None,
            is_in_world: false,
            catia_lines: 0,
            catia_words: Vec::new(),
            is_creo: false,
            cutcom_points: options.cutcom_points,
            tool_axis: None,
            is_tilted: false,
            is_tilted_by_record: false,
            axis_is_open: false,
            circle: None,
            direction: None,
            cycle: None,
            end_line: None,
        }
    }

    /// Returns the next record that moves the tool; `None` at the end, `Err` for a record that is not followed.
    pub fn next(&mut self) -> Result<Option<Statement>, LocatedFault> {
        while let Some((at, line, code)) = self.next_record()? {
            let found = self.follow_record(at.clone(), line, &code);
            if let Some(statement) = found.map_err(|fault| LocatedFault { line, at, fault })? {
                return Ok(Some(statement));
            }
        }
        Ok(None)
    }

    /// Follows the comment on the line `range` where CAM systems say in one in which frame points are, and which points.
    fn follow_comment(&mut self, mut range: Range<usize>) -> Result<(), LocatedFault> {
        let source = self.source;
        let text = |range: Range<usize>| String::from_utf8_lossy(&source[range]).trim().to_ascii_uppercase();
        let (line, start, mut comment) = (self.lines.line, range.start, text(range.clone()));
        if let Some(words) = comment.strip_prefix("$$").filter(|_| self.catia_lines > 0) {
            self.catia_lines -= 1;
            // The first line is a name.
            if self.catia_lines < 3 {
                self.catia_words.extend(words.split_whitespace().map(str::to_owned));
            }
            if self.catia_lines == 0 {
                let words = std::mem::take(&mut self.catia_words);
                self.same_system(words).map_err(|fault| LocatedFault { line, at: range, fault })?;
            }
            return Ok(());
        }
        self.catia_lines = if comment.starts_with("$$*CATIA0") { 4 } else { 0 };
        self.is_creo |= comment.starts_with("$$*") && comment.contains("PRO/CLFILE");
        if !comment.starts_with("$$->") {
            return Ok(());
        }
        while comment.ends_with('$') {
            comment.pop();
            let Some(next) = self.lines.advance() else { break };
            range.end = next.end;
            comment.push_str(&text(next));
        }
        let (word, minor) = comment[4..].split_once('/').unwrap_or_default();
        let followed = match word.trim() {
            "CSYS" => self.same_system(minor_words(minor.as_bytes())),
            "CUTCOM_GEOMETRY_TYPE" => {
                let points = match minor.trim() {
                    "OUTPUT_ON_CENTER" => CutcomPoints::ToolCentre,
                    _ => CutcomPoints::Contour,
                };
                self.cutcom_points = self.options.cutcom_points.or(Some(points));
                Ok(())
            }
            _ => Ok(()),
        };
        followed.map_err(|fault| LocatedFault { line, at: start..range.end, fault })
    }

    /// Notes the frame of the coordinates, which `words` give. `Err` if it is another than before.
    fn same_system(&mut self, words: Vec<String>) -> Result<(), RobotFault> {
        let number = |word: &String| word.parse::<f64>().map_err(|_| word.clone());
        let before = self.system.get_or_insert_with(|| words.clone());
        match before.iter().map(number).eq(words.iter().map(number)) {
            true => Ok(()),
            false => RobotFault::not_followed("second systems of coordinates are", "one for all points"),
        }
    }

    /// Follows PREFUN, whose G functions the post-processor writes as they are: `Err` for those that move or turn coordinates or make steps of them on
    /// some control, and for a second work offset.
    fn follow_functions(&mut self, words: &[String]) -> Result<(), RobotFault> {
        for number in words.iter().filter_map(|word| word.parse::<f64>().ok()) {
            let number = number.trunc() as u32;
            let is_second = (54..=59).contains(&number) && *self.work_offset.get_or_insert(number) != number;
            if is_second || matches!(number, 10 | 16 | 51..=53 | 68 | 91 | 92) {
                return RobotFault::not_followed(
                    "G functions that give coordinates another meaning are",
                    "none of them, or PREFUN in robot_program.calls_kept if they do not",
                );
            }
        }
        Ok(())
    }

    /// Refuses CUTCOM, which the control makes, where points are not known to be of the tool centre.
    fn check_cutcom(&self, words: &[String]) -> Result<(), RobotFault> {
        match self.cutcom_points {
            _ if words[0] == "OFF" || words[0] == "NOMORE" => Ok(()),
            Some(CutcomPoints::ToolCentre) => Ok(()),
            Some(CutcomPoints::Contour) => RobotFault::not_followed(
                "contours from which the control offsets the tool are",
                "points of the tool centre",
            ),
            None => Err(RobotFault::Cutcom),
        }
    }

    /// Follows TRNTYP. `Err` for coordinates that are not of the world.
    fn follow_kind_of_coordinates(&mut self, words: &[String]) -> Result<(), RobotFault> {
        self.is_in_world = words[0] == "WORLD" && words[1..].iter().all(|word| word.parse() == Ok(0.0));
        match self.is_in_world {
            true => Ok(()),
            false => RobotFault::not_followed("other kinds of coordinates are", "TRNTYP/WORLD,0,0,0"),
        }
    }

    /// Returns the next record: its bytes, its first line, and its text with blanks for comments and line breaks; `None` at the end.
    fn next_record(&mut self) -> Result<Option<Record>, LocatedFault> {
        loop {
            let Some(whole) = self.lines.advance() else { return Ok(None) };
            let (mut range, mut is_continued) = code_range(self.source, whole.clone());
            let first = self.lines.line;
            if self.source[range.clone()].trim_ascii().is_empty() && range != whole {
                self.follow_comment(whole)?;
                continue;
            }
            while is_continued && let Some(next) = self.lines.advance() {
                let (more, more_follow) = code_range(self.source, next);
                (range.end, is_continued) = (more.end, more_follow);
            }
            let at = trimmed(self.source, range);
            if at.is_empty() {
                continue;
            }
            // What stands behind a `$` is a comment.
            let mut behind = false;
            let blank = |byte: &u8| {
                behind = (behind || *byte == b'$') && !matches!(byte, b'\r' | b'\n');
                if behind || matches!(byte, b'\r' | b'\n') { b' ' } else { *byte }
            };
            return Ok(Some((at.clone(), first, self.source[at].iter().map(blank).collect())));
        }
    }

    /// Follows the record with the text `code` on line `line`: returns the statement if it moves the tool, or else sets modes.
    fn follow_record(&mut self, at: Range<usize>, line: usize, code: &[u8]) -> Result<Option<Statement>, RobotFault> {
        let slash = code.iter().position(|byte| *byte == b'/');
        let major = String::from_utf8_lossy(&code[..slash.unwrap_or(code.len())]).trim().to_ascii_uppercase();
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        let word = major.split(|c: char| !is_of_name(c)).next().unwrap_or_default();
        let minor = slash.map_or(&code[code.len()..], |slash| &code[slash + 1..]);
        let words = minor_words(minor);
        let has = |word: &str| words.iter().any(|minor_word| minor_word == word);
        let number = || words.iter().find_map(|word| word.parse::<f64>().ok()).filter(|number| number.is_finite());
        let is_text = is_in_list(word, "INSERT PPRINT PARTNO REMARK TPRINT LETTER PPFUN");
        if self.circle.is_some() && word != "GOTO" || self.direction.is_some() && major != "TLON,GOFWD" {
            return Err(RobotFault::Form { expected: "the motion of the circle behind CIRCLE or INDIRV" });
        }
        let is_kept = || self.options.keeps_call(word);
        if !is_text && is_in_list(word, "TLDATA TOOLNO LOADTL LOAD MACHIN") && (has("TURN") || has("LATHE")) {
            return RobotFault::not_followed("programs of lathes are", "a program of a mill");
        }
        match word {
            "GOTO" | "FROM" | "GODLTA" => {
                if let Some(end) = self.end_line {
                    return Err(RobotFault::AfterEnd { end });
                }
                let minor_at = slash.map_or(at.end, |slash| at.start + slash + 1);
                return self.motion(word, at, line, minor, minor_at).map(Some);
            }
            "CIRCLE" => self.circle = Some(self.circle_record(at.clone(), minor, at.end - minor.len())?),
            "INDIRV" => self.direction = Some((direction_vector(&words)?, at)),
            "TLON" if self.direction.is_some() => return self.circular_motion(at, line, code).map(Some),
            "CYCLE" => match words[0].as_str() {
                "OFF" | "NOMORE" => self.cycle = None,
                "INIT" | "CLEAR" if words.len() == 1 => {}
                _ => self.cycle = Some(self.read_cycle(&words)?),
            },
            "CUTCOM" => self.check_cutcom(&words)?,
            "INSERT" if is_block_of_a_control(&code[word.len()..]) && !is_kept() => {
                return RobotFault::not_followed(
                    "blocks of a control that INSERT puts into the program are",
                    "a comment, or INSERT in robot_program.calls_kept if none moves the tool",
                );
            }
            "MULTAX" => self.axis_is_open = self.is_tilted && has("OFF"),
            "TRNTYP" => self.follow_kind_of_coordinates(&words)?,
            "CSYS" if self.is_in_world && words.len() == 12 => {
                self.set_axis(direction_vector(&[2, 6, 10].map(|entry| words[entry].clone()))?);
            }
            "CSYS" => self.same_system(words)?,
            "GOHOME" if self.is_tilted_by_record => {
                return RobotFault::not_followed(
                    "GOHOME with a tilted axis of TLAXIS or CSYS is",
                    "GOTO with i,j,k before it",
                );
            }
            "GOHOME" => {
                return Ok(Some(self.statement(at.clone(), line, at.start..at.start, MotionKind::PointToPoint)));
            }
            "RAPID" => self.is_rapid = true,
            "FEDRAT" => {
                self.is_rapid = false;
                self.feed = number().map(|number| (number, self.feed_unit(&has)));
            }
            "SPINDL" => match number().filter(|speed| *speed > 0.0) {
                None if !has("OFF") => {}
                speed => self.spindle_rev_per_min = speed.filter(|_| !has("SFM") && !has("SMM")),
            },
            "UNITS" | "UNIT" => self.unit_mm = unit_mm(&words)?,
            "LOAD" if words[0] != "TOOL" => return Err(RobotFault::Call { name: word.to_owned() }),
            "LOADTL" | "LOAD" => {
                self.tool = number().filter(|tool| *tool >= 0.0 && tool.fract() == 0.0).map(|tool| tool as u32)
            }
            "MSYS" | "MCSYS" => self.same_system(words)?,
            "FINI" => self.end_line = Some(line),
            "TLAXIS" => self.set_axis(direction_vector(&words)?),
            "PREFUN" if !is_kept() => self.follow_functions(&words)?,
            "TRACUT" | "ROTABL" | "ROTHED" if words[0] == "OFF" || words[0] == "NOMORE" => {}
            _ if is_in_list(word, REFUSED) => {
                return RobotFault::not_followed("turned tables, splines and computed motions are", "GOTO/x,y,z,i,j,k");
            }
            _ if is_text || is_kept() || major.contains('=') || is_in_list(word, IGNORED) => {}
            _ => return Err(RobotFault::Call { name: word.to_owned() }),
        }
        Ok(None)
    }

    /// Returns the unit of a FEDRAT record; `has` tells whether the record has a word.
    pub(crate) fn feed_unit(&self, has: &dyn Fn(&str) -> bool) -> FeedUnit {
        match () {
            () if has("MMPM") => FeedUnit::PerMinute(1.0),
            () if has("FPM") || has("FPR") || has("LENGTH") || has("LOCK") || has("SCALE") => FeedUnit::Other,
            () if has("IPM") => FeedUnit::PerMinute(INCH_MM),
            () if has("MMPR") => FeedUnit::PerTurn(1.0),
            () if has("IPR") => FeedUnit::PerTurn(INCH_MM),
            () if has("PERREV") || has("UPR") => FeedUnit::PerTurn(self.unit_mm),
            () if has("INVERS") || has("INVRS") => FeedUnit::Other,
            () => FeedUnit::PerMinute(self.unit_mm),
        }
    }

    /// Returns the statement of GOTO, FROM or GODLTA (`word`), whose numbers `minor` begin at byte `minor_at` of the source.
    fn motion(
        &mut self,
        word: &str,
        at: Range<usize>,
        line: usize,
        minor: &[u8],
        minor_at: usize,
    ) -> Result<Statement, RobotFault> {
        let expected = RobotFault::Form { expected: "three plain numbers x,y,z, or six with the tool axis i,j,k" };
        let (mut scan, mut numbers) = (Scan::new(minor), Vec::new());
        loop {
            let (value, range) = scan.number()?;
            let entry = numbers.len();
            let component = if entry < 3 { Component::Position(entry) } else { Component::Rotation(entry - 3) };
            numbers.push(Number { component, at: range, value });
            if !scan.takes(b',') {
                break;
            }
        }
        if !scan.is_done() || !matches!(numbers.len(), 3 | 6) || (word == "GODLTA" && numbers.len() != 3) {
            return Err(expected);
        }
        let (first, last) = (numbers[0].at.start, numbers[numbers.len() - 1].at.end);
        for number in &mut numbers {
            number.at = number.at.start - first..number.at.end - first;
        }
        let pose = minor_at + first..minor_at + last;
        if let [_, _, _, i, j, k] = numbers[..].iter().map(|number| number.value).collect::<Vec<_>>()[..] {
            self.set_axis(Vector3::new(i, j, k));
            (self.tool_axis, self.is_tilted_by_record) = (None, false);
        } else if self.axis_is_open {
            return Err(RobotFault::Form { expected: "the tool axis i,j,k behind MULTAX/OFF, or TLAXIS before" });
        }
        let circle = self.circle.take();
        let kind = match () {
            () if self.is_rapid || word == "FROM" => MotionKind::PointToPoint,
            () if circle.is_some() => MotionKind::Circle,
            () => MotionKind::Line,
        };
        let is_hole = word == "GOTO" && kind == MotionKind::Line;
        if self.cycle.is_some() && !is_hole && word != "FROM" || circle.is_some() && kind != MotionKind::Circle {
            return Err(RobotFault::Form {
                expected: "GOTO of a hole in a cycle, and no RAPID before the end of an arc",
            });
        }
        self.is_rapid &= word == "FROM";
        let keyword = at.start..at.start + word.len();
        let mut statement = self.statement(at.clone(), line, keyword, kind);
        if let Some((drilling, feed)) = self.cycle.filter(|_| is_hole) {
            statement.apt.drilling = Some(drilling);
            statement.feed_mm_per_min = self.feed_mm_per_min(feed);
        }
        statement.apt.circle = circle;
        Ok(Statement {
            end: Some(Target { at: pose.clone(), text: self.source[pose.clone()].to_vec(), numbers }),
            suffix: pose.end..at.end,
            is_step: word == "GODLTA",
            ..statement
        })
    }

    /// Puts the tool axis `axis` in force.
    fn set_axis(&mut self, axis: Vector3<f64>) {
        self.is_tilted = axis.x != 0.0 || axis.y != 0.0 || axis.z < 0.0;
        (self.tool_axis, self.is_tilted_by_record, self.axis_is_open) = (Some(axis), self.is_tilted, false);
    }

    /// Returns the feed of FEDRAT or of a cycle, mm/min; `None` if it is unknown.
    fn feed_mm_per_min(&self, feed: Option<(f64, FeedUnit)>) -> Option<f64> {
        let feed = feed.and_then(|(feed, unit)| match unit {
            FeedUnit::PerMinute(mm) => Some(feed * mm),
            FeedUnit::PerTurn(mm) => Some(feed * mm * self.spindle_rev_per_min?),
            FeedUnit::Other => None,
        });
        feed.filter(|feed| *feed > 0.0)
    }

    /// Creates a statement without target, with the modes in force.
    pub(crate) fn statement(
        &mut self,
        at: Range<usize>,
        line: usize,
        keyword: Range<usize>,
        kind: MotionKind,
    ) -> Statement {
        Statement {
            frames: Frames { unit_mm: self.unit_mm, ..Frames::default() },
            feed_mm_per_min: self.feed_mm_per_min(self.feed),
            spindle_rev_per_min: self.spindle_rev_per_min,
            tool: self.tool,
            apt: AptParts { tool_axis: self.tool_axis.take(), ..AptParts::default() },
            ..Statement::new(at, line, keyword, kind)
        }
    }
}

/// Returns the range of a line's code without its comment (`$$`), and whether `$` continues it on the next line.
fn code_range(source: &[u8], line: Range<usize>) -> (Range<usize>, bool) {
    let text = &source[line.clone()];
    // A byte order mark is no code.
    let start = if text.starts_with(b"\xef\xbb\xbf") { line.start + 3 } else { line.start };
    let is_text = TEXTS.iter().any(|word| {
        let text = text.trim_ascii_start();
        text.get(..word.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(word.as_bytes()))
    });
    let dollar = text.iter().position(|byte| *byte == b'$').filter(|_| !is_text);
    match dollar {
        Some(at) if text.get(at + 1) == Some(&b'$') => (start..(line.start + at).max(start), false),
        Some(at) => (start..line.start + at + 1, true),
        None => (start..line.end, false),
    }
}

/// Returns the mm of the unit that UNITS names.
fn unit_mm(words: &[String]) -> Result<f64, RobotFault> {
    match words.first().map(String::as_str) {
        Some("MM") => Ok(1.0),
        Some("INCHES" | "INCH" | "IN") => Ok(INCH_MM),
        _ => Err(RobotFault::Form { expected: "UNITS/MM or UNITS/INCHES" }),
    }
}

/// Splits a record at its commas into words and numbers, in upper case.
fn minor_words(minor: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(minor).to_ascii_uppercase();
    text.split(',').map(|word| word.trim().to_owned()).collect()
}

/// Returns the unit vector that three `words` give.
fn direction_vector(words: &[String]) -> Result<Vector3<f64>, RobotFault> {
    let numbers: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let vector = match (numbers.as_slice(), words.len()) {
        (&[x, y, z], 3) => Vector3::new(x, y, z).try_normalize(f64::MIN_POSITIVE).filter(|unit| unit.x.is_finite()),
        _ => None,
    };
    vector.ok_or(RobotFault::Form { expected: "a direction: three numbers" })
}

/// Whether the text of INSERT begins as a block of a control does, and not as a comment.
fn is_block_of_a_control(text: &[u8]) -> bool {
    let text = String::from_utf8_lossy(text).to_ascii_uppercase();
    let text = text.trim().trim_start_matches('/').trim_start();
    let letters = text.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(text.len());
    let behind = text[letters..].trim_start().as_bytes();
    // Words of a letter and a number, blocks of Heidenhain (L X+10), assignments, and calls.
    let is_short = (1..=2).contains(&letters);
    is_short || behind.starts_with(b"=") || text.starts_with(['#', '$']) || is_in_list(&text[..letters], CONTROL_WORDS)
}

/// Records of free text, in which `$` has no meaning.
const TEXTS: [&str; 7] = ["INSERT", "PPRINT", "PARTNO", "REMARK", "TPRINT", "LETTER", "PPFUN"];

/// Words with which blocks of controls begin that may move the tool.
const CONTROL_WORDS: &str = "CALL CYCL CYCLE PLANE TRANS ATRANS ROT AROT MIRROR SCALE FUNCTION TOOL GOTO IF WHILE REPEAT FOR MCALL SUPA \
    TRAORI SET LIN PTP MOVEL MOVEJ";

/// Records that are refused: they move the tool in other ways, or change what motions mean.
const REFUSED: &str = "MOVARC TRACUT REFSYS TRANS ROTATE ROTABL ROTHED ORIGIN COPY CALL MACRO TERMAC LOOPST LOOPND JUMPTO IF GOLFT GORGT \
    GOFWD GOBACK GOUP GODOWN GO INDIRP THICK TLLFT TLRGT TLON POLYGO NURBS SPLINE KNOT CNTRL RETRCT";

/// Records that are ignored: they neither move the tool nor change what motions mean.
const IGNORED: &str = "INSERT PPRINT PARTNO REMARK TPRINT LETTER PPFUN MACHIN COOLNT CUTTER HOLDER TLDATA TOOL TOOLNO SELCTL SELECT TURRET \
    UNLOAD INTOL OUTTOL TOLER MAXANG MAXDP AUXFUN PREFUN OPSTOP STOP DELAY DWELL END END-OF-PATH FINI SEQNO OPTIOM OPSKIP CLEARP CLAMP CLRSRF \
    PAINT TMARK DISPLAY PLABEL CLPRNT NOPOST PRINT PUNCH LINTOL BREAK CHECK ARCSLP LEADER REWIND RESET SET SETUP ISN AIR AUTOPS PSIS \
    CSI_SET_FLUTE_LENGTH CSI_SET_EXTENSION_LENGTH";

/// Whether `word` is one of the blank-separated `words`.
fn is_in_list(word: &str, words: &str) -> bool {
    words.split_whitespace().any(|listed| listed == word)
}
