//! Numbers as people read them.

/// An integer with separators between thousands: `1,234,567`.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> = (0..digits.len().div_ceil(3))
        .rev()
        .map(|g| &digits[digits.len().saturating_sub(3 * (g + 1))..digits.len() - 3 * g])
        .collect();
    groups.join(",")
}

/// A number and its noun, which takes an s unless the number is 1: `1 cell`, `1,024 cells`.
pub fn counted(n: usize, noun: &str) -> String {
    match n {
        1 => format!("1 {noun}"),
        _ => format!("{} {noun}s", count(n)),
    }
}

/// A size in memory with decimal units: `604 MB`, `1.2 GB`.
pub fn bytes(n: f64) -> String {
    const UNITS: [&str; 5] = ["B", "kB", "MB", "GB", "TB"];
    let power = UNITS.len().min(1 + (n.max(1.0).log10() / 3.0) as usize) - 1;
    let value = n / 1e3f64.powi(power as i32);
    match value < 9.95 && power > 0 {
        true => format!("{value:.1} {}", UNITS[power]),
        false => format!("{value:.0} {}", UNITS[power]),
    }
}

/// A duration: `5 µs`, `1.2 ms`, `3.2 s`, `4 min 10 s`.
pub fn seconds(s: f64) -> String {
    match s {
        s if s < 1e-3 => format!("{:.0} µs", 1e6 * s),
        s if s < 0.1 => format!("{:.1} ms", 1e3 * s),
        s if s < 100.0 => format!("{s:.1} s"),
        s => format!("{:.0} min {:.0} s", (s / 60.0).floor(), s % 60.0),
    }
}

/// A number with the digits that matter: four, without trailing zeros; powers of ten for the very large and small.
pub fn number(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e5 {
        return format!("{x:.0}");
    }
    match x.abs() {
        a if (1e-3..1e5).contains(&a) => {
            let decimals = (3 - a.log10().floor() as i32).max(0) as usize;
            trimmed(&format!("{x:.decimals$}")).into()
        }
        _ => {
            let text = format!("{x:.3e}");
            match text.split_once('e') {
                Some((mantissa, exponent)) => format!("{}e{exponent}", trimmed(mantissa)),
                None => text,
            }
        }
    }
}

fn trimmed(digits: &str) -> &str {
    match digits.contains('.') {
        true => digits.trim_end_matches('0').trim_end_matches('.'),
        false => digits,
    }
}

/// Three numbers: `0.366 × 0.303 × 0.336`.
pub fn triple(x: [f64; 3]) -> String {
    x.map(number).join(" × ")
}

/// Three counts: `122 × 101 × 112`.
pub fn triple_count(n: [usize; 3]) -> String {
    n.map(count).join(" × ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_separated() {
        assert_eq!([0, 999, 1000, 1234567].map(count), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([counted(1, "cell"), counted(1024, "cell")], ["1 cell", "1,024 cells"]);
    }

    #[test]
    fn sizes_and_times_have_the_unit_that_fits() {
        assert_eq!([0.0, 999.0, 1500.0, 6.04e8, 1.2e10].map(bytes), ["0 B", "999 B", "1.5 kB", "604 MB", "12 GB"]);
        assert_eq!([5e-6, 0.0012, 3.21, 250.0].map(seconds), ["5 µs", "1.2 ms", "3.2 s", "4 min 10 s"]);
    }

    #[test]
    fn numbers_keep_four_digits() {
        let shown = [0.003, 0.366, -1207.0, 1.23456, 5e6, 0.45, 1.5e-7, 123.456].map(number);
        assert_eq!(shown, ["0.003", "0.366", "-1207", "1.235", "5e6", "0.45", "1.5e-7", "123.5"]);
    }
}
