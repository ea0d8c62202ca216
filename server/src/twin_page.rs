//! The template of the web page of a twin, which is built from `console/src/embed` and committed compressed. The
//! server does not show it; exports fill in a twin (`bendtwin_exchange::web_page`).

use std::io::{self, Read as _};

use flate2::read::GzDecoder;

const COMPRESSED: &[u8] = include_bytes!("../embedded/console/embed.html.gz");

/// The template, with places for a twin and its name.
///
/// # Errors
/// If this program is damaged.
pub fn twin_page_template() -> io::Result<String> {
    let mut template = String::new();
    GzDecoder::new(COMPRESSED).read_to_string(&mut template)?;
    Ok(template)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_template_has_places_for_a_twin_and_its_name_and_loads_nothing() {
        let page = twin_page_template().unwrap();
        for (before, place, after) in
            [("<title>", "{{name}}", "</title>"), ("id=\"twin\">", "{{twin}}", "</script>")]
        {
            let whole = format!("{before}{place}{after}");
            // What is filled in is the first place of its name.
            let first = page.find(&whole).map(|at| at + before.len());
            assert!(first.is_some(), "{place}");
            assert_eq!(page.find(place), first, "{place}");
        }
        assert!(page.contains("content=\"default-src 'none'; script-src 'sha256-"), "no policy");
    }
}
