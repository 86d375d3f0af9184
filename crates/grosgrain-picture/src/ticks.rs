//! Axis ticks at nice numbers, and their labels.

/// Ticks of an axis or a colour bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    /// Positions, ascending.
    pub values: Vec<f64>,
    /// One label per position.
    pub labels: Vec<String>,
    /// The labels are the values divided by `10^exponent`.
    pub exponent: i32,
}

impl Ticks {
    /// Multiples of a step 1, 2, 2.5 or 5 times a power of ten within `[low, high]`, at most `most` of them.
    ///
    /// The exponent is a multiple of three, and zero where the labels stay short without it.
    pub fn linear(low: f64, high: f64, most: usize) -> Self {
        let step = nice_step((high - low).abs(), most);
        let slack = 1e-9 * step;
        let first = ((low - slack) / step).ceil() as i64;
        let last = ((high + slack) / step).floor() as i64;
        let values: Vec<f64> = (first..=last).map(|i| i as f64 * step).collect();
        let largest = low.abs().max(high.abs());
        let exponent = shared_exponent(largest);
        let decimals = decimals(step / 10f64.powi(exponent));
        let labels = values.iter().map(|v| fixed(v / 10f64.powi(exponent), decimals)).collect();
        Self { values, labels, exponent }
    }

    /// The whole numbers within `[low, high]`.
    pub fn whole(low: f64, high: f64) -> Self {
        let values: Vec<f64> = (low.ceil() as i64..=high.floor() as i64).map(|i| i as f64).collect();
        let labels = values.iter().map(|value| fixed(*value, 0)).collect();
        Self { values, labels, exponent: 0 }
    }

    /// Powers of ten within `[low, high]`, both positive; every n-th where there are more than `most`,
    /// with 2 and 5 times a power between where there are few.
    pub fn logarithmic(low: f64, high: f64, most: usize) -> Self {
        if (high / low).log10() < 0.4 * most as f64 {
            return Self::one_two_five(low, high);
        }
        let (first, last) = ((low.log10() - 1e-9).ceil() as i32, (high.log10() + 1e-9).floor() as i32);
        let every = ((last - first + 1).max(1) as usize).div_ceil(most.max(1));
        let powers: Vec<i32> = (first..=last).step_by(every).collect();
        Self {
            values: powers.iter().map(|p| 10f64.powi(*p)).collect(),
            labels: powers.iter().map(|p| power_label(*p)).collect(),
            exponent: 0,
        }
    }

    fn one_two_five(low: f64, high: f64) -> Self {
        let powers = (low.log10() - 1.0).floor() as i32..=high.log10().ceil() as i32;
        let multiples = powers.flat_map(|p| [(1, p), (2, p), (5, p)]);
        let value = |&(m, p): &(i32, i32)| f64::from(m) * 10f64.powi(p);
        let inside = |mp: &(i32, i32)| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(&value(mp));
        let kept: Vec<(i32, i32)> = multiples.filter(inside).collect();
        let label = |&(m, p): &(i32, i32)| match (m, p) {
            (1, p) => power_label(p),
            (m, -2..=4) => fixed(value(&(m, p)), p.min(0).unsigned_abs() as usize),
            (m, p) => format!("{m}·10{}", superscript(p)),
        };
        Self { values: kept.iter().map(value).collect(), labels: kept.iter().map(label).collect(), exponent: 0 }
    }

    /// `text` with the shared power of ten: `u [10⁻³ m]` for `u [m]`, `error · 10⁻³` where there is no unit.
    pub fn with_exponent(&self, text: &str) -> String {
        if self.exponent == 0 {
            return text.to_owned();
        }
        let power = format!("10{}", superscript(self.exponent));
        match text.rfind('[') {
            Some(at) => format!("{}[{power} {}", &text[..at], &text[at + 1..]),
            None => format!("{text} [{power}]"),
        }
    }
}

/// The range widened outwards to whole steps of its own ticks, so that both ends carry a tick.
pub(crate) fn nice_range(low: f64, high: f64, most: usize) -> (f64, f64) {
    let (low, high) = widen(low, high);
    let step = nice_step(high - low, most);
    (((low / step) + 1e-9).floor() * step, ((high / step) - 1e-9).ceil() * step)
}

