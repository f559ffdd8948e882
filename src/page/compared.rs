//! One view of several results: their numbers side by side, their differences, and which is better where.

use serde::Serialize;

use super::{
    aligned::Aligned,
    dataset::Dataset,
    description::{Better, Column, Mark, Shape},
    floors::Floors,
    folder::ResultFolder,
    packed::{Packed, Precision, script_json},
    side_by_side::{SideBySide, WinsRow, side_by_side, wins},
    single::{ExplorerView, group_labels, note},
};

/// A view that all results have.
#[derive(Debug, Serialize)]
pub(super) struct Compared {
    view: ExplorerView,
    /// What the statistics of the table are taken over.
    over: String,
    /// What one place of it is called, in the plural.
    nouns: String,
    table: Vec<SideBySide>,
    wins: Vec<WinsRow>,
    notes: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ComparedData<'a> {
    shape: Shape,
    title: &'a str,
    coordinates: &'a [Column],
    group_label: &'a str,
    groups: Vec<&'a str>,
    labels: Vec<String>,
    units: Vec<&'a str>,
    better: Vec<Better>,
    /// What is rounding, by quantity.
    floors: Vec<f64>,
    colours: &'static str,
    cases: Vec<CaseData<'a>>,
    marks: &'a [Mark],
}

/// One result, or the difference of two.
#[derive(Debug, Serialize)]
struct CaseData<'a> {
    name: String,
    is_difference: bool,
    axes: &'a [Vec<f64>],
    names: &'a [String],
    /// By quantity and group.
    series: Vec<Vec<Option<Packed>>>,
    notes: &'a [String],
    flags: &'a [Vec<(usize, usize)>],
}

/// What a page shows of `aligned`.
pub(super) fn compared(
    aligned: &Aligned,
    floors: &Floors,
    folders: &[ResultFolder],
    letters: &[char],
    colours: &'static str,
) -> Compared {
    let mut notes = aligned.remarks.clone();
    notes.extend(aligned.common.remark(&aligned.data, aligned.shared.shape, aligned.noun()));
    Compared {
        view: view(aligned, floors, folders, letters, colours),
        over: aligned.extremes_of().1,
        nouns: format!("{}s", aligned.noun()),
        table: side_by_side(aligned, floors, letters),
        wins: wins(aligned, floors, letters),
        notes,
    }
}

fn view(
    aligned: &Aligned,
    floors: &Floors,
    folders: &[ResultFolder],
    letters: &[char],
    colours: &'static str,
) -> ExplorerView {
    let Aligned { shared: explorer, data, common, .. } = aligned;
    let precision = Precision::for_numbers(2 * data.iter().map(Dataset::number_count).sum::<usize>());
    let pack = |values: &[Vec<Vec<f64>>]| -> Vec<Vec<Option<Packed>>> {
        values.iter().map(|groups| groups.iter().map(|v| Packed::new(v, precision)).collect()).collect()
    };
    let mut cases: Vec<CaseData<'_>> = Vec::new();
    for ((own, letter), folder) in data.iter().zip(letters).zip(folders) {
        cases.push(CaseData {
            name: format!("{letter}: {}", folder.description.name),
            is_difference: false,
            axes: &own.axes,
            names: &own.names,
            series: pack(&own.values),
            notes: &own.notes,
            flags: &own.flags,
        });
    }
    if common.count() > 1 {
        for (other, letter) in letters.iter().enumerate().skip(1) {
            let part = &common.parts[0];
            cases.push(CaseData {
                name: format!("{letter} \u{2212} {}", letters[0]),
                is_difference: true,
                axes: &part.axes,
                names: &part.names,
                series: pack(&difference(aligned, other)),
                notes: &[],
                flags: &[],
            });
        }
    }
    let json = script_json(&ComparedData {
        shape: explorer.shape,
        title: &explorer.title,
        coordinates: &explorer.coordinates,
        group_label: explorer.group.as_ref().map_or("", |group| &group.label),
        groups: group_labels(explorer),
        labels: explorer.quantities.iter().map(|q| q.label.clone()).collect(),
        units: explorer.quantities.iter().map(|q| q.unit.as_str()).collect(),
        better: explorer.quantities.iter().map(|q| q.better).collect(),
        floors: explorer.quantities.iter().map(|q| floors.of(&q.unit)).collect(),
        colours,
        cases,
        marks: &explorer.marks,
    });
    ExplorerView {
        id: String::new(),
        title: explorer.title.clone(),
        shape: explorer.shape,
        note: note(explorer, &data[0], precision),
        json,
    }
}

/// The values of the result `other` minus those of the first, by quantity, group and node in common.
fn difference(aligned: &Aligned, other: usize) -> Vec<Vec<Vec<f64>>> {
    let common = &aligned.common;
    let of_quantity = |quantity: usize| {
        let of_group = |group: usize| {
            let [a, b] = [0, other].map(|i| common.parts[i].values[quantity][group].as_slice());
            let counts = common.counts(group, other);
            let of = |(node, (a, b)): (usize, (&f64, &f64))| if counts(node) { b - a } else { f64::NAN };
            a.iter().zip(b).enumerate().map(of).collect()
        };
        (0..aligned.groups()).map(of_group).collect()
    };
    (0..aligned.shared.quantities.len()).map(of_quantity).collect()
}
