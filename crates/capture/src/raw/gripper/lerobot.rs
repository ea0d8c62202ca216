//! Rows of an episode of a LeRobot dataset, which a robot recorded at its own rate: columns of a
//! Parquet file (<https://huggingface.co/docs/lerobot/lerobot-dataset-v3>), as pyarrow writes it.

use std::{
    collections::BTreeSet,
    panic::{AssertUnwindSafe, catch_unwind},
};

use bytes::Bytes;
use parquet::{
    basic::Compression,
    column::page::PageReader,
    errors::ParquetError,
    file::reader::{FileReader, SerializedFileReader},
    record::Field,
    schema::types::Type,
};

use super::{
    Pose, Reader,
    document::{Rotation, Table},
    settle_pose, wrong,
};
use crate::{Error, files::at_most, raw::clock::samples::nearby};

const EPISODE: &str = "episode_index";
const TIME: &str = "timestamp";

/// Rows of a file, of which a dataset has many: those of a hundred hours at 30 Hz.
const MAX_ROWS: usize = 10_800_000;
/// Values of a column that is read, in a file: lists of three for each of those rows.
const MAX_VALUES: usize = 32_400_000;
/// Rows of an episode.
const MAX_EPISODE_ROWS: usize = 1_000_000;
/// Elements of a row that are read.
const MAX_ELEMENTS: usize = 64;
/// Columns beside the three that are read: each camera and each state is one.
const MAX_COLUMNS: usize = 10_000;

/// Poses of a gripper [T]; `None` in frames that the episode does not reach.
pub(super) fn poses(
    reader: &mut Reader<'_, '_>,
    table: &Table,
    rotation: Rotation,
) -> Result<Vec<Option<Pose>>, Error> {
    let wanted = 3 + rotation.numbers();
    if table.elements.len() != wanted {
        let count = table.elements.len();
        return Err(wrong(format!(
            "gripper `{}` has {count} `elements` for its pose: name {wanted}, those of x, y, z and of the rotation",
            reader.name
        )));
    }
    let what = format!("gripper {}", reader.name);
    let placed = |row: &Row| {
        let (at, turn) = row.values.split_at(3);
        ([at[0], at[1], at[2]], rotation.quaternion(turn))
    };
    sampled(reader, table, |[from, to], share| {
        let [from, to] = [placed(from), placed(to)];
        let pose = Pose::between([&from, &to], share);
        if !pose.is_finite() {
            return Ok(None);
        }
        settle_pose(&what, &pose).map(Some)
    })
}

/// Sums of the elements [T]; NaN in frames that the episode does not reach.
pub(super) fn sums(reader: &mut Reader<'_, '_>, table: &Table) -> Result<Vec<f64>, Error> {
    let sum = |row: &Row| row.values.iter().sum::<f64>();
    let sums =
        sampled(reader, table, |[a, b], share| Ok(Some(sum(a) + share * (sum(b) - sum(a)))))?;
    Ok(sums.into_iter().map(|sum| sum.unwrap_or(f64::NAN)).collect())
}

/// What rows say of each frame [T], from the two around its time. Without times, row i is frame i.
fn sampled<T>(
    reader: &mut Reader<'_, '_>,
    table: &Table,
    mix: impl Fn([&Row; 2], f64) -> Result<Option<T>, Error>,
) -> Result<Vec<Option<T>>, Error> {
    if !(table.start_s.is_finite() && table.start_s.abs() < 1e6) {
        return Err(wrong(format!("`start_s` is {}: give seconds", table.start_s)));
    }
    let bytes = reader.files(&table.file)?.read(&table.file)?;
    // The library panics on some damaged pages.
    let read = catch_unwind(AssertUnwindSafe(|| rows(table, bytes)));
    let rows = read.unwrap_or_else(|_| Err(table.unreadable("a page is damaged")))?;
    let times_s = reader.setting.times_s;
    let [start, first] = [rows.first().map(|row| row.time_s), times_s.first().copied()]
        .map(|time| time.unwrap_or(f64::NAN));
    if start.is_nan() {
        let row = |frame: usize| rows.get(frame).map(|row| mix([row, row], 0.0));
        return (0..times_s.len()).map(|frame| row(frame).unwrap_or(Ok(None))).collect();
    }
    let ns = |seconds: f64| (seconds * 1e9).round() as i64;
    let at = |time_s: f64| {
        let time = ns(start + table.start_s + time_s - first);
        nearby(&rows, |row| ns(row.time_s), time)
    };
    let mixed = |time_s: &f64| match at(*time_s) {
        Some(found) => mix([found.before, found.after].map(|i| &rows[i]), found.share),
        None => Ok(None),
    };
    times_s.iter().map(mixed).collect()
}

