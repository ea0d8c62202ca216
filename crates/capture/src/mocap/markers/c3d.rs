//! C3D files: a header, parameters in groups, and frames of points, each in the byte order of the machine
//! that wrote them. Of the parameters those are read that say what points are; forces and other signals
//! between the points are passed over.
//!
//! Written after the C3D User Guide, <https://www.c3d.org/HTML/>.

use std::collections::BTreeMap;

use super::{Mark, Markers, damaged, reserve};
use crate::{Error, Limits, limits::Budget};

/// Unit in which a file is divided [bytes].
const BLOCK: usize = 512;
/// Second byte of the file.
const KEY: u8 = 0x50;

/// Byte order, and the form of its floating-point numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Machine {
    Intel,
    /// Little-endian integers, numbers in the form of the VAX.
    Dec,
    Mips,
}

impl Machine {
    fn of(number: u8) -> Option<Self> {
        match number {
            84 => Some(Self::Intel),
            85 => Some(Self::Dec),
            86 => Some(Self::Mips),
            _ => None,
        }
    }

    fn word(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Intel | Self::Dec => u16::from_le_bytes(bytes),
            Self::Mips => u16::from_be_bytes(bytes),
        }
    }

    fn float(self, bytes: [u8; 4]) -> f32 {
        match self {
            Self::Intel => f32::from_le_bytes(bytes),
            Self::Mips => f32::from_be_bytes(bytes),
            // The halves are exchanged, and the exponent counts from 129.
            Self::Dec => {
                let [a, b, c, d] = bytes;
                f32::from_le_bytes([c, d, a, b]) / 4.0
            }
        }
    }
}

/// Place of the parameters, and the machine that wrote them; none if the bytes are no C3D file.
fn parameters_at(bytes: &[u8]) -> Option<(usize, Machine)> {
    let &[block, KEY] = bytes.first_chunk::<2>()? else { return None };
    let start = usize::from(block.checked_sub(1)?) * BLOCK;
    let machine = Machine::of(*bytes.get(start + 3)?)?;
    (start >= BLOCK).then_some((start, machine))
}

/// True for the first bytes of a C3D file.
pub(super) fn is_one(start: &[u8]) -> bool {
    parameters_at(start).is_some()
}

