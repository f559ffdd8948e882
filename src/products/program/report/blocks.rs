//! What the blocks of a program ask of a control, before and as written: in sentences and as a table.

use crate::{
    files::words::counted,
    page::SmallTable,
    products::program::ProgramJob,
    simulation::blocks::{Blocks, BlocksBeforeAfter, Spread},
};

/// How near the program was written to its points, and how many blocks that takes; nothing for polylines.
pub(super) fn written_text(job: &ProgramJob, blocks: Option<&BlocksBeforeAfter>) -> String {
    let Some(BlocksBeforeAfter { before, after }) = blocks else { return String::new() };
    let near = match job.process.write_tolerance_mm {
        0.0 => "to a unit of the last decimal".into(),
        tolerance => format!("to within {tolerance} mm"),
    };
    format!(
        "Written {near}: {} for {} before, {} for {}.\n",
        counted(after.moves, "move"),
        before.moves,
        counted(after.lines, "line"),
        before.lines
    )
}

/// The same, and what these blocks ask of a control.
pub fn blocks_text(job: &ProgramJob, blocks: Option<&BlocksBeforeAfter>) -> String {
    let mut text = written_text(job, blocks);
    let Some(BlocksBeforeAfter { before, after }) = blocks else { return text };
    let mut told = |what: &str, unit: &str, of: fn(&Blocks) -> Option<Spread>| {
        if let (Some(before), Some(after)) = (of(before), of(after)) {
            let words =
                |spread: Spread| [spread.p50, spread.p95, spread.max].map(|value| format!("{}{unit}", short(value)));
            let ([b50, b95, bmax], [a50, a95, amax]) = (words(before), words(after));
            text +=
                &format!("{what}: half up to {a50}, 95 % up to {a95}, at most {amax} (before {b50}, {b95}, {bmax}).\n");
        }
    };
    told("Blocks per second at the programmed feed", "", |blocks| blocks.per_second);
    told("Turns from move to move", "°", |blocks| blocks.turns_deg);
    text
}

/// The same as a table for the page.
pub(super) fn blocks_table(blocks: &BlocksBeforeAfter) -> SmallTable {
    let row = |name: &str, blocks: &Blocks| {
        let mut row = vec![name.to_string(), blocks.lines.to_string(), blocks.moves.to_string()];
        for (spread, unit) in [(blocks.per_second, ""), (blocks.turns_deg, "°")] {
            let values = spread.map_or([None; 3], |spread| [spread.p50, spread.p95, spread.max].map(Some));
            row.extend(values.map(|value| value.map_or_else(|| "–".into(), |value| format!("{}{unit}", short(value)))));
        }
        row
    };
    let header = ["", "lines", "moves", "blocks/s: half", "95 %", "most", "turns: half", "95 %", "most"];
    SmallTable {
        caption:
            "Blocks driven with the feed: how many a second at the programmed feed, and turns from one to the next"
                .into(),
        header: header.map(String::from).into(),
        rows: vec![row("before", &blocks.before), row("as written", &blocks.after)],
    }
}

/// Three digits.
fn short(value: f64) -> String {
    let decimals = if value == 0.0 { 0.0 } else { (2.0 - value.abs().log10().floor()).clamp(0.0, 3.0) };
    let text = format!("{value:.*}", decimals as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_have_three_digits() {
        let shown = [0.0, 0.01234, 0.1, 2.5, 12.345, 90.0, 504.3, 2689.0].map(short);
        assert_eq!(shown, ["0", "0.012", "0.1", "2.5", "12.3", "90", "504", "2689"]);
    }
}
