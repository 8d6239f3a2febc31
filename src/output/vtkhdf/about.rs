//! What a column says of itself, as attributes that other programs read, too.
use super::name;
use crate::output::frame::{Columns, Field};
use crate::output::stored::word;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, Group};

/// What a group of columns has.
pub fn columns(data: &Group) -> hdf5::Result<Columns> {
    let ours = |n: &String| n != name::IDENTITY && n != name::MATERIAL;
    let read = |name: String| {
        let column = data.dataset(&name)?;
        let unit = column.attr(name::UNIT)?.read_scalar::<VarLenUnicode>()?.to_string();
        let (meaning, codes) = (words(&column, name::MEANING)?.concat(), words(&column, name::CODES)?);
        Ok(Field { name, unit, components: column.shape().get(1).copied().unwrap_or(1), meaning, codes })
    };
    let all = data.member_names()?;
    let materials = match all.iter().any(|name| name == name::MATERIAL) {
        true => words(&data.dataset(name::MATERIAL)?, name::NAMES)?,
        false => Vec::new(),
    };
    Ok(Columns { fields: all.into_iter().filter(ours).map(read).collect::<hdf5::Result<_>>()?, materials })
}

/// States what a column is.
pub fn describe_field(column: &Dataset, field: &Field) -> hdf5::Result<()> {
    unit(column, &field.unit)?;
    column.new_attr::<VarLenUnicode>().create(name::MEANING)?.write_scalar(&word(&field.meaning)?)?;
    put_words(column, name::CODES, &field.codes)
}

/// Names the materials that a column counts.
pub fn name_materials(column: &Dataset, names: &[String]) -> hdf5::Result<()> {
    put_words(column, name::NAMES, names)
}

/// So many texts HDF5 takes as an attribute.
const MOST: usize = 4000;

/// Texts as an attribute; none without any. More than an attribute takes are lines of one text.
fn put_words(column: &Dataset, name: &str, texts: &[String]) -> hdf5::Result<()> {
    if texts.is_empty() {
        return Ok(());
    }
    if texts.len() > MOST {
        return column.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&word(&texts.join("\n"))?);
    }
    let texts = texts.iter().map(|text| word(text)).collect::<hdf5::Result<Vec<_>>>()?;
    column.new_attr::<VarLenUnicode>().shape(texts.len()).create(name)?.write_raw(&texts)
}

/// What was put there, or nothing.
fn words(column: &Dataset, name: &str) -> hdf5::Result<Vec<String>> {
    if !column.attr_names()?.iter().any(|there| there == name) {
        return Ok(Vec::new());
    }
    let texts = column.attr(name)?.read_raw::<VarLenUnicode>()?;
    Ok(texts.iter().flat_map(|text| text.split('\n')).map(str::to_owned).collect())
}

/// States the unit of a dataset.
pub fn unit(dataset: &Dataset, symbol: &str) -> hdf5::Result<()> {
    dataset.new_attr::<VarLenUnicode>().create(name::UNIT)?.write_scalar(&word(symbol)?)
}