/// A row of an episode.
struct Row {
    /// NaN if the file has no times.
    time_s: f64,
    /// The elements that were asked for.
    values: Vec<f64>,
}

/// The rows of the episode, in the order of time.
fn rows(table: &Table, bytes: Vec<u8>) -> Result<Vec<Row>, Error> {
    let at = table.file.as_str();
    let fault = |fault: String| Error::Document { at: at.to_owned(), fault };
    let unreadable = |e: ParquetError| table.unreadable(&e.to_string());
    at_most("elements", table.elements.len(), MAX_ELEMENTS)?;
    let file = SerializedFileReader::new(Bytes::from(bytes)).map_err(unreadable)?;
    let metadata = file.metadata();
    let columns = metadata.file_metadata().schema_descr().num_columns();
    at_most("columns of a dataset", columns, MAX_COLUMNS)?;
    let mut packed = metadata.row_groups().iter().flat_map(|group| group.columns());
    let is_unread = |c: Compression| !matches!(c, Compression::UNCOMPRESSED | Compression::SNAPPY);
    if let Some(column) = packed.find(|column| is_unread(column.compression())) {
        return Err(fault(format!(
            "its columns are compressed with {}: write them with Snappy, as LeRobot does",
            column.compression()
        )));
    }
    let schema = metadata.file_metadata().schema();
    let projection = projection(table, schema).map_err(fault)?;
    let has_episodes = schema.get_fields().iter().any(|field| field.name() == EPISODE);
    bound(&file, table)?;
    let mut found = Vec::new();
    let mut episodes = BTreeSet::new();
    for row in file.get_row_iter(Some(projection)).map_err(unreadable)? {
        let row = row.map_err(unreadable)?;
        let mut read = Row { time_s: f64::NAN, values: Vec::new() };
        let mut episode = None;
        for (name, field) in row.get_column_iter() {
            if name == EPISODE {
                episode = number(field).map(|n| n as i64);
            }
            if name == TIME {
                read.time_s = number(field).unwrap_or(f64::NAN);
            }
            if *name == table.column {
                read.values = elements(table, field).map_err(fault)?;
            }
        }
        if episodes.len() < 1000 {
            episodes.extend(episode);
        }
        if table.episode.is_none() || !has_episodes || episode == table.episode {
            found.push(read);
            at_most("rows of an episode", found.len(), MAX_EPISODE_ROWS)?;
        }
        if table.episode.is_none() && episodes.len() > 1 {
            return Err(fault("it has several episodes: name one (`episode`)".to_owned()));
        }
    }
    if found.is_empty() {
        let listed: Vec<String> = episodes.iter().take(8).map(i64::to_string).collect();
        return Err(fault(format!(
            "it has no row of episode {}; it has {}",
            table.episode.unwrap_or_default(),
            if listed.is_empty() { "none".to_owned() } else { listed.join(", ") }
        )));
    }
    if found.iter().any(|row| row.time_s.is_finite()) {
        found.retain(|row| row.time_s.is_finite());
        found.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    Ok(found)
}

impl Table {
    /// `true` if a column is read.
    fn reads(&self, column: &str) -> bool {
        [EPISODE, TIME, &self.column].contains(&column)
    }

    /// The error of a file that the library does not read.
    fn unreadable(&self, fault: &str) -> Error {
        let fault = format!("it cannot be read as Parquet: {fault}");
        Error::Document { at: self.file.clone(), fault }
    }
}

/// Checks how many rows and values are read before any is: a few bytes can stand for billions.
fn bound(file: &SerializedFileReader<Bytes>, table: &Table) -> Result<(), Error> {
    let unreadable = |e: ParquetError| table.unreadable(&e.to_string());
    let rows = file.metadata().row_groups().iter().map(|group| group.num_rows());
    let rows =
        rows.fold(0_usize, |sum, n| sum.saturating_add(usize::try_from(n).unwrap_or(usize::MAX)));
    at_most("rows of a dataset", rows, MAX_ROWS)?;
    let columns = file.metadata().file_metadata().schema_descr().columns();
    for (index, column) in columns.iter().enumerate() {
        if !column.path().parts().first().is_some_and(|name| table.reads(name)) {
            continue;
        }
        let mut values = 0_usize;
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group).map_err(unreadable)?;
            let pages = group.get_column_page_reader(index).map_err(unreadable)?;
            values = values.saturating_add(levels(pages).map_err(unreadable)?);
            at_most("values of a column", values, MAX_VALUES)?;
        }
    }
    Ok(())
}

