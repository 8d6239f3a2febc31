//! What the files of frames are called.
use super::folder;
use std::path::{Path, PathBuf};

/// Which file of which frame: `000007.h5`, or `000007-1of3.h5` where several ranks have written it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileId {
    /// Number of the frame.
    pub number: u64,
    /// How many files it has.
    pub parts: usize,
    /// Which of them, from 0 on.
    pub part: usize,
}

impl FileId {
    /// The files of a frame.
    pub fn of_frame(number: u64, parts: usize) -> impl Iterator<Item = Self> {
        (0..parts).map(move |part| Self { number, parts, part })
    }

    /// Its name in the folder of the frames.
    pub fn name(self) -> String {
        let Self { number, parts, part } = self;
        match parts {
            1 => format!("{number:06}.h5"),
            _ => format!("{number:06}-{}of{parts}.h5", part + 1),
        }
    }

    /// Where it is.
    pub fn path(self, index: &Path) -> PathBuf {
        folder(index).join(self.name())
    }

    /// The one that has this name.
    pub fn of(file: &Path) -> Option<Self> {
        let name = file.file_name()?.to_str()?.strip_suffix(".h5")?;
        let Some((number, place)) = name.split_once('-') else {
            return Some(Self { number: name.parse().ok()?, parts: 1, part: 0 });
        };
        let (part, parts) = place.split_once("of")?;
        let (part, parts): (usize, usize) = (part.parse().ok()?, parts.parse().ok()?);
        let id = Self { number: number.parse().ok()?, parts, part: part.checked_sub(1)? };
        (part <= parts && parts > 1).then_some(id)
    }
}

/// What is in the folder of the frames under the name of one.
pub fn list(index: &Path) -> Vec<(FileId, PathBuf)> {
    let entries = std::fs::read_dir(folder(index)).into_iter().flatten().flatten();
    let mut all: Vec<_> =
        entries.filter_map(|entry| Some((FileId::of(&entry.path())?, entry.path()))).collect();
    all.sort();
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_which_file_of_which_frame() {
        for (number, parts) in [(0, 1), (7, 3), (1_234_567, 12)] {
            for id in FileId::of_frame(number, parts) {
                assert_eq!(FileId::of(Path::new(&id.name())), Some(id));
            }
        }
        assert_eq!(FileId { number: 7, parts: 3, part: 0 }.name(), "000007-1of3.h5");
        for other in
            ["cells.h5", "7-0of3.h5", "7-4of3.h5", "7-1of1.h5", "7-of.h5", "000007.h5.part", "7-1.h5"]
        {
            assert_eq!(FileId::of(Path::new(other)), None, "{other}");
        }
    }
}
