//! The order of work: the first frame with strokes on the object, then forwards and backwards from
//! there; where a later frame has strokes, back from it half way to those before.

use bendtwin_capture::raw::{Frames, Image, MaskSet, Recording};
use bendtwin_core::{CancelToken, Finding, Point, settings::ingest::Stroke};
use rayon::prelude::*;

use crate::{
    Error, Segmented,
    backdrop::Backdrop,
    colors::{Colors, bin},
    findings,
    label::{self, Labelled},
    looks::Looks,
    marks::{self, Marks},
    paint::{Painting, paint},
    part::{self, BACKGROUND, HAND, OBJECT, PARTS, Shares},
    scene::{Reach, Scene, Shot, read},
    table::Table,
    view::{Lens, View, stride},
};

/// Distance around strokes within which object and hand are sought in the first frame [m], and around
/// what was labelled in the frame before.
const FIRST_REACH_M: f32 = 0.8;
const REACH_M: f32 = 0.25;
/// Every how many-th pixel is a point by which the table is sought.
const TABLE_STEP: usize = 17;
/// Pixels in all cameras by which a part is seen in a frame.
const SEEN: usize = 20;
/// Weight of a marked pixel beside one that was labelled.
const MARKED: f32 = 1.0;

pub(crate) fn run(
    recording: &Recording,
    strokes: &[Stroke],
    progress: &mut dyn FnMut(f64),
    cancel: &CancelToken,
) -> Result<Segmented, Error> {
    if let Some(camera) = recording.cameras.iter().find(|camera| camera.poses.is_empty()) {
        return Err(Error::NotCalibrated(camera.name.clone()));
    }
    if !strokes.iter().any(|stroke| part::index(stroke.part) == OBJECT) {
        return Err(Error::NoObject);
    }
    let stride = stride(&recording.cameras);
    let lenses: Vec<Lens<'_>> =
        recording.cameras.par_iter().map(|camera| Lens::new(camera, stride)).collect();
    let (marks, findings) = marks::place(recording, &lenses, strokes);
    let mut readers = (0..lenses.len())
        .map(|camera| recording.source.frames(camera))
        .collect::<Result<Vec<_>, _>>()?;
    let begun = Marked::read(&lenses, &mut readers, &marks, cancel)?;
    let backdrops = backdrops(&lenses, &mut readers, recording.frame_count, cancel)?;
    let mut scene = Scene { lenses, backdrops, table: None };
    scene.table = table(&scene, &mut readers, begun.first, &begun.places)?;
    let mut follower = Follower {
        recording,
        scene,
        looks: begun.looks,
        readers,
        marks,
        masks: MaskSet::empty(recording),
        doubt: vec![vec![None; recording.frame_count]; recording.cameras.len()],
        seen: [vec![false; recording.frame_count], vec![false; recording.frame_count]],
        findings: [findings, begun.findings].concat(),
    };
    follower.follow(begun.first, &begun.places, progress, cancel)?;
    Ok(follower.finish())
}

/// What the strokes say before anything is labelled.
struct Marked {
    looks: Looks,
    /// The first frame in which the object is marked.
    first: usize,
    /// Places of what is marked there [m].
    places: Vec<Point>,
    findings: Vec<Finding>,
}