/// A range with extent: a single value becomes one from zero to it, or around it.
pub(crate) fn widen(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    match high - low > 1e-12 * size {
        true => (low, high),
        false if size == 0.0 => (0.0, 1.0),
        false => (low.min(0.0), high.max(0.0)),
    }
}

fn nice_step(extent: f64, most: usize) -> f64 {
    let raw = extent / most.saturating_sub(1).max(1) as f64;
    if !(raw > 0.0 && raw.is_finite()) {
        return 1.0;
    }
    let power = 10f64.powi(raw.log10().floor() as i32);
    let factor = [1.0, 2.0, 2.5, 5.0].into_iter().find(|f| f * power >= raw * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

fn shared_exponent(largest: f64) -> i32 {
    if largest == 0.0 || (0.01..100_000.0).contains(&largest) {
        return 0;
    }
    3 * (largest.log10() / 3.0).floor() as i32
}

fn decimals(step: f64) -> usize {
    (0..9).find(|d| (step * 10f64.powi(*d) - (step * 10f64.powi(*d)).round()).abs() < 1e-6).unwrap_or(9) as usize
}

fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        None => text,
        Some(digits) if digits.chars().all(|c| c == '0' || c == '.') => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
    }
}

fn power_label(power: i32) -> String {
    match power {
        -2..=0 => fixed(10f64.powi(power), power.unsigned_abs() as usize),
        1..=4 => format!("{}", 10i64.pow(power.unsigned_abs())),
        _ => format!("10{}", superscript(power)),
    }
}

fn superscript(number: i32) -> String {
    let raise = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' => '⁰',
        c => char::from_u32(c as u32 - '4' as u32 + '⁴' as u32).unwrap_or(c),
    };
    number.to_string().chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_ticks_are_the_whole_numbers_in_the_range() {
        let ticks = Ticks::whole(1.5, 4.0);
        assert_eq!((ticks.values, ticks.exponent), (vec![2.0, 3.0, 4.0], 0));
        assert_eq!(ticks.labels, ["2", "3", "4"]);
        assert_eq!(Ticks::whole(2.0, 2.0).values, [2.0]);
    }

    #[test]
    fn ticks_are_nice_numbers_inside_the_range() {
        assert_eq!(Ticks::linear(0.0, 1.0, 6).labels, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(Ticks::linear(0.13, 8.7, 6).labels, ["2", "4", "6", "8"]);
        assert_eq!(Ticks::linear(-5.0, 5.0, 5).labels, ["−5.0", "−2.5", "0.0", "2.5", "5.0"]);
    }

    #[test]
    fn never_more_ticks_than_asked_for() {
        for i in 1..2000 {
            let (low, high) = (-(f64::from(i) * 0.7).sin(), f64::from(i).powf(1.7));
            let ticks = Ticks::linear(low, high, 6);
            assert!((2..=6).contains(&ticks.values.len()), "{low} {high}: {:?}", ticks.labels);
        }
    }

    #[test]
    fn small_and_large_values_share_a_power_of_ten() {
        let ticks = Ticks::linear(0.0, 0.0012, 5);
        assert_eq!((ticks.exponent, ticks.with_exponent("|u| [m]").as_str()), (-3, "|u| [10⁻³ m]"));
        assert_eq!(ticks.labels, ["0.0", "0.5", "1.0"]);
        let ticks = Ticks::linear(0.0, 4e6, 5);
        assert_eq!((ticks.exponent, ticks.with_exponent("stress").as_str()), (6, "stress [10⁶]"));
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten() {
        assert_eq!(Ticks::logarithmic(0.005, 120.0, 8).labels, ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(Ticks::logarithmic(0.04, 3.0, 7).labels, ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(Ticks::logarithmic(1e-8, 1e8, 5).labels, ["10⁻⁸", "10⁻⁴", "1", "10000", "10⁸"]);
    }

    #[test]
    fn a_nice_range_encloses_its_data_and_ends_on_ticks() {
        assert_eq!(nice_range(0.0, 8.7, 6), (0.0, 10.0));
        assert_eq!(nice_range(0.0, 10.0, 6), (0.0, 10.0));
        assert_eq!(nice_range(0.0, 0.0, 6), (0.0, 1.0));
        assert_eq!(nice_range(3.0, 3.0, 6), (0.0, 3.0));
    }
}
