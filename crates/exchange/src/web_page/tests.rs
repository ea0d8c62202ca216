use super::*;
use crate::testing::{twin, with_surface};

const TEMPLATE: &str = "<title>{{name}}</title><script id=twin>{{twin}}</script>{{name}}{{twin}}";

/// Title and file of a page.
fn parts(page: Vec<u8>) -> (String, Vec<u8>) {
    let page = String::from_utf8(page).unwrap();
    let between = |start: &str, end: &str| {
        let rest = page.split_once(start).unwrap().1;
        rest.split_once(end).unwrap().0.to_owned()
    };
    let file = between("id=twin>", "</script>");
    (between("<title>", "</title>"), BASE64_STANDARD.decode(file).unwrap())
}

#[test]
fn the_page_contains_the_twin_and_its_name_as_text() {
    let content = with_surface().encode().unwrap();
    let (title, file) = parts(web_page(TEMPLATE, "</title>&{{twin}}", &content).unwrap());
    assert_eq!(title, "&lt;/title&gt;&amp;{{twin}}");
    assert_eq!(file, content);
}

#[test]
fn the_program_of_the_page_stays_as_it_is() {
    let content = twin().encode().unwrap();
    let page = String::from_utf8(web_page(TEMPLATE, "a", &content).unwrap()).unwrap();
    assert!(page.ends_with("</script>{{name}}{{twin}}"), "{page}");
}

#[test]
fn a_twin_with_too_few_points_for_a_surface_is_unchanged() {
    let few = twin();
    let (_, file) = parts(web_page(TEMPLATE, "a", &few.encode().unwrap()).unwrap());
    assert_eq!(Twin::decode(&file).unwrap(), few);
}

#[test]
fn what_is_not_a_twin_has_no_page() {
    assert!(web_page(TEMPLATE, "a", b"glTF").is_err());
}
