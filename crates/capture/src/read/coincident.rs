//! Points of a completed shape in one place. They are one point: no spring joins them, and a million of them
//! take a few kilobytes in an archive. Tracked points are kept, since each has a motion.

use std::collections::HashSet;

use bendtwin_core::{Point, capture::Object};

use crate::check::Note;

/// Merges points of the completed surface that lie in one place, and those of the interior, and notes how many
/// those were. The first of them stays, and the order of the others.
pub(super) fn merge(object: &mut Object, notes: &mut Vec<Note>) {
    for (what, points) in
        [("completed surface", &mut object.completed_surface), ("interior", &mut object.interior)]
    {
        let all = points.len();
        let mut places = HashSet::with_capacity(all.min(1 << 16));
        points.retain(|p| !is_finite(p) || places.insert(place(*p)));
        let merged = all - points.len();
        if merged > 0 {
            let message = format!(
                "{merged} of {all} points of the {what} lie where another one does, and count once"
            );
            notes.push(Note::info("POINTS_MERGED", message));
        }
    }
}

/// The place of a point: 0 and -0 are the same.
fn place(p: Point) -> [u32; 3] {
    p.map(|x| (x + 0.0).to_bits())
}

/// Others are errors, which a check counts.
fn is_finite(p: &Point) -> bool {
    p.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_has_one_point_of_a_shape() {
        let nan = [f32::NAN, 0.0, 0.0];
        let mut object = Object {
            completed_surface: vec![[0.0; 3], [1.0; 3], [-0.0; 3], nan, nan],
            interior: vec![[1.0; 3]; 1_000_000],
            ..Object::default()
        };
        let mut notes = Vec::new();
        merge(&mut object, &mut notes);
        assert_eq!(object.completed_surface[..2], [[0.0; 3], [1.0; 3]]);
        assert_eq!((object.completed_surface.len(), object.interior.len()), (4, 1));
        let said: Vec<&str> = notes.iter().map(|note| note.0.message.as_str()).collect();
        assert_eq!(said.len(), 2);
        assert!(said[1].starts_with("999999 of 1000000 points of the interior"), "{said:?}");
        // Kept points are not merged again.
        merge(&mut object, &mut notes);
        assert_eq!(notes.len(), 2);
    }
}
