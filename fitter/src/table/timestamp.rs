//! Points in time as loggers write them: `2026-11-24T12:00:01.250Z`, `2026-11-24 12:00:01`, `2026/11/24 12:00:01+01:00`.

/// From so many seconds on, three thousand years, a time is none: it is a count since 1970 in a smaller unit.
const NO_SECONDS: f64 = 1e11;

/// What a count since 1970 that begins with `first` counts, in seconds, and its name; none of times in seconds.
pub(super) fn counted_unit(first: f64) -> Option<(f64, &'static str)> {
    match first {
        _ if first < NO_SECONDS => None,
        _ if first < 1e3 * NO_SECONDS => Some((1e-3, "ms")),
        _ if first < 1e6 * NO_SECONDS => Some((1e-6, "us")),
        _ => Some((1e-9, "ns")),
    }
}

/// A point in time, since 1970 in UTC. Without a zone it is taken as UTC: only differences matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Timestamp {
    /// Whole seconds.
    pub seconds: i64,
    /// What is beyond them, 0 to 1.
    pub fraction: f64,
    /// Digits of that.
    pub decimals: i32,
}

impl Timestamp {
    /// Reads one; none where the text is no date with a time of day.
    pub fn parse(text: &[u8]) -> Option<Timestamp> {
        let text = std::str::from_utf8(text).ok()?.trim().trim_matches('"');
        let (date, time) = text.split_once(['T', ' '])?;
        let mut date = date.split(['-', '/']).map(whole);
        let (year, month, day) = (date.next()??, date.next()??, date.next()??);
        if date.next().is_some() || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
            return None;
        }
        let (time, zone_s) = zone(time.trim())?;
        let mut time = time.splitn(3, ':');
        let (hour, minute) = (whole(time.next()?)?, whole(time.next()?)?);
        let (second, fraction, decimals) = match time.next() {
            None => (0, 0.0, 0),
            Some(text) => seconds(text)?,
        };
        if hour > 23 || minute > 59 || second > 60 {
            return None;
        }
        let seconds = ((days(year, month, day) * 24 + hour) * 60 + minute) * 60 + second - zone_s;
        Some(Timestamp { seconds, fraction, decimals })
    }

    /// Seconds since a whole second.
    pub fn since(self, seconds: i64) -> f64 {
        (self.seconds - seconds) as f64 + self.fraction
    }
}

/// Digits, and nothing else.
fn whole(text: &str) -> Option<i64> {
    (text.bytes().all(|sign| sign.is_ascii_digit()) && text.len() <= 4).then(|| text.parse().ok())?
}

/// Seconds with or without a fraction, behind a point or a comma.
fn seconds(text: &str) -> Option<(i64, f64, i32)> {
    match text.split_once(['.', ',']) {
        None => Some((whole(text)?, 0.0, 0)),
        Some((seconds, digits)) if digits.bytes().all(|sign| sign.is_ascii_digit()) => {
            Some((whole(seconds)?, format!("0.{digits}").parse().ok()?, digits.len() as i32))
        }
        Some(_) => None,
    }
}

/// The time of day without its zone, and the seconds by which the zone is ahead of UTC.
fn zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(at) = time.find(['+', '-']) else { return Some((time, 0)) };
    let (time, zone) = time.split_at(at);
    let digits = zone[1..].replace(':', "");
    let hours_minutes = match digits.len() {
        2 => whole(&digits)? * 100,
        4 => whole(&digits)?,
        _ => return None,
    };
    let seconds = (hours_minutes / 100 * 60 + hours_minutes % 100) * 60;
    Some((time.trim_end(), if zone.starts_with('-') { -seconds } else { seconds }))
}

/// Days from 1970-01-01 to a date of the Gregorian calendar; years begin in March, so that a leap day is their last.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    year * 365 + year.div_euclid(4) - year.div_euclid(100)
        + year.div_euclid(400)
        + (153 * month + 2) / 5
        + day
        - 719_469
}

#[cfg(test)]
mod tests {
    use super::*;

    fn since_1970(text: &str) -> Option<f64> {
        Timestamp::parse(text.as_bytes()).map(|time| time.since(0))
    }

    #[test]
    fn points_in_time_are_seconds_since_1970() {
        assert_eq!(since_1970("1970-01-01T00:00:00Z"), Some(0.0));
        assert_eq!(since_1970("2000-03-01 00:00:00"), Some(951_868_800.0));
        assert_eq!(since_1970("2026-11-24T12:00:01.25Z"), Some(1_795_521_601.25));
        assert_eq!(since_1970("2026/11/24 13:00:01,25+01:00"), Some(1_795_521_601.25));
        assert_eq!(since_1970("2026-11-24T07:30-0430"), Some(1_795_521_600.0));
        for wrong in
            ["12:00:01", "2026-11-24", "2026-13-01 00:00:00", "1.5", "2026-11-24T25:00", "a b", "é T"]
        {
            assert_eq!(since_1970(wrong), None, "{wrong}");
        }
    }
}
