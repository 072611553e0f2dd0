//! Finds the table in a file: its names, its units, its rows, and what is none of these.

use super::cell::{CellKind, kind};
use super::keywords::{has, plain, words_of};
use super::labview;
use super::names::{is_unit, is_unit_cell, name_and_unit};
use super::records::TextRecord;

/// Records in which the beginning of a table is looked for.
pub(super) const SEARCHED: usize = 2000;

/// Where the parts of a table are among the records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TableParts {
    /// The record with the names; `None` if there is none.
    pub(super) header: Option<usize>,
    /// Whether the names are those split at several blanks.
    pub(super) wide: bool,
    /// The record with the units.
    pub(super) units: Option<usize>,
    /// Rows: their records, and in which segment each is, from 1.
    pub(super) rows: Vec<(usize, u32)>,
    /// Records between and below segments that are no rows.
    pub(super) others: Vec<usize>,
    /// First records of segments after the lines above the first.
    pub(super) segments: u32,
}

/// Number of numeric cells less that of words.
pub(super) fn score(records: &[TextRecord], wanted: &[String]) -> i64 {
    let of_cells = |record: &TextRecord| {
        let kinds = record.fields.iter().map(kind);
        kinds.fold((0, 0), |(numbers, words), kind| match kind {
            CellKind::Numeric => (numbers + 1, words),
            CellKind::Words => (numbers, words + 1),
            CellKind::Absent => (numbers, words),
        })
    };
    let rows = records
        .iter()
        .filter(|record| !record.is_comment)
        .map(of_cells);
    let sum: i64 = rows
        .filter(|(numbers, _)| *numbers > 0)
        .map(|(numbers, words)| numbers - words)
        .sum();
    // Names that are asked for decide before numbers do.
    let named = i64::from(!wanted.is_empty() && header_of(records, wanted).is_some());
    named * 1_000_000_000 + sum
}

/// Whether nearly all records with two numbers or more have the same number of fields.
pub(super) fn is_even(records: &[TextRecord]) -> bool {
    let rows = records.iter().filter(|record| !record.is_comment);
    let lengths = rows.filter(|record| numeric(record) > 1);
    let mut lengths: Vec<usize> = lengths.map(|record| record.fields.len()).collect();
    lengths.sort_unstable();
    let usual = lengths.chunk_by(|a, b| a == b).map(<[usize]>::len).max();
    usual.is_some_and(|usual| usual > 1 && 10 * usual >= 9 * lengths.len())
}

/// The first record with all names asked for, and whether they are those split at several blanks.
fn header_of(records: &[TextRecord], wanted: &[String]) -> Option<(usize, bool)> {
    if wanted.is_empty() {
        return None;
    }
    let has_all = |fields: &csv::StringRecord| {
        let named = |name: &String| {
            let is = |field: &str| field == name || name_and_unit(field).0 == name;
            fields.iter().any(is)
        };
        // Columns may be called by their numbers, which any row may hold.
        let number = |name: &String| name.parse::<usize>().ok();
        let numbered = |name| number(name).is_some_and(|at| (1..=fields.len()).contains(&at));
        wanted
            .iter()
            .any(|name| number(name).is_none() && named(name))
            && wanted.iter().all(|name| named(name) || numbered(name))
    };
    records
        .iter()
        .enumerate()
        .filter(|(_, record)| !record.is_comment)
        .find_map(|(index, record)| {
            if has_all(&record.fields) {
                Some((index, false))
            } else {
                record
                    .wide
                    .as_ref()
                    .filter(|wide| has_all(wide))
                    .map(|_| (index, true))
            }
        })
}

/// The largest stretch of records with numbers: its first record.
fn first_of_largest_block(records: &[TextRecord]) -> Option<usize> {
    let mut best = (0, None);
    let mut block: Option<(usize, usize)> = None;
    for (index, record) in records.iter().enumerate() {
        if record.is_comment || record.is_blank() {
            continue;
        }
        let numbers = numeric(record);
        let is_row = numbers > 0 && 2 * numbers + usize::from(numbers > 1) >= record.len();
        block = is_row.then(|| {
            let (first, sum) = block.unwrap_or((index, 0));
            (first, sum + numbers)
        });
        if let Some((first, sum)) = block
            && sum > best.0
        {
            best = (sum, Some(first));
        }
    }
    best.1
}

fn numeric(record: &TextRecord) -> usize {
    record
        .fields
        .iter()
        .filter(|field| kind(field) == CellKind::Numeric)
        .count()
}

