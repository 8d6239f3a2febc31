//! Axes: from where to where, where the ticks are, and what they say.

/// What is along an axis: words, and the unit of its numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Quantity {
    /// In words.
    pub words: String,
    /// Its unit, for example `N` or `m/s`; empty for counts.
    pub unit: String,
}

impl Quantity {
    /// A quantity in words that name a unit, or have none.
    pub fn plain(words: &str) -> Self {
        Self { words: words.to_owned(), unit: String::new() }
    }

    /// What a column of `history.csv` holds, of its header: `drive.right.force_x_n` is a force in newtons.
    pub fn of_column(header: &str) -> Self {
        const UNITS: [(&str, &str); 17] = [
            ("_kg_m2_s", "kg m²/s"),
            ("_kg_m_s", "kg m/s"),
            ("_rad_s", "rad/s"),
            ("_n_m_s", "N m s"),
            ("_j_m_3", "J/m³"),
            ("_kg_m_3", "kg/m³"),
            ("_m_s", "m/s"),
            ("_n_m", "N m"),
            ("_n_s", "N s"),
            ("_m_3", "m³"),
            ("_rad", "rad"),
            ("_kg", "kg"),
            ("_pa", "Pa"),
            ("_n", "N"),
            ("_j", "J"),
            ("_m", "m"),
            ("_s", "s"),
        ];
        let found = UNITS.iter().find_map(|(end, unit)| Some((header.strip_suffix(end)?, *unit)));
        let (name, unit) = found.unwrap_or((header, ""));
        Self { words: name.replace('_', " "), unit: unit.to_owned() }
    }

    /// What stands along the axis, if its numbers are divided by `scale`.
    pub fn label(&self, scale: Scale) -> String {
        match (self.unit.is_empty(), scale.prefix.is_empty()) {
            (false, _) => format!("{} [{}{}]", self.words, scale.prefix, self.unit),
            (true, false) => format!("{} [{}]", self.words, scale.prefix),
            (true, true) => self.words.clone(),
        }
    }

    /// How numbers up to `most` are best written.
    pub fn scale(&self, most: f64) -> Scale {
        const PREFIXES: [(i32, &str); 9] =
            [(-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G"), (12, "T")];
        let most = most.abs();
        if !(most > 0.0 && most.is_finite()) {
            return Scale::ONE;
        }
        let exponent = (most * (1.0 + 1e-9)).log10().floor() as i32;
        // units with a power or a prefix of their own take none
        let takes = ["N", "J", "m/s", "Pa", "m", "s", "N m", "N s", "J/m³"].contains(&self.unit.as_str());
        let three = 3 * exponent.div_euclid(3);
        match PREFIXES.iter().find(|(power, _)| *power == three) {
            Some(&(power, prefix)) if takes => Scale { one: 10f64.powi(power), prefix: prefix.to_owned() },
            _ if (-3..5).contains(&exponent) => Scale::ONE,
            _ => {
                let space = if self.unit.is_empty() { "" } else { " " };
                Scale { one: 10f64.powi(exponent), prefix: format!("{}{space}", ten_to(exponent)) }
            }
        }
    }
}

/// How numbers are written: divided by `one`, with a prefix to the unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// What is 1 then.
    pub one: f64,
    /// What stands before the unit.
    pub prefix: String,
}

impl Scale {
    /// As they are.
    pub const ONE: Self = Self { one: 1.0, prefix: String::new() };
}

/// A power of ten in words.
fn ten_to(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// Units of time, the longest first.
pub const SECONDS: [(f64, &str); 4] = [(1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns")];

/// The first unit that a number reaches, rounded to so many digits; else the last.
pub fn unit_of<'a>(x: f64, units: &[(f64, &'a str)], digits: i32) -> (f64, &'a str) {
    let rounded = 1.0 - 0.5 * 10f64.powi(-digits);
    let reached = units.iter().find(|unit| x.abs() >= unit.0 * rounded);
    if x == 0.0 { units[0] } else { *reached.unwrap_or(&units[units.len() - 1]) }
}

/// A number in that unit.
pub fn in_unit(x: f64, units: &[(f64, &str)], digits: i32) -> String {
    let (one, name) = unit_of(x, units, digits);
    format!("{} {name}", short(x / one, digits))
}

/// Whether a number can be on an axis.
pub fn fits(x: f64, log: bool) -> bool {
    x.is_finite() && (!log || x > 0.0)
}

/// An axis: from and to, logarithmic or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Its lower end.
    pub from: f64,
    /// Its upper end.
    pub to: f64,
    /// Whether it is logarithmic.
    pub log: bool,
}

