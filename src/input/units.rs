//! Numbers with units, as scenes write them: `"0.5 mm"`, `"46 GPa"`; a bare number is in SI.
use physics::parameter::Dimension;

/// A unit is `factor` · 10^`power` of the SI unit. The power is applied to the decimal text, so that `"0.1 mm"` is the same
/// double as `1e-4`.
struct Unit {
    name: &'static str,
    dimension: Dimension,
    power: i32,
    factor: f64,
}

impl Unit {
    /// Whether this is its name, in which nobody needs to write `^`.
    fn is_called(&self, name: &str) -> bool {
        self.name.chars().filter(|c| *c != '^').eq(name.chars())
    }
}

const fn unit(name: &'static str, dimension: Dimension, power: i32, factor: f64) -> Unit {
    Unit { name, dimension, power, factor }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const KILOMETER_PER_HOUR: f64 = 1.0 / 3.6;
const MINUTE: f64 = 60.0;
const HOUR: f64 = 3600.0;
const STANDARD_GRAVITY: f64 = 9.806_65;
const TURN_PER_MINUTE: f64 = std::f64::consts::TAU / 60.0;

/// All units; the SI unit of each dimension comes first. `µ` is read as `u`, `³` and `3` as `^3`.
const UNITS: &[Unit] = &[
    unit("1", Dimension::One, 0, 1.0),
    unit("%", Dimension::One, -2, 1.0),
    unit("m", Dimension::Length, 0, 1.0),
    unit("cm", Dimension::Length, -2, 1.0),
    unit("mm", Dimension::Length, -3, 1.0),
    unit("um", Dimension::Length, -6, 1.0),
    unit("nm", Dimension::Length, -9, 1.0),
    unit("s", Dimension::Time, 0, 1.0),
    unit("ms", Dimension::Time, -3, 1.0),
    unit("us", Dimension::Time, -6, 1.0),
    unit("ns", Dimension::Time, -9, 1.0),
    unit("min", Dimension::Time, 0, MINUTE),
    unit("h", Dimension::Time, 0, HOUR),
    unit("m/s", Dimension::Velocity, 0, 1.0),
    unit("cm/s", Dimension::Velocity, -2, 1.0),
    unit("mm/ms", Dimension::Velocity, 0, 1.0),
    unit("m/ms", Dimension::Velocity, 3, 1.0),
    unit("mm/s", Dimension::Velocity, -3, 1.0),
    unit("km/s", Dimension::Velocity, 3, 1.0),
    unit("km/h", Dimension::Velocity, 0, KILOMETER_PER_HOUR),
    unit("m/s^2", Dimension::Acceleration, 0, 1.0),
    unit("mm/s^2", Dimension::Acceleration, -3, 1.0),
    unit("g", Dimension::Acceleration, 0, STANDARD_GRAVITY),
    unit("kg/m^3", Dimension::Density, 0, 1.0),
    unit("g/cm^3", Dimension::Density, 3, 1.0),
    unit("g/cc", Dimension::Density, 3, 1.0),
    unit("t/m^3", Dimension::Density, 3, 1.0),
    unit("Pa", Dimension::Stress, 0, 1.0),
    unit("kPa", Dimension::Stress, 3, 1.0),
    unit("MPa", Dimension::Stress, 6, 1.0),
    unit("GPa", Dimension::Stress, 9, 1.0),
    unit("N/mm^2", Dimension::Stress, 6, 1.0),
    unit("bar", Dimension::Stress, 5, 1.0),
    unit("N", Dimension::Force, 0, 1.0),
    unit("mN", Dimension::Force, -3, 1.0),
    unit("kN", Dimension::Force, 3, 1.0),
    unit("rad", Dimension::Angle, 0, 1.0),
    unit("deg", Dimension::Angle, 0, DEGREE),
    unit("rad/s", Dimension::AngularVelocity, 0, 1.0),
    unit("deg/s", Dimension::AngularVelocity, 0, DEGREE),
    unit("rpm", Dimension::AngularVelocity, 0, TURN_PER_MINUTE),
    unit("1/s", Dimension::Rate, 0, 1.0),
    unit("1/ms", Dimension::Rate, 3, 1.0),
];

/// The value in SI of a number with a unit.
///
/// # Errors
/// No number, no unit, an unknown unit, or one of another dimension: what is wrong, to follow "`key`".
pub fn parse(text: &str, dimension: Dimension) -> Result<f64, String> {
    let (number, name) =
        split(text).ok_or_else(|| format!("is {text:?}, which does not start with a number"))?;
    let name = name.replace(['µ', 'μ'], "u").replace('²', "2").replace('³', "3").replace('°', "deg");
    let name = name.replace('^', "");
    let what = self::name(dimension);
    match UNITS.iter().find(|unit| unit.is_called(&name) && unit.dimension == dimension) {
        Some(unit) => scaled(number, unit).ok_or_else(|| format!("is {text:?}, which is out of range")),
        None if name.is_empty() && dimension == Dimension::One => {
            scaled(number, &UNITS[0]).ok_or_else(String::new)
        }
        None if name.is_empty() => Err(format!("is {what} without a unit: {text:?}")),
        None => Err(match UNITS.iter().find(|unit| unit.is_called(&name)) {
            Some(other) => {
                format!("is {what}, but {text:?} has a unit of {}", self::name(other.dimension))
            }
            None => format!("is {what}, but {name:?} is not a unit that is known"),
        }),
    }
}

/// The longest number that the text starts with, and the rest.
fn split(text: &str) -> Option<(&str, &str)> {
    let text = text.trim();
    let is_part = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    let longest = text.find(|c| !is_part(c)).unwrap_or(text.len());
    (1..=longest)
        .rev()
        .find(|&end| text[..end].parse::<f64>().is_ok())
        .map(|end| (&text[..end], text[end..].trim_start()))
}

fn scaled(number: &str, unit: &Unit) -> Option<f64> {
    let (mantissa, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let power = exponent.parse::<i32>().ok()?.checked_add(unit.power)?;
    let value = format!("{mantissa}e{power}").parse::<f64>().ok()? * unit.factor;
    value.is_finite().then_some(value)
}

/// What a dimension measures, with its article.
pub fn name(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::One => "a pure number",
        Dimension::Length => "a length",
        Dimension::Time => "a time",
        Dimension::Velocity => "a velocity",
        Dimension::Acceleration => "an acceleration",
        Dimension::Density => "a density",
        Dimension::Stress => "a stress",
        Dimension::Force => "a force",
        Dimension::Angle => "an angle",
        Dimension::AngularVelocity => "an angular velocity",
        Dimension::Rate => "a rate",
    }
}

/// The units that a dimension accepts, the SI unit first.
pub fn accepted(dimension: Dimension) -> String {
    let names: Vec<_> = UNITS.iter().filter(|u| u.dimension == dimension).map(|u| u.name).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_units_round_once() {
        assert_eq!(parse("0.1 mm", Dimension::Length), Ok(1e-4));
        assert_eq!(parse("4.5mm", Dimension::Length), Ok(4.5e-3));
        assert_eq!(parse("1e3 µm", Dimension::Length), Ok(1e-3));
        assert_eq!(parse("46 GPa", Dimension::Stress), Ok(46e9));
        assert_eq!(parse("11.34 g/cm³", Dimension::Density), Ok(11340.0));
        for density in ["1.06 g/cm^3", "1.06 g/cc", "1.06 g/cm3", "1060 kg/m3", "1060 kg/m³", "1.06 t/m3"] {
            assert_eq!(parse(density, Dimension::Density), Ok(1060.0), "{density}");
        }
        assert_eq!(parse("45 mm/ms", Dimension::Velocity), Ok(45.0));
        assert_eq!(parse("9.81 m/s2", Dimension::Acceleration), Ok(9.81));
        assert_eq!(parse("18 N/mm²", Dimension::Stress), Ok(18e6));
        assert_eq!(parse("1.5 h", Dimension::Time), Ok(5400.0));
        assert_eq!(parse("-180 deg", Dimension::Angle), Ok(-std::f64::consts::PI));
        assert_eq!(parse("8 %", Dimension::One), Ok(0.08));
        assert_eq!(parse("0.08", Dimension::One), Ok(0.08));
    }

    #[test]
    fn wrong_units_are_named() {
        let error = |text| parse(text, Dimension::Length).expect_err("a wrong unit");
        assert!(error("0.5").contains("without a unit"));
        assert!(error("0.5 kPa").contains("unit of a stress"));
        assert!(error("0.5 furlong").contains("\"furlong\""));
        assert!(error("mm").contains("does not start with a number"));
        assert!(error("1e999 mm").contains("out of range"));
        assert!(error("inf m").contains("does not start with a number"));
        assert!(error("5 e").contains("not a unit"));
    }
}
