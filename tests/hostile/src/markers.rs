//! Markers of motion capture: C3D, CSV of OptiTrack and TRC that lie about counts, places and numbers.

use rand::RngExt as _;

use crate::{Fault, Rng, damage, documents};

/// Faults of files of markers.
pub const FAULTS: &[Fault] = &[
    Fault { what: "markers with damage", make: |rng| changed(rng, damage::any) },
    Fault { what: "markers that are cut off", make: |rng| changed(rng, damage::cut) },
    Fault { what: "markers with other numbers", make: |rng| changed(rng, documents::numbers) },
    Fault { what: "markers with a count that is a lie", make: count },
    Fault { what: "markers with a parameter of a wrong size", make: parameter },
    Fault { what: "markers with columns without end", make: columns },
    Fault {
        what: "markers without frames",
        make: |rng| [csv(0), trc(0), c3d(0)][rng.random_range(0..3)].clone(),
    },
    Fault {
        what: "markers with quotes without end",
        make: |_| [csv(1), b"\"".repeat(4000)].concat(),
    },
];

const FRAMES: usize = 6;

/// A valid file with a change.
fn changed(rng: &mut Rng, change: fn(&mut Rng, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let files = all();
    let file = &files[rng.random_range(0..files.len())];
    change(rng, file)
}

/// Valid files of all formats.
pub fn all() -> Vec<Vec<u8>> {
    vec![csv(FRAMES), trc(FRAMES), c3d(FRAMES)]
}

const NAMES: [&str; 6] = ["rope:1", "rope:2", "rope:3", "rope:4", "hand:1", "hand:2"];

fn place(marker: usize, frame: usize) -> [f32; 3] {
    [0.1 * marker as f32, 0.5 + 0.02 * (marker * frame) as f32, 0.2]
}

/// A file as OptiTrack's Motive exports it.
pub fn csv(frames: usize) -> Vec<u8> {
    let mut text = "Format Version,1.23,Export Frame Rate,120.0,Rotation Type,Quaternion,Length Units,Meters\n\n".to_owned();
    let cells = |cell: &dyn Fn(usize) -> String| -> String {
        (0..NAMES.len())
            .flat_map(|marker| [cell(marker), cell(marker), cell(marker)])
            .map(|c| format!(",{c}"))
            .collect()
    };
    text += &format!(",Type{}\n", cells(&|_| "Marker".to_owned()));
    text += &format!(",Name{}\n", cells(&|marker| NAMES[marker].to_owned()));
    text += &format!(",{}\n", cells(&|_| "Position".to_owned()));
    text += &format!("Frame,Time (Seconds){}\n", ",X,Y,Z".repeat(NAMES.len()));
    for frame in 0..frames {
        text += &format!("{frame},{:.4}", frame as f64 / 120.0);
        for [x, y, z] in (0..NAMES.len()).map(|marker| place(marker, frame)) {
            text += &format!(",{x},{y},{z}");
        }
        text += "\n";
    }
    text.into_bytes()
}

/// A TRC file.
pub fn trc(frames: usize) -> Vec<u8> {
    let count = NAMES.len();
    let mut text = format!(
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n60\t{frames}\t{count}\tm\nFrame#\tTime"
    );
    NAMES.iter().for_each(|name| text += &format!("\t{name}\t\t"));
    text += "\n\t\tX1\tY1\tZ1\n\n";
    for frame in 0..frames {
        text += &format!("{}\t{:.4}", frame + 1, frame as f64 / 60.0);
        for [x, y, z] in (0..count).map(|marker| place(marker, frame)) {
            text += &format!("\t{x}\t{y}\t{z}");
        }
        text += "\n";
    }
    text.into_bytes()
}

/// A C3D file of little-endian floating-point numbers.
pub fn c3d(frames: usize) -> Vec<u8> {
    let mut parameters = vec![1, 80, 2, 84];
    group(&mut parameters, "POINT");
    let text = |texts: &[&str], width: usize| -> Vec<u8> {
        texts.iter().flat_map(|t| format!("{t:width$}").into_bytes()).collect()
    };
    let count = NAMES.len();
    entry(&mut parameters, "USED", 2, &[], &(count as u16).to_le_bytes());
    entry(&mut parameters, "FRAMES", 2, &[], &(frames as u16).to_le_bytes());
    entry(&mut parameters, "SCALE", 4, &[], &(-1.0_f32).to_le_bytes());
    entry(&mut parameters, "RATE", 4, &[], &100.0_f32.to_le_bytes());
    entry(&mut parameters, "DATA_START", 2, &[], &4_u16.to_le_bytes());
    entry(&mut parameters, "UNITS", -1, &[2], b"m ");
    entry(&mut parameters, "Y_SCREEN", -1, &[2], b"+Z");
    entry(&mut parameters, "LABELS", -1, &[8, count as u8], &text(&NAMES, 8));
    parameters.resize(1024, 0);
    let mut header = vec![2, 80];
    for word in [count as u16, 0, 1, frames as u16, 0] {
        header.extend(word.to_le_bytes());
    }
    header.extend((-1.0_f32).to_le_bytes());
    header.extend([4_u16, 0].map(u16::to_le_bytes).concat());
    header.extend(100.0_f32.to_le_bytes());
    header.resize(512, 0);
    let rows = (0..frames).flat_map(|frame| (0..count).map(move |marker| place(marker, frame)));
    let data = rows.flat_map(|[x, y, z]| [x, y, z, 0.0].map(f32::to_le_bytes).concat());
    [header, parameters, data.collect()].concat()
}

fn group(parameters: &mut Vec<u8>, name: &str) {
    parameters.extend([name.len() as u8, 255]);
    parameters.extend(name.as_bytes());
    parameters.extend([3, 0, 0]);
}

fn entry(parameters: &mut Vec<u8>, name: &str, kind: i8, sizes: &[u8], data: &[u8]) {
    parameters.extend([name.len() as u8, 1]);
    parameters.extend(name.as_bytes());
    let rest = 2 + 2 + sizes.len() + data.len() + 1;
    parameters.extend((rest as u16).to_le_bytes());
    parameters.extend([kind as u8, sizes.len() as u8]);
    parameters.extend(sizes);
    parameters.extend(data);
    parameters.push(0);
}

/// Counts in the header and the parameters of a C3D file, and in the text of a TRC file.
fn count(rng: &mut Rng) -> Vec<u8> {
    if rng.random_range(0..4) == 0 {
        let text = String::from_utf8(trc(FRAMES)).expect("it is text");
        return text.replacen("60\t6\t6", "60\t18446744073709551615\t6", 1).into_bytes();
    }
    let mut bytes = c3d(FRAMES);
    // Points, measurements between them, frames, start of the data; the same in the parameters.
    let at = [2, 4, 6, 8, 16, 529, 543][rng.random_range(0..7)];
    let lie = [0, 1, 255, 32767, 65535_u16][rng.random_range(0..5)];
    bytes[at..at + 2].copy_from_slice(&lie.to_le_bytes());
    bytes
}

fn parameter(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = c3d(FRAMES);
    let at = rng.random_range(512..760);
    bytes[at] = rng.random();
    bytes[at + 1] = 255;
    bytes
}

fn columns(rng: &mut Rng) -> Vec<u8> {
    let count = rng.random_range(1000..20_000);
    let row = |cell: &str| format!(",{cell}").repeat(count);
    format!(
        "Format Version,1.23,Length Units,Meters\n,Type{}\n,Name{}\n,{}\nFrame,Time{}\n0,0{}\n",
        row("Marker"),
        (0..count).map(|i| format!(",m{}", i / 3)).collect::<String>(),
        row("Position"),
        ",X,Y,Z".repeat(count / 3),
        row("1"),
    )
    .into_bytes()
}