/// Whether the cells are names: words, or numbers of channels among words that stand above numbers.
fn are_names(record: &TextRecord, row: &TextRecord) -> bool {
    let cells = || record.fields.iter().zip(&row.fields);
    let of = |cell: &str, wanted| kind(cell) == wanted;
    let words = cells().filter(|(name, _)| of(name, CellKind::Words));
    let above = words
        .filter(|(_, cell)| of(cell, CellKind::Numeric))
        .count();
    let numbers = numeric(record);
    numbers == 0 || above > numbers
}

/// Whether the cells are units, at least one of them a known one or in brackets.
fn is_units_row(record: &TextRecord) -> bool {
    let cells = || record.fields.iter().filter(|cell| !cell.is_empty());
    let sure = |cell: &str| is_unit(cell) || super::names::in_brackets(cell).is_some();
    cells().next().is_some() && cells().all(is_unit_cell) && cells().any(sure)
}

/// Finds the table; `None` if there are neither names that were asked for nor numbers.
///
/// # Arguments
/// - `wanted`: names of which all must be in the header, if it has them.
pub(super) fn find(records: &[TextRecord], wanted: &[String]) -> Option<TableParts> {
    let searched = &records[..records.len().min(SEARCHED)];
    let is_text = |index: usize| !records[index].is_comment && !records[index].is_blank();
    let before = |index: usize| (0..index).rev().find(|i| is_text(*i));
    let after = |index: usize| (index + 1..records.len()).find(|i| is_text(*i));
    let (header, wide, mut first) = if let Some((header, wide)) = header_of(searched, wanted) {
        (Some(header), wide, after(header))
    } else {
        let first = first_of_largest_block(searched)?;
        let width = records[first].len();
        let above = before(first);
        let above = match above.and_then(before) {
            Some(names) if above.is_some_and(|units| is_units_row(&records[units])) => Some(names),
            _ => above,
        };
        let fits = |index: &usize| {
            let record = &records[*index];
            let wide = record.wide.as_ref().is_some_and(|wide| wide.len() == width);
            (wide || record.len() >= width && record.fields.len() >= records[first].len())
                && are_names(record, &records[first])
        };
        // The same names may stand above several segments; the table begins with the first.
        let header = above.filter(fits).and_then(|header| {
            records
                .iter()
                .position(|record| record.fields == records[header].fields)
        });
        let wide = header.is_some_and(|h| {
            records[h]
                .wide
                .as_ref()
                .is_some_and(|w| w.len() == width && records[h].len() != width)
        });
        match header {
            Some(header) => (Some(header), wide, after(header)),
            None => (None, false, Some(first)),
        }
    };
    let units = first.filter(|first| header.is_some() && is_units_row(&records[*first]));
    if let Some(units) = units {
        first = after(units);
    }
    let parts = TableParts {
        header,
        wide,
        units,
        rows: Vec::new(),
        others: Vec::new(),
        segments: 1,
    };
    Some(rows(records, parts, first.unwrap_or(records.len())))
}

/// Tells rows from what stands below the table and between its segments.
fn rows(records: &[TextRecord], mut parts: TableParts, first: usize) -> TableParts {
    let is_header = |index: usize| {
        parts.header.is_some_and(|header| {
            index > header
                && !records[index].is_blank()
                && records[index].fields == records[header].fields
        })
    };
    let width = parts
        .header
        .map_or(records[first.min(records.len() - 1)].len(), |header| {
            let record = &records[header];
            if parts.wide {
                record.wide.as_ref().map_or(0, csv::StringRecord::len)
            } else {
                record.len()
            }
        });
    // Segments begin with their names.
    let starts: Vec<usize> = (first..records.len())
        .filter(|index| is_header(*index))
        .collect();
    let mut begin = first;
    let mut passed = Vec::new();
    for (number, end) in starts.iter().copied().chain([records.len()]).enumerate() {
        let of_segment: Vec<usize> = (begin..end)
            .filter(|index| !records[*index].is_comment && !records[*index].is_blank())
            .collect();
        let is_last = end == records.len();
        let cut = if is_last {
            let table = of_segment.first().map(|first| &records[*first]);
            table.map_or(0, |table| end_of_table(records, &of_segment, table, width))
        } else {
            let rest = &of_segment[..];
            rest.iter()
                .position(|index| is_preamble(&records[*index], width))
                .unwrap_or(rest.len())
        };
        let (within, behind) = of_segment.split_at(cut);
        let counts = kinds_of_columns(records, within);
        let (left, kept): (Vec<usize>, Vec<usize>) = within
            .iter()
            .partition(|index| is_of_statistics(&records[**index], &counts));
        let numbered = kept.into_iter().map(|index| (index, number as u32 + 1));
        parts.rows.extend(numbered);
        passed.extend(left);
        passed.extend_from_slice(behind);
        if !is_last {
            passed.push(end);
            begin = end + 1;
            while begin < records.len()
                && (records[begin].is_blank() || is_units_row(&records[begin]))
            {
                if !records[begin].is_blank() {
                    passed.push(begin);
                }
                begin += 1;
            }
        }
    }
    parts.segments = starts.len() as u32 + 1;
    parts.others = passed;
    parts
}

