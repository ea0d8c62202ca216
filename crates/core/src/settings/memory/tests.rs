use super::{super::SearchSettings, *};

fn body() -> CaptureSize {
    CaptureSize {
        points: 3_000,
        controls: 30,
        frames: 300,
        longest: 300,
        sequences: 1,
        ..CaptureSize::default()
    }
}

fn lanes(count: u64) -> Lanes {
    Lanes { count, on_host: true }
}

fn total(settings: &FitSettings, capture: &CaptureSize, count: u64) -> u64 {
    estimate(settings, capture, &GraphSize::largest(settings, capture), lanes(count)).total()
}

/// Population 10,000, and as many neighbours and triplets as settings allow, on all points.
fn greedy() -> FitSettings {
    let mut settings = FitSettings::default();
    settings.graph.max_nodes = Some(3_000);
    settings.graph.max_neighbours = Some(256);
    settings.graph.max_triplets = 256;
    settings.search.population = Some(10_000);
    settings
}

#[test]
fn usual_fits_are_small() {
    let settings = FitSettings::default().filled(body().conditions(lanes(2)));
    let usual = total(&settings, &body(), 2);
    assert!(usual < 400 << 20, "{usual}");
}

#[test]
fn the_population_does_not_count_once_a_generation_is_loaded_in_parts() {
    let few = FitSettings {
        search: SearchSettings { population: Some(400), ..greedy().search },
        ..greedy()
    };
    assert_eq!(total(&greedy(), &body(), 2), total(&few, &body(), 2));
}

#[test]
fn every_size_adds_to_the_estimate() {
    let (settings, capture) = (greedy(), body());
    let base = total(&settings, &capture, 2);
    let larger = [
        CaptureSize { points: 30_000, ..capture },
        CaptureSize { frames: 30_000, ..capture },
        CaptureSize { longest: 30_000, ..capture },
        CaptureSize { controls: 3_000, ..capture },
    ];
    for capture in larger {
        assert!(total(&settings, &capture, 2) > base, "{capture:?}");
    }
    assert!(total(&settings, &capture, 16) > base);
    let starts = |n| {
        let search = SearchSettings { starts: Some(n), ..settings.search.clone() };
        total(&FitSettings { search, ..settings.clone() }, &capture, 2)
    };
    assert!(starts(64) > 10 * starts(1));
}

#[test]
fn views_and_gaussians_count_where_there_are_images() {
    let with = |gaussians: u32, view_pixels: u64| {
        let mut settings = FitSettings::default().filled(body().conditions(lanes(2)));
        settings.appearance.gaussians = Some(gaussians);
        total(&settings, &CaptureSize { view_pixels, ..body() }, 2)
    };
    let pixels = 20 << 20;
    assert_eq!(with(0, pixels) - with(0, 0), 6 * pixels);
    // A million Gaussians take more than the search and the refinement.
    assert!(with(1_000_000, pixels) > with(0, pixels) + (1 << 30));
    assert_eq!(with(1_000_000, 0), with(0, 0));
    let mut settings = FitSettings::default().filled(body().conditions(lanes(2)));
    settings.appearance.gaussians = Some(1_000_000);
    let capture = CaptureSize { view_pixels: pixels, ..body() };
    let advice = what_would_fit(&settings, &capture, lanes(2), 2 << 30);
    let gaussians = advice.iter().find(|(name, _)| *name == "appearance.gaussians");
    assert!(gaussians.is_some_and(|(_, most)| (100_000..1_000_000).contains(most)), "{advice:?}");
}

#[test]
fn sums_do_not_overflow() {
    let huge = u64::MAX / 2;
    let capture = CaptureSize {
        points: huge,
        completed: huge,
        interior: huge,
        controls: huge,
        frames: huge,
        longest: huge,
        sequences: huge,
        edges: 0,
        view_pixels: huge,
    };
    let mut settings = greedy();
    settings.graph.max_nodes = Some(usize::MAX);
    settings.graph.interior = Some(true);
    assert_eq!(total(&settings, &capture, u64::MAX / 4), u64::MAX);
}

#[test]
fn advice_fits_and_one_more_does_not() {
    let mut settings = greedy();
    settings.search.starts = Some(64);
    let most = 8 << 30;
    assert!(total(&settings, &body(), 2) > most);
    let advice = what_would_fit(&settings, &body(), lanes(2), most);
    let names: Vec<_> = advice.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["graph.max_nodes", "graph.max_neighbours", "search.starts"]);
    for (name, value) in advice {
        let with = |value: u64| {
            let mut changed = settings.clone();
            match name {
                "graph.max_nodes" => changed.graph.max_nodes = Some(value as usize),
                "graph.max_neighbours" => changed.graph.max_neighbours = Some(value as usize),
                _ => changed.search.starts = Some(value as u32),
            }
            total(&changed, &body(), 2)
        };
        assert!(with(value) <= most && with(value + 1) > most, "{name} {value}");
    }
    assert!(what_would_fit(&settings, &body(), lanes(2), 1 << 20).is_empty());
    let text = refusal(40 << 30, most, &[("graph.max_nodes", 12)]);
    assert!(text.contains("40.0 GiB") && text.contains("8.0") && text.contains("max_nodes 12"));
}