/// A tick: where, and what it says; nothing for the small ones between.
pub type Tick = (f64, String);

impl Axis {
    /// An axis on which all finite values lie; of a logarithmic one, those above zero. A linear one has zero on it, if
    /// `zero` or if that is near.
    pub fn of(values: impl Iterator<Item = f64>, log: bool, zero: bool) -> Self {
        let ok = values.filter(|x| fits(*x, log));
        let (low, high) = ok.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        match (low <= high, log) {
            (false, true) => Self { from: 1.0, to: 10.0, log },
            (false, false) => Self { from: 0.0, to: 1.0, log },
            (true, true) => Self { from: low / 1.15, to: high * 1.15, log },
            (true, false) => {
                let near = zero || low.abs().min(high.abs()) < 0.5 * (high - low);
                let (low, high) = if near { (low.min(0.0), high.max(0.0)) } else { (low, high) };
                // a constant has some room about it
                let span = if high > low { high - low } else { low.abs().max(1.0) };
                let room = 0.05 * span;
                let end = |x: f64, step: f64| if x == 0.0 && high > low { 0.0 } else { x + step };
                Self { from: end(low, -room), to: end(high, room), log }
            }
        }
    }

    /// Where a value is, from 0 to 1.
    pub fn at(self, x: f64) -> f64 {
        match self.log {
            true => (x / self.from).ln() / (self.to / self.from).ln(),
            false => (x - self.from) / (self.to - self.from),
        }
    }

    /// Ticks, about `count` of them with words; numbers are divided by `one` (of [`Scale`]).
    pub fn ticks(self, count: usize, one: f64) -> Vec<Tick> {
        if self.log { self.powers(count, one) } else { self.steps(count, one) }
    }

    fn steps(self, count: usize, one: f64) -> Vec<Tick> {
        let rough = (self.to - self.from) / one / count.max(1) as f64;
        let unit = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * unit).find(|s| *s >= rough).unwrap_or(rough);
        let (first, last) = ((self.from / one / step).ceil() as i64, (self.to / one / step).floor() as i64);
        let digits = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        (first..=last)
            .map(|n| (n as f64 * step * one, minus(format!("{:.digits$}", n as f64 * step))))
            .collect()
    }

    /// Powers of ten, with small ticks between; where there are less than two powers, between them, too, with words.
    fn powers(self, count: usize, one: f64) -> Vec<Tick> {
        let (low, high) = (self.from / one, self.to / one);
        let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let on = |x: f64| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(&x);
        let powers = (first..=last).filter(|e| on(10f64.powi(*e))).count();
        if powers < 2 && high / low < 3.0 {
            // less than a third of a decade: equal steps
            return Self { log: false, ..self }.steps(count, one);
        }
        let every = powers.div_ceil(count.max(1)).max(1) as i32;
        // all in digits, or all as powers
        let plain = first >= -4 && last <= 4;
        let worded: &[u32] = if powers < 2 {
            &[1, 2, 3, 5]
        } else if powers < 3 {
            &[1, 2, 5]
        } else {
            &[1]
        };
        let all = (first..=last).flat_map(|e| (1..10u32).map(move |m| (e, m)));
        let tick = |(e, m): (i32, u32)| {
            let x = f64::from(m) * 10f64.powi(e);
            let says = worded.contains(&m) && (e.rem_euclid(every) == 0 || m > 1);
            on(x).then(|| (x * one, if says { power(e, m, plain) } else { String::new() }))
        };
        all.filter_map(tick).filter(|(_, words)| every == 1 || !words.is_empty()).collect()
    }
}