/// Number of records of the last segment up to what stands below it: words, and another table behind words.
fn end_of_table(
    records: &[TextRecord],
    of_segment: &[usize],
    row: &TextRecord,
    width: usize,
) -> usize {
    let record = |place: usize| &records[of_segment[place]];
    let places = 0..of_segment.len();
    let is_words = |place: &usize| is_footer(record(*place), width);
    // Title, names or units of other columns between rows begin another table, and so do words before rows of another length.
    let begins_another = |place: &usize| {
        let next = (*place..of_segment.len()).find(|next| !is_words(next));
        let Some(next) = next.filter(|next| next > place && numeric(record(*next)) > 0) else {
            return false;
        };
        let has_names = (*place..next).any(|words| {
            let words = record(words);
            words.len() > 1 && numeric(words) == 0
        });
        record(next).len() != row.len() || next - place > 1 && has_names
    };
    if let Some(other) = places.clone().skip(1).find(begins_another) {
        return other;
    }
    // Below: lines without any number, or short of the table with words among them.
    let kept = places.rev().find(|place| !is_words(place));
    let kept = kept.map_or(0, |last| last + 1);
    // The row at which a file was cut off is no footer.
    let is_cut = kept > 0 && kept < of_segment.len() && is_cut_row(record(kept - 1), record(kept));
    kept + usize::from(is_cut)
}

/// Whether a record has a word of statistics, `Max` or `Mean`, in a column of numbers, and numbers beside it.
fn is_of_statistics(record: &TextRecord, counts: &[[usize; 2]]) -> bool {
    const STATISTICS: &str = "max min maximum minimum ave avg average mean sd std stdev median range cv sum total mittel mittelwert standardabweichung \
         summe maksimum moyenne ecart somme media mediana promedio desviacion desvio scarto srednia odchylenie prumer ortalama \
         среднее макс мин 最大 最小 平均 標準偏差 标准差";
    let word = record
        .fields
        .iter()
        .position(|cell| kind(cell) == CellKind::Words);
    let Some(place) = word.filter(|_| numeric(record) > 0) else {
        return false;
    };
    words_of(&plain(&record.fields[place])).any(|word| has(STATISTICS, word))
        && counts
            .get(place)
            .is_some_and(|[numbers, words]| numbers > words)
}

/// How many cells of each column are numbers or times, and how many are words.
pub(super) fn kinds_of_columns(records: &[TextRecord], rows: &[usize]) -> Vec<[usize; 2]> {
    let mut counts: Vec<[usize; 2]> = Vec::new();
    for record in rows.iter().map(|row| &records[*row]) {
        counts.resize(counts.len().max(record.fields.len()), [0; 2]);
        for (count, cell) in counts.iter_mut().zip(&record.fields) {
            match kind(cell) {
                CellKind::Numeric => count[0] += 1,
                CellKind::Words => count[1] += 1,
                CellKind::Absent => {}
            }
        }
    }
    counts
}

/// Words alone, or words in a line that is shorter or longer than a row.
fn is_footer(record: &TextRecord, width: usize) -> bool {
    let mut has_words = false;
    let mut is_text_only = true;
    for field in record.fields.iter().filter(|field| !field.is_empty()) {
        let is_words = kind(field) == CellKind::Words;
        has_words |= is_words;
        is_text_only &= is_words;
    }
    has_words && (is_text_only || record.fields.len() < width || record.len() > width)
}

/// Whether a record is the beginning of a row like the one before it: the same kinds of cells, words among them.
fn is_cut_row(row: &TextRecord, record: &TextRecord) -> bool {
    let cells = record.len();
    let alike = row.fields.iter().zip(&record.fields);
    cells > 1 && cells < row.len() && alike.take(cells).all(|(a, b)| kind(a) == kind(b))
}

