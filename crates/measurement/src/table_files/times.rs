//! Dates and times of day, turned into seconds since the first.

/// A point in time as a cell states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeStamp {
    date: StampedDate,
    /// Seconds since midnight, or since any zero where there is no date.
    seconds: f64,
    kind: StampKind,
}

/// What a cell states of a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StampKind {
    /// A date without a time of day.
    Date,
    /// A time of day, or one since any zero.
    TimeOfDay,
    /// Both.
    DateAndTime,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StampedDate {
    /// No date.
    None,
    /// Days since some day.
    Day(i64),
    /// Two numbers and a year in the order of the file: day and month, or month and day.
    Either([i8; 2], i16),
}

const DAY_S: f64 = 86_400.0;

impl TimeStamp {
    /// `2024-01-31T10:05:00.25+01:00`, `2024-01-31 10:05`, `31.01.2024 10:05:00,25`, `1/31/2024 10:05:00 AM`, `31.01.24`, `10:05:00.25`, `10:05 PM`.
    pub(super) fn parse(text: &str) -> Option<Self> {
        if text.len() < 4 || !text.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        if let Some(seconds) = zoned_clock(text) {
            return Some(Self {
                date: StampedDate::None,
                seconds,
                kind: StampKind::TimeOfDay,
            });
        }
        let end = text.find(['T', 't', ' ']).unwrap_or(text.len());
        let date = date(&text[..end])?;
        let rest = text[end..].trim_start_matches(['T', 't', ' ']);
        let (seconds, kind) = if rest.is_empty() {
            (0.0, StampKind::Date)
        } else {
            (zoned_clock(rest)?, StampKind::DateAndTime)
        };
        Some(Self {
            date,
            seconds,
            kind,
        })
    }

    pub(super) fn kind(self) -> StampKind {
        self.kind
    }
}

fn date(text: &str) -> Option<StampedDate> {
    let sign = ['-', '.', '/']
        .into_iter()
        .find(|sign| text.contains(*sign))?;
    let mut parts = text.split(sign);
    let (a, b, c) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() {
        return None;
    }
    let small = |text: &str| (text.len() <= 2).then(|| text.parse::<i8>().ok()).flatten();
    let whole_year = |text: &str| {
        (text.len() == 4)
            .then(|| text.parse::<i16>().ok())
            .flatten()
    };
    if let Some(year) = whole_year(a) {
        return day(year, small(b)?, small(c)?);
    }
    // `31.01.24`; with hyphens the year may come first.
    let short_year = |text: &str| {
        let short = text.len() == 2 && sign != '-';
        short
            .then(|| Some(2000 + text.parse::<i16>().ok()?))
            .flatten()
    };
    let year = |text: &str| whole_year(text).or_else(|| short_year(text));
    let (first, second, year) = (small(a)?, small(b)?, year(c)?);
    if sign == '.' {
        return day(year, second, first);
    }
    day(year, second, first).or_else(|| day(year, first, second))?;
    Some(StampedDate::Either([first, second], year))
}

fn day(year: i16, month: i8, day: i8) -> Option<StampedDate> {
    let date = jiff::civil::Date::new(year, month, day).ok()?;
    let since = date.since(jiff::civil::Date::constant(1970, 1, 1)).ok()?;
    Some(StampedDate::Day(since.get_days().into()))
}

/// A clock with a zone (`Z`, `+01:00`) or a half of the day (`AM`, `PM`) behind it.
fn zoned_clock(text: &str) -> Option<f64> {
    let upper = text.to_ascii_uppercase();
    for (half, shift) in [("AM", 0.0), ("PM", 12.0 * 3600.0)] {
        if let Some(rest) = upper.strip_suffix(half) {
            let seconds = clock(rest.trim_end())?;
            let noon = if (12.0 * 3600.0..13.0 * 3600.0).contains(&seconds) {
                12.0 * 3600.0
            } else {
                0.0
            };
            return Some(seconds - noon + shift);
        }
    }
    if let Some(rest) = upper.strip_suffix('Z') {
        return clock(rest);
    }
    match text.rfind(['+', '-']) {
        Some(place) => {
            let offset = &text[place + 1..];
            let seconds = match offset.len() {
                2 => offset
                    .parse::<u32>()
                    .ok()
                    .map(|hours| f64::from(hours) * 3600.0)?,
                4 => {
                    let number: u32 = offset.parse().ok()?;
                    f64::from(number / 100) * 3600.0 + f64::from(number % 100) * 60.0
                }
                _ => clock(offset)?,
            };
            let sign = if text[place..].starts_with('-') {
                1.0
            } else {
                -1.0
            };
            Some(clock(&text[..place])? + sign * seconds)
        }
        None => clock(text),
    }
}

/// `10:05`, `10:05:00.25`, `36:00:00`: seconds.
fn clock(text: &str) -> Option<f64> {
    let mut parts = text.split(':');
    let (hours, minutes, seconds) = (parts.next()?, parts.next()?, parts.next());
    if parts.next().is_some() {
        return None;
    }
    let whole = |text: &str, most: usize| {
        let is_whole = (1..=most).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
        is_whole.then(|| text.parse::<u32>().ok()).flatten()
    };
    let (hours, minutes) = (whole(hours, 4)?, whole(minutes, 2).filter(|m| *m < 60)?);
    let seconds = match seconds {
        None => 0.0,
        Some(text) => {
            let plain = text.replace(',', ".");
            let (head, _) = plain.split_once('.').unwrap_or((&plain, ""));
            whole(head, 2).filter(|s| *s < 61)?;
            if !plain.bytes().all(|b| b.is_ascii_digit() || b == b'.') {
                return None;
            }
            plain.parse::<f64>().ok()?
        }
    };
    Some(f64::from(hours) * 3600.0 + f64::from(minutes) * 60.0 + seconds)
}

