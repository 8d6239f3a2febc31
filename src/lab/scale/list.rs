//! Lists on a command line: what to measure.
use scene::Patches;

/// The most of anything that is counted on a command line: eight times the product of two of them is a number, and ranks
/// are numbered by 32 bits.
pub const MOST: usize = 1 << 24;

fn one_of_patches(text: &str) -> Result<Patches, String> {
    let parts: Vec<&str> = text.split(['x', 'X']).collect();
    match parts[..] {
        [one] => Ok(Patches::Total(positive(one)?)),
        [x, y, z] => Ok(Patches::Grid([positive(x)?, positive(y)?, positive(z)?])),
        _ => Err(format!("{text:?} is neither a number of patches, such as 8, nor AxBxC, such as 2x2x2")),
    }
}

fn positive(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(0) => Err("0 is too few: counts begin with 1".to_owned()),
        Ok(number) if number > MOST => Err(format!("{number} is too many: counts end with {MOST}")),
        Ok(number) => Ok(number),
        Err(_) => {
            Err(format!("{:?} is no count: write whole numbers from 1, separated by commas", text.trim()))
        }
    }
}

/// Counts such as `1,2,4`, each once, in their order.
///
/// # Errors
/// What is no list of counts.
pub fn counts(text: &str) -> Result<Vec<usize>, String> {
    unique(text.split(',').map(positive))
}

/// Patches such as `1,8,2x2x1`, each once, in their order.
///
/// # Errors
/// What is no list of patches.
pub fn patches(text: &str) -> Result<Vec<Patches>, String> {
    unique(text.split(',').map(|part| one_of_patches(part.trim())))
}

fn unique<T: PartialEq>(items: impl Iterator<Item = Result<T, String>>) -> Result<Vec<T>, String> {
    let mut all = Vec::new();
    for item in items {
        let item = item?;
        if !all.contains(&item) {
            all.push(item);
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_and_nonsense_is_named() {
        assert_eq!(counts("1, 2,4,2"), Ok(vec![1, 2, 4]));
        let all = [Patches::Total(8), Patches::Grid([2, 1, 2]), Patches::Total(1)];
        assert_eq!(patches("8,2x1x2,1"), Ok(all.to_vec()));
        for (text, part) in
            [("", "\"\""), ("1,,2", "\"\""), ("0", "0 is"), ("-1", "-1"), ("2.5", "2.5"), ("a", "a")]
        {
            let error = counts(text).expect_err(text);
            assert!(error.contains(part), "{text}: {error}");
        }
        assert_eq!(counts("16777216"), Ok(vec![1 << 24]));
        for text in ["16777217", "18446744073709551615"] {
            let error = counts(text).expect_err(text);
            assert!(error.contains(text) && error.contains("16777216"), "{error}");
            assert!(patches(text).is_err() && patches(&format!("1x{text}x1")).is_err());
        }
        assert!(patches("2x2").expect_err("two").contains("AxBxC"));
        assert!(patches("0x1x1").is_err() && patches("1x1x1x1").is_err());
    }
}
