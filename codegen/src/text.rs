//! Numbers as text for heads and sources. A stated bound is never rounded down.

/// Three significant digits, rounded up: `9.15e-5`.
pub fn rounded_up(value: f64) -> String {
    rounded(value, |shown| shown < value, 1.0)
}

/// Three significant digits, rounded down.
pub fn rounded_down(value: f64) -> String {
    rounded(value, |shown| shown > value, -1.0)
}

/// The nearest number of three digits, or the one a unit further where that is wrong.
fn rounded(value: f64, wrong: impl Fn(f64) -> bool, further: f64) -> String {
    if value <= 0.0 {
        return "0".into();
    }
    let nearest = format!("{value:.2e}");
    match nearest.parse::<f64>() {
        Ok(shown) if wrong(shown) => {
            let exponent = nearest.rsplit('e').next().and_then(|e| e.parse::<i32>().ok()).unwrap_or(0);
            let unit = format!("1e{}", exponent - 2).parse::<f64>().unwrap_or(0.0);
            format!("{:.2e}", shown + further * unit)
        }
        _ => nearest,
    }
}

/// Decimal digits in groups of three: `-346_002_501`.
pub fn grouped(value: i64) -> String {
    let digits = value.unsigned_abs().to_string();
    let groups: Vec<&str> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(|group| std::str::from_utf8(group).unwrap_or_default())
        .collect();
    format!("{}{}", if value < 0 { "-" } else { "" }, groups.join("_"))
}

/// `corrected_angle_q31` as the name of a type: `CorrectedAngleQ31`.
pub fn camel_case(name: &str) -> String {
    name.split('_')
        .map(|word| {
            let mut letters = word.chars();
            letters
                .next()
                .map_or_else(String::new, |first| first.to_ascii_uppercase().to_string() + letters.as_str())
        })
        .collect()
}

/// The exact hexadecimal form of C99, without a suffix: `-0x1.8cp-3`.
pub fn float_hex(value: f64) -> String {
    let bits = value.abs().to_bits();
    let sign = if value.is_sign_negative() { "-" } else { "" };
    let fraction = format!("{:013x}", bits & ((1 << 52) - 1));
    let digits = fraction.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    match (bits >> 52) as i32 {
        0 if digits.is_empty() => format!("{sign}0.0"),
        0 => format!("{sign}0x0.{digits}p-1022"),
        exponent => format!("{sign}0x1{point}{digits}p{}", exponent - 1023),
    }
}

/// Text as comment lines, each with `mark` in front and no space at the end.
pub fn comment(text: &str, mark: &str) -> String {
    text.trim_end()
        .lines()
        .map(|line| format!("{mark} {line}").trim_end().to_string())
        .collect::<Vec<_>>()
        .join("\n")
}

/// Text in lines of at most so many columns where the words allow, each behind `indent`.
pub fn wrapped(text: &str, columns: usize, indent: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= columns => {
                *line += " ";
                *line += word;
            }
            _ => lines.push(format!("{indent}{word}")),
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn hexadecimal_floats() {
        assert_eq!(float_hex(1.0), "0x1p0");
        assert_eq!(float_hex(-0.1875), "-0x1.8p-3");
        assert_eq!(float_hex(0.0), "0.0");
        assert_eq!(float_hex(f32::from_bits(1).into()), "0x1p-149");
        assert_eq!(float_hex(f64::from_bits(1)), "0x0.0000000000001p-1022");
    }

    #[test]
    fn groups_of_three() {
        assert_eq!(grouped(-346_002_501), "-346_002_501");
        assert_eq!(grouped(12), "12");
        assert_eq!(grouped(1_000), "1_000");
    }

    #[test]
    fn words_fill_lines() {
        assert_eq!(wrapped("one two  three\nfour", 10, "  "), "  one two\n  three\n  four");
        assert_eq!(wrapped("", 10, "  "), "");
        assert_eq!(wrapped("unbreakable", 4, ""), "unbreakable");
    }

    proptest! {
        #[test]
        fn a_bound_is_never_rounded_down(value in 1e-30..1e6f64) {
            let shown: f64 = rounded_up(value).parse().unwrap();
            prop_assert!(shown >= value && shown <= value * 1.011);
            let below: f64 = rounded_down(value).parse().unwrap();
            prop_assert!(below <= value && below >= value * 0.989);
        }
    }
}