pub(super) fn read(
    at: &str,
    bytes: &[u8],
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Markers, Error> {
    let cut = || damaged(at, "it ends within its header or its parameters");
    let (start, machine) = parameters_at(bytes).ok_or_else(cut)?;
    let parameters = Parameters::read(bytes.get(start..).ok_or_else(cut)?, machine);
    let word = |number: usize| -> Option<u16> {
        let place = 2 * (number - 1);
        Some(machine.word([*bytes.get(place)?, *bytes.get(place + 1)?]))
    };
    let header_float = |number: usize| -> Option<f32> {
        let place = 2 * (number - 1);
        Some(machine.float(*bytes.get(place..)?.first_chunk::<4>()?))
    };
    let point = |name: &str| parameters.get("POINT", name);
    let first_number = |name: &str| point(name).and_then(|p| p.numbers(machine).next());
    let count =
        first_number("USED").map(|n| n as usize).or(word(2).map(usize::from)).ok_or_else(cut)?;
    let analog = word(3).map(usize::from).ok_or_else(cut)?;
    let scale = first_number("SCALE").map(|x| x as f32).or(header_float(7)).ok_or_else(cut)?;
    let fps = first_number("RATE").or(header_float(11).map(f64::from)).unwrap_or(f64::NAN);
    let block = first_number("DATA_START").map(|n| n as usize).filter(|n| *n > 0);
    let block = block.or(word(9).map(usize::from)).filter(|n| *n > 0).ok_or_else(cut)?;
    let data = bytes.get((block - 1).saturating_mul(BLOCK)..).ok_or_else(cut)?;

    // Negative: floating-point numbers in the units themselves.
    let is_float = scale < 0.0;
    let size = if is_float { 4 } else { 2 };
    let row = (count.saturating_mul(4).saturating_add(analog)).saturating_mul(size);
    let fitting = data.len().checked_div(row).unwrap_or(0);
    let frames = frame_count(&parameters, machine, [word(4), word(5)], fitting);
    if count == 0 || frames == 0 {
        return Err(damaged(at, "it has no points"));
    }
    if frames > fitting {
        return Err(damaged(at, format!("it announces {frames} frames and has {fitting}")));
    }
    let mut points = reserve(at, frames, count, limits, budget)?;
    for cells in data.chunks_exact(row).take(frames) {
        points.extend(cells.chunks_exact(4 * size).take(count).map(|cell| {
            let (p, is_seen) = if is_float {
                let [x, y, z, state] = four(cell, |bytes: [u8; 4]| machine.float(bytes));
                // The residual is in the low half of a number, and negative of what was not seen.
                ([x, y, z], state >= 0.0)
            } else {
                let [x, y, z, state] = four(cell, |bytes: [u8; 2]| machine.word(bytes) as i16);
                ([x, y, z].map(|x| f32::from(x) * scale), state >= 0)
            };
            let is_known = is_seen && p.iter().all(|x| x.is_finite());
            if is_known { p } else { [f32::NAN; 3] }
        }));
    }
    let labels = labels(&parameters);
    let marks = (0..count).map(|index| match labels.get(index).map(String::as_str) {
        Some(label) if !label.is_empty() => Mark::labelled(label),
        _ => Mark { label: format!("*{index}"), set: String::new(), is_rigid: false },
    });
    let text = |name: &str| point(name).map(|p| p.text()).unwrap_or_default();
    // The axis that points up on a screen that the points are drawn on.
    let up = text("Y_SCREEN").to_ascii_lowercase();
    let up = if up.len() == 1 { format!("+{up}") } else { up };
    Ok(Markers {
        fps,
        units: text("UNITS"),
        up_axis: (!up.is_empty()).then_some((up, "by POINT:Y_SCREEN")),
        usual_axes: ["+z", "+y"],
        marks: marks.collect(),
        points,
        left_out: Vec::new(),
    })
}

/// The four numbers of a point.
fn four<const N: usize, T: Copy + Default>(cell: &[u8], number: impl Fn([u8; N]) -> T) -> [T; 4] {
    let mut numbers = [T::default(); 4];
    for (slot, bytes) in numbers.iter_mut().zip(cell.as_chunks::<N>().0) {
        *slot = number(*bytes);
    }
    numbers
}

/// Number of frames: what the header cannot count is in a parameter, and in files of some programs
/// nowhere.
fn frame_count(
    parameters: &Parameters<'_>,
    machine: Machine,
    [first, last]: [Option<u16>; 2],
    fitting: usize,
) -> usize {
    let number = |group: &str, name: &str| {
        let count = parameters.get(group, name)?.numbers(machine).next()?;
        (count >= 1.0).then_some(count as usize)
    };
    // Two words, the low one first.
    let field = |name: &str| {
        let words: Vec<f64> = parameters.get("TRIAL", name)?.numbers(machine).collect();
        let &[low, high] = words.first_chunk::<2>()?;
        Some((high as usize).saturating_mul(65536).saturating_add(low as usize))
    };
    let by_trial = field("ACTUAL_START_FIELD")
        .zip(field("ACTUAL_END_FIELD"))
        .and_then(|(first, last)| last.saturating_add(1).checked_sub(first));
    let by_header = first.zip(last).and_then(|(first, last)| {
        let count = (usize::from(last) + 1).checked_sub(usize::from(first))?;
        (last < u16::MAX).then_some(count)
    });
    let all = [number("POINT", "LONG_FRAMES"), by_trial, by_header, number("POINT", "FRAMES")];
    // A count that is not kept up to date is a small one.
    all.into_iter().flatten().find(|count| *count > 0).unwrap_or(fitting)
}

/// All labels, of which a parameter holds 255.
fn labels(parameters: &Parameters<'_>) -> Vec<String> {
    let mut labels = Vec::new();
    for number in 1..=256 {
        let name = if number == 1 { "LABELS".to_owned() } else { format!("LABELS{number}") };
        let Some(parameter) = parameters.get("POINT", &name) else { break };
        labels.extend(parameter.texts());
    }
    labels
}

/// Parameters by the names of their groups and their own.
#[derive(Debug, Default)]
struct Parameters<'a> {
    groups: BTreeMap<String, u8>,
    all: BTreeMap<(u8, String), Parameter<'a>>,
}