/// `m` times a power of ten in words: in digits, if it is to be `plain`.
fn power(exponent: i32, m: u32, plain: bool) -> String {
    match exponent {
        -4..=-1 if plain => format!("{:.*}", -exponent as usize, f64::from(m) * 10f64.powi(exponent)),
        0..=4 if plain => format!("{}", u64::from(m) * 10u64.pow(exponent as u32)),
        _ => {
            let power = ten_to(exponent);
            if m == 1 { power } else { format!("{m}·{power}") }
        }
    }
}

/// A number with the sign that type has for it; no minus before zero.
pub fn minus(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// Some digits, without zeros at the end.
pub fn short(x: f64, digits: i32) -> String {
    let places =
        if x == 0.0 { 0 } else { (digits - 1 - x.abs().log10().floor() as i32).clamp(0, 12) as usize };
    let text = format!("{x:.places$}");
    minus(if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text })
}

/// The next 1, 2 or 5 times a power of ten.
pub fn round_up(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&y| y >= x * (1.0 - 1e-9)).unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_words_units_and_prefixes() {
        let force = Quantity::of_column("drive.right.force_x_n");
        assert_eq!((force.words.as_str(), force.unit.as_str()), ("drive.right.force x", "N"));
        let label = |header: &str, most: f64| {
            let it = Quantity::of_column(header);
            it.label(it.scale(most))
        };
        assert_eq!(label("drive.right.force_x_n", 2.5e-3), "drive.right.force x [mN]");
        assert_eq!(label("time_s", 8e-4), "time [µs]");
        assert_eq!(label("lead.mean_velocity_y_m_s", 47.0), "lead.mean velocity y [m/s]");
        assert_eq!(label("rigid.rod.torque_x_n_m", 4.2e-7), "rigid.rod.torque x [nN m]");
        assert_eq!(label("kinetic_j", 1000.0), "kinetic [kJ]");
        assert_eq!(label("tissue.failed_matrix", 12.0), "tissue.failed matrix");
        assert_eq!(label("mass_kg", 2e-6), "mass [10⁻⁶ kg]");
        assert_eq!(Quantity::default().label(Quantity::default().scale(0.0)), "");
    }

    #[test]
    fn every_axis_has_words() {
        let ranges = [
            (1.0, 2.0),
            (3.0, 3.0),
            (0.2, 90.0),
            (1e-9, 1e12),
            (1.0, 1.01),
            (4.0, 7.0),
            (2.0, 11.0),
            (8e-4, 1.3),
        ];
        for (low, high) in ranges {
            for log in [true, false] {
                let axis = Axis::of([low, high].into_iter(), log, false);
                let ticks = axis.ticks(5, 1.0);
                let words: Vec<&str> = ticks.iter().map(|t| t.1.as_str()).filter(|w| !w.is_empty()).collect();
                assert!((2..=12).contains(&words.len()), "{low} to {high}, log {log}: {words:?}");
                assert!(ticks.iter().all(|(x, _)| (-1e-9..=1.0 + 1e-9).contains(&axis.at(*x))), "{ticks:?}");
                let mut apart = words.clone();
                apart.dedup();
                assert_eq!(apart, words, "{low} to {high}");
            }
        }
        let none = Axis::of(std::iter::empty(), false, true);
        assert_eq!((none.from, none.to), (0.0, 1.0));
        assert_eq!(
            (power(2, 5, true), power(-4, 1, false), power(7, 2, false)),
            ("500".into(), "10⁻⁴".into(), "2·10⁷".into())
        );
        assert_eq!(
            (short(-0.00123, 3), short(1500.0, 4), minus("-0.0".into())),
            ("−0.00123".into(), "1500".into(), "0.0".into())
        );
    }
}