fn is_preamble(record: &TextRecord, width: usize) -> bool {
    labview::is_tag(record) || is_footer(record, width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::FieldDelimiter;
    use crate::table_files::records::{lines, split};

    fn parts(text: &str, wanted: &[&str]) -> Option<TableParts> {
        let records = split(&lines(text), FieldDelimiter::Comma, usize::MAX);
        let wanted: Vec<String> = wanted.iter().map(|name| (*name).to_owned()).collect();
        find(&records, &wanted)
    }

    #[test]
    fn names_units_rows_and_the_rest() {
        let text = "Operator,K\nRate,100\n\nTime,Load\n(s),(N)\n0,1\n1,2\n\n2,\nEnd of test\n";
        let found = parts(text, &[]).unwrap();
        assert_eq!((found.header, found.units), (Some(3), Some(4)));
        assert_eq!(found.rows, [(5, 1), (6, 1), (8, 1)]);
        assert_eq!(found.others, [9]);
        assert_eq!(parts(text, &["Load"]), Some(found));
    }

    #[test]
    fn a_table_without_names() {
        let found = parts("0,1\n1,2\n", &[]).unwrap();
        assert_eq!((found.header, found.rows.len()), (None, 2));
        assert_eq!(parts("a,b\nc,d\n", &[]), None);
        assert_eq!(parts("", &["a"]), None);
        let found = parts("a,b\n", &["b"]).unwrap();
        assert_eq!((found.header, found.rows.len()), (Some(0), 0));
    }

    #[test]
    fn a_row_with_a_wrong_value_stays_a_row() {
        let found = parts("F,d\n1,x\n2,3\n4,\n5,error\n", &[]).unwrap();
        assert_eq!(found.rows.len(), 4);
    }

    #[test]
    fn a_row_that_was_cut_off_stays_a_row() {
        let text = "pose,F,d\nP1,1,2\nP1,2,4\nP1,3\n";
        assert_eq!(parts(text, &[]).unwrap().rows.len(), 3);
        let text = "F,d,n\n1,2,1\n2,4,1\nmaximum,2\n";
        assert_eq!(parts(text, &[]).unwrap().rows.len(), 2);
    }

    #[test]
    fn names_may_be_numbers_among_words() {
        let found = parts("time,load,1281068\ns,kN,mm\n0,1,2\n1,2,3\n", &[]).unwrap();
        assert_eq!((found.header, found.units), (Some(0), Some(1)));
        assert_eq!(parts("P1,1,2\nP1,2,4\n", &[]).unwrap().header, None);
    }

    #[test]
    fn columns_by_number_do_not_make_a_row_the_header() {
        let found = parts("t,F,d\n0,1,2\n1,2,3\n", &["2", "3"]).unwrap();
        assert_eq!((found.header, found.rows.len()), (Some(0), 2));
        let found = parts("t,F,d\n0,1,2\n1,2,3\n", &["F", "3"]).unwrap();
        assert_eq!(found.header, Some(0));
    }

    #[test]
    fn another_table_and_statistics_below_are_no_rows() {
        let text = "t,F,d\n0,1,2\n1,2,3\n2,3,4\nPeaks,,,\nF,d,a,b\n1,2,3,4\n5,6,7,8\n";
        let found = parts(text, &[]).unwrap();
        assert_eq!((found.rows.len(), found.others), (3, vec![4, 5, 6, 7]));
        let text = "t,F,d\n0,1,2\n1,2,3\nPeaks,,,2 s\nFmax,dmax,\nN,mm,mm\n1,2,3\n";
        assert_eq!(parts(text, &[]).unwrap().rows.len(), 2);
        let text = "n,F,d\n1,1,2\n2,2,3\n3,2,3\nMax,2,3\nAve,1.5,2.5\n";
        let found = parts(text, &[]).unwrap();
        assert_eq!((found.rows.len(), found.others), (3, vec![4, 5]));
        // A word that is none of statistics is a wrong value, and names of specimens are no statistics.
        assert_eq!(
            parts("n,F,d\n1,1,2\n2,2,3\nbad,2,3\n", &[])
                .unwrap()
                .rows
                .len(),
            3
        );
        assert_eq!(
            parts("n,F,d\nmax,1,2\nmin,2,3\n", &[]).unwrap().rows.len(),
            2
        );
    }

    #[test]
    fn segments_begin_with_their_names() {
        let text = "Cyclic,,,\nt,F,d\ns,N,mm\n0,1,2\n1,2,3\nCyclic data 2\nt,F,d\ns,N,mm\n2,3,4\n";
        let found = parts(text, &[]).unwrap();
        assert_eq!(found.rows, [(3, 1), (4, 1), (8, 2)]);
        assert_eq!((found.segments, found.others), (2, vec![5, 6, 7]));
    }
}
