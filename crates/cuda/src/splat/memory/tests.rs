use bendtwin_splat_kit::{SceneOptions, random_gaussians};

use super::*;

#[test]
fn parts_are_where_the_layout_says() {
    let gaussians = random_gaussians(1, &SceneOptions { count: 7, ..SceneOptions::default() });
    let layout = SetLayout::of(7);
    let starts = [0, layout.means, layout.scales, layout.colors, layout.opacities];
    let mut at = 0;
    for (part, start) in parts(&gaussians).into_iter().zip(starts) {
        assert_eq!(at, start);
        at += part.len();
    }
    assert_eq!(at, layout.end);
    assert_eq!(layout.end + 7, BARS * 7);
}

#[test]
fn kernels_have_as_many_moments() {
    let header = include_str!("../../../kernels/splat.cuh");
    assert!(header.contains(&format!("#define MOMENTS {MOMENTS}u")));
    assert!(header.contains("#define SORT_ROUNDS 8u") && header.contains("#define RADIX 256u"));
}