impl Marked {
    fn read(
        lenses: &[Lens<'_>],
        readers: &mut [Box<dyn Frames + '_>],
        marks: &Marks,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let has_hand = marks.values().flatten().any(|mark| mark.part == HAND);
        let mut marked = Self {
            looks: Looks::new(has_hand),
            first: usize::MAX,
            places: Vec::new(),
            findings: Vec::new(),
        };
        for (&frame, of_frame) in marks {
            let views = read(lenses, readers, frame)?;
            let mut places = Vec::new();
            let mut has_object = false;
            for mark in of_frame {
                if cancel.is_cancelled() {
                    return Err(Error::Cancelled);
                }
                let lens = &lenses[mark.camera];
                let pixels =
                    views[mark.camera].as_ref().map(|view| (view, mark.pixels(lens, view)));
                let (view, pixels) = pixels.unzip();
                let (Some(view), Some(pixels)) = (view, pixels) else {
                    marked.findings.push(mark.without_depth(lens, frame));
                    continue;
                };
                for at in &pixels {
                    marked.looks.mark(mark.part, view.colors[*at], MARKED);
                }
                let place_of = lens.places(frame);
                let measured = pixels.iter().filter(|at| view.depths[**at] > 0.0);
                let before = places.len();
                places.extend(measured.step_by(16).map(|at| place_of(*at, view.depths[*at])));
                if places.len() == before {
                    marked.findings.push(mark.without_depth(lens, frame));
                } else {
                    has_object |= mark.part == OBJECT;
                }
            }
            if has_object && marked.first == usize::MAX {
                (marked.first, marked.places) = (frame, places);
            }
        }
        marked.looks.renew();
        if marked.first == usize::MAX { Err(Error::ObjectWithoutDepth) } else { Ok(marked) }
    }
}

fn backdrops(
    lenses: &[Lens<'_>],
    readers: &mut [Box<dyn Frames + '_>],
    frame_count: usize,
    cancel: &CancelToken,
) -> Result<Vec<Backdrop>, Error> {
    let both = readers.par_iter_mut().zip(lenses);
    both.map(|(reader, lens)| {
        if lens.camera.poses.len() > 1 {
            return Ok(Backdrop::unknown(lens));
        }
        Backdrop::read(lens, reader.as_mut(), frame_count, &|| cancel.is_cancelled())
    })
    .collect()
}

/// The table by the backdrops, or by a frame's depth where they are not known.
fn table(
    scene: &Scene<'_>,
    readers: &mut [Box<dyn Frames + '_>],
    frame: usize,
    marked: &[Point],
) -> Result<Option<Table>, Error> {
    let views = read(&scene.lenses, readers, frame)?;
    let mut points = Vec::new();
    for ((lens, backdrop), view) in scene.lenses.iter().zip(&scene.backdrops).zip(&views) {
        let place_of = lens.places(frame);
        for at in (0..lens.len()).step_by(TABLE_STEP) {
            let measured = view.as_ref().map_or(0.0, |view| view.depths[at]);
            let depth = if backdrop.depth(at) > 0.0 { backdrop.depth(at) } else { measured };
            if depth > 0.0 {
                points.push(place_of(at, depth));
            }
        }
    }
    Ok(Table::find(&points, &scene.eyes(frame), marked))
}

/// The work on one recording.
struct Follower<'a> {
    recording: &'a Recording,
    scene: Scene<'a>,
    looks: Looks,
    readers: Vec<Box<dyn Frames + 'a>>,
    marks: Marks,
    masks: MaskSet,
    doubt: Vec<Vec<Option<f32>>>,
    /// Whether any camera shows the object, and the hand, in each frame.
    seen: [Vec<bool>; 2],
    findings: Vec<Finding>,
}

impl Follower<'_> {
    fn follow(
        &mut self,
        first: usize,
        places: &[Point],
        progress: &mut dyn FnMut(f64),
        cancel: &CancelToken,
    ) -> Result<(), Error> {
        let count = self.recording.frame_count;
        let later: Vec<usize> = self.marks.range(first + 1..).map(|(frame, _)| *frame).collect();
        let mut before = first;
        let mut total = count;
        for key in &later {
            total += key - half_way(before, *key);
            before = *key;
        }
        let mut done = 0_usize;
        let mut step = || {
            done += 1;
            progress(done as f64 / total.max(1) as f64);
            if cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
        };
        if cancel.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let start = self.begin(first, places, cancel)?;
        step()?;
        self.back(&start, (0..first).rev(), &mut step)?;
        let (mut latest, mut before) = (start, first);
        for frame in first + 1..count {
            latest = self.advance(frame, &latest)?;
            step()?;
            if later.binary_search(&frame).is_ok() {
                self.back(&latest, (half_way(before, frame)..frame).rev(), &mut step)?;
                before = frame;
            }
        }
        Ok(())
    }

    /// Follows backwards through `frames`; the looks stay those of the frame from which it starts.
    fn back(
        &mut self,
        from: &Labelled,
        frames: impl Iterator<Item = usize>,
        step: &mut dyn FnMut() -> Result<(), Error>,
    ) -> Result<(), Error> {
        let looks = self.looks.clone();
        let mut latest: Option<Labelled> = None;
        for frame in frames {
            latest = Some(self.advance(frame, latest.as_ref().unwrap_or(from))?);
            step()?;
        }
        self.looks = looks;
        Ok(())
    }

    /// Labels the first frame.
    fn begin(
        &mut self,
        frame: usize,
        places: &[Point],
        cancel: &CancelToken,
    ) -> Result<Labelled, Error> {
        let mut views = read(&self.scene.lenses, &mut self.readers, frame)?;
        self.see_table(&views);
        let marked = self.marked(frame, &views);
        let Some(reach) = Reach::around(places.iter().copied(), FIRST_REACH_M) else {
            return Err(Error::ObjectWithoutDepth);
        };
        for round in 0..label::WAY_WEIGHTS.len() {
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let shot = self.scene.shoot(views, &self.looks, &reach, &marked);
            let seeds = label::seeds(&shot, &marked);
            if round == 0 {
                let first = label::first(&shot, &seeds);
                self.see_only(label::colors(&shot, &first), &shot.views);
            }
            let shares = label::begin(&shot, &self.looks, &seeds, round);
            self.see_only(label::colors(&shot, &shares), &shot.views);
            if round + 1 == label::WAY_WEIGHTS.len() {
                self.looks.anchor();
                self.judge(&shot, &shares);
                let labels = self.paint(frame, &shot, &shares, &marked);
                self.scene.settle(&shot, &labels);
                return Ok(Labelled::new(&shot, shares));
            }
            views = shot.views;
        }
        Err(Error::ObjectWithoutDepth)
    }

    /// Labels a frame beside one that is labelled.
    fn advance(&mut self, frame: usize, before: &Labelled) -> Result<Labelled, Error> {
        let views = read(&self.scene.lenses, &mut self.readers, frame)?;
        if views.iter().all(Option::is_none) {
            // What was not recorded was not lost.
            self.seen.iter_mut().for_each(|seen| seen[frame] = true);
            return Ok(before.clone());
        }
        let marked = self.marked(frame, &views);
        let places = self.places(frame, &views, &marked);
        let Some(reach) = Reach::around(before.places().chain(places), REACH_M) else {
            // Nothing is left to follow.
            self.paint_nothing(frame, &views);
            return Ok(before.clone());
        };
        let shot = self.scene.shoot(views, &self.looks, &reach, &marked);
        if shot.cells.is_empty() {
            // Nothing is in sight: what was known stays known.
            self.paint(frame, &shot, &[], &marked);
            return Ok(before.clone());
        }
        let seeds = label::seeds(&shot, &marked);
        let shares = label::follow(&shot, &self.looks, before, &seeds);
        let mut seen = label::colors(&shot, &shares);
        seen[BACKGROUND] = Colors::default();
        self.looks.see(&seen);
        self.paint(frame, &shot, &shares, &marked);
        Ok(Labelled::new(&shot, shares))
    }

    /// Marked pixels of each camera in a frame, with their parts.
    fn marked(&self, frame: usize, views: &[Option<View>]) -> Vec<Vec<(usize, usize)>> {
        let mut marked = vec![Vec::new(); views.len()];
        for mark in self.marks.get(&frame).into_iter().flatten() {
            if let Some(view) = &views[mark.camera] {
                let pixels = mark.pixels(&self.scene.lenses[mark.camera], view);
                marked[mark.camera].extend(pixels.into_iter().map(|at| (at, mark.part)));
            }
        }
        // Of two strokes over one pixel the later one counts.
        for of_camera in &mut marked {
            let last: std::collections::BTreeMap<usize, usize> = of_camera.drain(..).collect();
            of_camera.extend(last);
        }
        marked
    }

    /// Places of marked pixels.
    fn places(
        &self,
        frame: usize,
        views: &[Option<View>],
        marked: &[Vec<(usize, usize)>],
    ) -> Vec<Point> {
        let mut places = Vec::new();
        for ((lens, view), pixels) in self.scene.lenses.iter().zip(views).zip(marked) {
            let Some(view) = view else { continue };
            let place_of = lens.places(frame);
            let measured = pixels.iter().filter(|(at, _)| view.depths[*at] > 0.0);
            places.extend(measured.map(|(at, _)| place_of(*at, view.depths[*at])));
        }
        places
    }

    /// Takes the colours of what lies on the table as those of the background.
    fn see_table(&mut self, views: &[Option<View>]) {
        let seen = self.table_colors(views);
        self.looks.see_only([seen, Colors::default(), Colors::default()]);
    }

    fn see_only(&mut self, mut seen: [Colors; PARTS], views: &[Option<View>]) {
        seen[BACKGROUND] = self.table_colors(views);
        self.looks.see_only(seen);
    }

    /// Colours of the backdrop on and below the table.
    fn table_colors(&self, views: &[Option<View>]) -> Colors {
        let mut colors = Colors::default();
        for ((lens, backdrop), view) in
            self.scene.lenses.iter().zip(&self.scene.backdrops).zip(views)
        {
            let Some(view) = view else { continue };
            let place_of = lens.places(view.frame);
            for at in (0..lens.len()).step_by(3) {
                let behind = backdrop.depth(at);
                let depth = if behind > 0.0 { behind } else { view.depths[at] };
                let color = backdrop.color(at).unwrap_or(view.colors[at]);
                let is_low = self
                    .scene
                    .table
                    .is_none_or(|table| table.height(place_of(at, depth)) < table.thickness_m);
                // Without a table the backdrop itself, where something else is seen now.
                let is_backdrop = self.scene.table.is_some()
                    || (behind > 0.0 && view.depths[at] > 0.0 && view.depths[at] < 0.9 * behind);
                if depth > 0.0 && is_low && is_backdrop {
                    colors.add(bin(color), 1.0);
                }
            }
        }
        colors
    }

    /// Adds findings about parts that look alike.
    fn judge(&mut self, shot: &Shot, shares: &[Shares]) {
        let is = |cell: usize, part: usize| shares[cell][part] > 0.5;
        let touching = (0..shot.cells.len()).any(|cell| {
            is(cell, OBJECT)
                && shot.cells.links(cell).iter().any(|(other, _)| is(*other as usize, HAND))
        });
        let on_table = self.scene.table.is_some_and(|table| {
            let cells = shot.cells.cells.iter().enumerate();
            let mut low = cells.filter(|(i, cell)| {
                is(*i, OBJECT) && table.height(cell.place) < 3.0 * table.thickness_m
            });
            low.next().is_some()
        });
        let found = findings::alike(&self.looks, self.has_hand(), touching, on_table);
        self.findings.extend(found);
    }

    /// `true` if a stroke marks a hand.
    fn has_hand(&self) -> bool {
        self.marks.values().flatten().any(|mark| mark.part == HAND)
    }

    /// Makes the masks of a frame, and returns the labels of all pixels.
    fn paint(
        &mut self,
        frame: usize,
        shot: &Shot,
        shares: &[Shares],
        marked: &[Vec<(usize, usize)>],
    ) -> Vec<Vec<u8>> {
        let (scene, looks) = (&self.scene, &self.looks);
        let painted: Vec<Option<Painting>> = (0..scene.lenses.len())
            .into_par_iter()
            .map(|camera| {
                Some(paint(
                    &scene.lenses[camera],
                    shot.views[camera].as_ref()?,
                    &scene.backdrops[camera],
                    looks,
                    &shot.of_pixel[camera],
                    &shot.evidence[camera],
                    shares,
                    &marked[camera],
                ))
            })
            .collect();
        let mut counts = [0; PARTS];
        for (camera, painting) in painted.iter().enumerate() {
            let Some(Painting { labels, doubt }) = painting else { continue };
            labels.iter().for_each(|label| counts[usize::from(*label)] += 1);
            self.masks.set(camera, frame, &enlarged(&scene.lenses[camera], labels));
            self.doubt[camera][frame] = Some(*doubt);
        }
        for (seen, part) in self.seen.iter_mut().zip([OBJECT, HAND]) {
            seen[frame] = counts[part] >= SEEN;
        }
        painted.into_iter().map(|painting| painting.map_or_else(Vec::new, |p| p.labels)).collect()
    }

    /// Makes empty masks of a frame.
    fn paint_nothing(&mut self, frame: usize, views: &[Option<View>]) {
        for (camera, view) in views.iter().enumerate() {
            if view.is_some() {
                let lens = &self.scene.lenses[camera];
                let labels = vec![BACKGROUND as u8; lens.len()];
                self.masks.set(camera, frame, &enlarged(lens, &labels));
                self.doubt[camera][frame] = Some(0.0);
            }
        }
    }

    fn finish(mut self) -> Segmented {
        let names: Vec<String> =
            self.recording.cameras.iter().map(|camera| camera.name.clone()).collect();
        self.findings.extend(findings::doubtful(&names, &self.doubt));
        let [object, hand] = &self.seen;
        self.findings.extend(findings::lost("object", "OBJECT_NOT_FOLLOWED", object));
        if self.has_hand() {
            self.findings.extend(findings::lost("hand", "HAND_NOT_FOLLOWED", hand));
        }
        Segmented { masks: self.masks, doubt: self.doubt, findings: self.findings }
    }
}

/// The first frame that is followed back from `key`, after strokes in frame `before`.
fn half_way(before: usize, key: usize) -> usize {
    before + (key - before) / 2 + 1
}

/// Labels at the size of the camera's images.
fn enlarged(lens: &Lens<'_>, labels: &[u8]) -> Image<Option<bendtwin_capture::raw::Region>> {
    let (width, height) = (lens.camera.width, lens.camera.height);
    let shown = |at: usize| {
        let (column, row) = (at % width / lens.stride, at / width / lens.stride);
        part::region(usize::from(labels[row * lens.width + column]))
    };
    Image { width, height, pixels: (0..width * height).map(shown).collect() }
}