#[derive(Clone, Copy, Debug)]
struct Parameter<'a> {
    /// Bytes of an element; -1 for letters.
    kind: i8,
    /// Letters of a text, if there is more than one dimension.
    width: usize,
    data: &'a [u8],
}

impl<'a> Parameters<'a> {
    /// Reads as many as are whole; a file that is cut off lacks points, which is noticed later.
    fn read(section: &'a [u8], machine: Machine) -> Self {
        let mut parameters = Self::default();
        let mut place = 4;
        while let Some(next) = parameters.add(section, place, machine) {
            place = next;
        }
        parameters
    }

    /// Adds what lies at a place, and returns the place of the next.
    fn add(&mut self, section: &'a [u8], place: usize, machine: Machine) -> Option<usize> {
        let &[length, group] = section.get(place..)?.first_chunk::<2>()?;
        // Locked ones have a negative length.
        let length = usize::from((length as i8).unsigned_abs());
        if length == 0 {
            return None;
        }
        let name = section.get(place + 2..place + 2 + length)?;
        let name = String::from_utf8_lossy(name).trim().to_ascii_uppercase();
        let pointer = place + 2 + length;
        let step = usize::from(machine.word(*section.get(pointer..)?.first_chunk::<2>()?));
        let id = (group as i8).unsigned_abs();
        if (group as i8) < 0 {
            self.groups.insert(name, id);
        } else {
            let body = section.get(pointer + 2..)?;
            let (&kind, rest) = body.split_first()?;
            let (&count, rest) = rest.split_first()?;
            let (sizes, rest) = rest.split_at_checked(usize::from(count))?;
            let kind = kind as i8;
            let elements: usize =
                sizes.iter().map(|n| usize::from(*n)).try_fold(1, usize::checked_mul)?;
            let bytes = elements.checked_mul(usize::from(kind.unsigned_abs()))?;
            let width = sizes.first().map_or(1, |n| usize::from(*n));
            self.all.insert((id, name), Parameter { kind, width, data: rest.get(..bytes)? });
        }
        (step > 0).then_some(pointer + step)
    }

    fn get(&self, group: &str, name: &str) -> Option<Parameter<'a>> {
        let id = self.groups.get(group)?;
        self.all.get(&(*id, name.to_owned())).copied()
    }
}

impl<'a> Parameter<'a> {
    fn numbers(self, machine: Machine) -> Box<dyn Iterator<Item = f64> + 'a> {
        match self.kind {
            1 => Box::new(self.data.iter().map(|b| f64::from(*b))),
            2 => Box::new(
                self.data.as_chunks::<2>().0.iter().map(move |b| f64::from(machine.word(*b))),
            ),
            4 => Box::new(
                self.data.as_chunks::<4>().0.iter().map(move |b| f64::from(machine.float(*b))),
            ),
            _ => Box::new(std::iter::empty()),
        }
    }

    /// The texts of a list.
    fn texts(self) -> impl Iterator<Item = String> + 'a {
        let text =
            |letters: &[u8]| String::from_utf8_lossy(letters).trim_matches([' ', '\0']).to_owned();
        let letters = if self.kind == -1 { self.data } else { &[] };
        letters.chunks_exact(self.width.max(1)).map(text)
    }

    /// A single text.
    fn text(self) -> String {
        self.texts().next().unwrap_or_default()
    }
}