/// Number of values in pages, by their heads.
fn levels(mut pages: Box<dyn PageReader>) -> Result<usize, ParquetError> {
    let mut count = 0_usize;
    while let Some(page) = pages.peek_next_page()? {
        count = count.saturating_add(page.num_levels.or(page.num_rows).unwrap_or(0));
        pages.skip_next_page()?;
    }
    Ok(count)
}

/// Schema of the columns that are read.
fn projection(table: &Table, schema: &Type) -> Result<Type, String> {
    let fields = schema.get_fields();
    if !fields.iter().any(|field| field.name() == table.column) {
        let names: Vec<&str> = fields.iter().take(40).map(|field| field.name()).collect();
        return Err(format!("it has no column `{}`; it has {}", table.column, names.join(", ")));
    }
    let fields = fields.iter().filter(|field| table.reads(field.name())).cloned().collect();
    let projection = Type::group_type_builder(schema.name()).with_fields(fields).build();
    projection.map_err(|e| format!("its columns cannot be chosen: {e}"))
}

/// The elements of a list, or a number.
fn elements(table: &Table, field: &Field) -> Result<Vec<f64>, String> {
    let all: Vec<Option<f64>> = match field {
        Field::Null => return Ok(vec![f64::NAN; table.elements.len()]),
        Field::ListInternal(list) => list.elements().iter().map(number).collect(),
        one => vec![number(one)],
    };
    let element = |index: &usize| {
        let value = all.get(*index).ok_or_else(|| {
            format!(
                "`{}` has {} elements, of which {index} is to be read: they are counted from 0",
                table.column,
                all.len()
            )
        })?;
        Ok(value.unwrap_or(f64::NAN))
    };
    table.elements.iter().map(element).collect()
}

fn number(field: &Field) -> Option<f64> {
    match *field {
        Field::Float(x) => Some(x.into()),
        Field::Double(x) => Some(x),
        Field::Byte(n) => Some(n.into()),
        Field::Short(n) => Some(n.into()),
        Field::Int(n) => Some(n.into()),
        Field::Long(n) => Some(n as f64),
        Field::UByte(n) => Some(n.into()),
        Field::UShort(n) => Some(n.into()),
        Field::UInt(n) => Some(n.into()),
        Field::ULong(n) => Some(n as f64),
        _ => None,
    }
}

impl Rotation {
    /// Numbers that it has.
    fn numbers(self) -> usize {
        match self {
            Self::QuaternionXyzw | Self::QuaternionWxyz => 4,
            Self::Vector | Self::RollPitchYaw => 3,
        }
    }

    /// Unit quaternion x, y, z, w; NaN if `numbers` has no length.
    fn quaternion(self, numbers: &[f64]) -> [f64; 4] {
        match (self, numbers) {
            (Self::QuaternionXyzw, &[x, y, z, w]) | (Self::QuaternionWxyz, &[w, x, y, z]) => {
                let length = [x, y, z, w].iter().map(|q| q * q).sum::<f64>().sqrt();
                [x, y, z, w].map(|q| q / length)
            }
            (Self::Vector, &[x, y, z]) => {
                let angle = (x * x + y * y + z * z).sqrt();
                // The limit of sin(a / 2) / a.
                let scale = if angle > 1e-9 { (0.5 * angle).sin() / angle } else { 0.5 };
                [x * scale, y * scale, z * scale, (0.5 * angle).cos()]
            }
            (Self::RollPitchYaw, &[roll, pitch, yaw]) => {
                let [(sr, cr), (sp, cp), (sy, cy)] =
                    [roll, pitch, yaw].map(|a| (0.5 * a).sin_cos());
                [
                    sr * cp * cy - cr * sp * sy,
                    cr * sp * cy + sr * cp * sy,
                    cr * cp * sy - sr * sp * cy,
                    cr * cp * cy + sr * sp * sy,
                ]
            }
            _ => [f64::NAN; 4],
        }
    }
}

#[cfg(test)]
mod tests;