/// Why times of a column could not be put on one scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StampFault {
    /// This cell is no time, or not of the same form as the first.
    NotATime(usize),
    /// From this cell on the date changes, and nothing shows whether days or months come first.
    DayOrMonth(usize),
}

/// Seconds since the first time of a column; `None` for cells without one.
///
/// Times of day without a date that fall back by more than half a day have passed midnight.
pub(super) fn seconds_since_first<'a>(
    cells: impl Iterator<Item = Option<&'a str>>,
) -> Result<Vec<Option<f64>>, StampFault> {
    let mut stamps = Vec::new();
    for (index, cell) in cells.enumerate() {
        let stamp = cell.map(|text| TimeStamp::parse(text).ok_or(StampFault::NotATime(index)));
        stamps.push(stamp.transpose()?);
    }
    let month_first = month_first(&stamps)?;
    let mut first: Option<(Option<i64>, f64)> = None;
    let mut before = f64::NEG_INFINITY;
    let mut midnights = 0.0;
    let mut out = Vec::with_capacity(stamps.len());
    for (index, stamp) in stamps.iter().enumerate() {
        let Some(stamp) = stamp else {
            out.push(None);
            continue;
        };
        let number = match stamp.date {
            StampedDate::None => None,
            StampedDate::Day(number) => Some(number),
            StampedDate::Either([a, b], year) => {
                let [d, m] = if month_first { [b, a] } else { [a, b] };
                match day(year, m, d) {
                    Some(StampedDate::Day(number)) => Some(number),
                    _ => return Err(StampFault::NotATime(index)),
                }
            }
        };
        if number.is_none() && before - stamp.seconds > DAY_S / 2.0 {
            midnights += 1.0;
        }
        before = stamp.seconds;
        let (first_day, first_seconds) = *first.get_or_insert((number, stamp.seconds));
        let days = match (number, first_day) {
            (Some(now), Some(then)) => (now - then) as f64,
            (None, None) => midnights,
            _ => return Err(StampFault::NotATime(index)),
        };
        out.push(Some(days * DAY_S + (stamp.seconds - first_seconds)));
    }
    Ok(out)
}

/// Whether months come before days in dates such as 1/31/2024; any answer where the date is the same throughout.
fn month_first(stamps: &[Option<TimeStamp>]) -> Result<bool, StampFault> {
    let either =
        stamps
            .iter()
            .enumerate()
            .filter_map(|(index, stamp)| match stamp.as_ref()?.date {
                StampedDate::Either(pair, year) => Some((index, pair, year)),
                _ => None,
            });
    let mut first = None;
    let mut changed = None;
    for (index, pair, year) in either {
        if pair[0] > 12 {
            return Ok(false);
        }
        if pair[1] > 12 {
            return Ok(true);
        }
        if *first.get_or_insert((pair, year)) != (pair, year) {
            changed.get_or_insert(index);
        }
    }
    changed.map_or(Ok(true), |index| Err(StampFault::DayOrMonth(index)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn since(cells: &[&str]) -> Result<Vec<Option<f64>>, StampFault> {
        seconds_since_first(cells.iter().map(|c| Some(*c).filter(|c| !c.is_empty())))
    }

    #[test]
    fn times_become_seconds_since_the_first() {
        for cells in [
            ["2024-02-28T23:59:59Z", "2024-02-29T00:00:00.5Z"],
            ["2024-02-28T23:59:59+01:00", "2024-02-28T23:00:00.5Z"],
            ["2024-02-28 23:59:59", "2024-02-29 00:00:00,5"],
            ["28.02.2024 23:59:59", "29.02.2024 00:00:00,5"],
            ["2/28/2024 11:59:59 PM", "2/29/2024 12:00:00.5 AM"],
            ["28/2/2024 23:59:59", "29/2/2024 00:00:00.5"],
            ["2024/02/28 23:59:59", "2024/02/29 0:00:00.5"],
            ["28.02.24 23:59:59", "29.02.24 00:00:00.5"],
            ["11:59:59 PM", "12:00:00.5 AM"],
            ["23:59:59", "00:00:00.5"],
            ["0:01:02.5", "0:01:04"],
        ] {
            assert_eq!(since(&cells), Ok(vec![Some(0.0), Some(1.5)]), "{cells:?}");
        }
        assert_eq!(
            since(&["10:00", "", "10:01"]),
            Ok(vec![Some(0.0), None, Some(60.0)])
        );
        // 12:30 in the night and at noon.
        assert_eq!(
            since(&["1/2/2024 12:30:00 AM", "1/2/2024 12:30:00 PM"]),
            Ok(vec![Some(0.0), Some(43_200.0)])
        );
    }

    #[test]
    fn what_has_no_one_meaning_is_refused() {
        assert_eq!(
            since(&["1/2/2024 10:00", "2/2/2024 10:00"]),
            Err(StampFault::DayOrMonth(1))
        );
        assert_eq!(since(&["10:00", "later"]), Err(StampFault::NotATime(1)));
        assert_eq!(
            since(&["2024-01-01 10:00", "10:01"]),
            Err(StampFault::NotATime(1))
        );
        for text in [
            "2024-13-01",
            "1.5",
            "10:60",
            "1:2:3:4",
            "12.5.3",
            "2024",
            "10:00:61.5",
            "31.02.2024",
        ] {
            assert_eq!(TimeStamp::parse(text), None, "{text}");
        }
    }
}
