//! Values that are invalid in any message.

/// Invalid settings.
pub(super) fn bad_settings() -> Vec<String> {
    let mut settings: Vec<String> = [
        "{",
        "null",
        "[]",
        "7",
        "\"text\"",
        "{}{}",
        "{\"unknown\": 1}",
        "{\"seed\": -1}",
        "{\"seed\": 1.5}",
        "{\"seed\": 1e400}",
        "{\"bending\": \"yes\"}",
        "{\"graph\": null}",
        "{\"graph\": {\"radius\": 1}}",
        "{\"graph\": {\"sampling_ratio\": 0}}",
        "{\"graph\": {\"sampling_ratio\": 2}}",
        "{\"graph\": {\"max_nodes\": 0}}",
        "{\"graph\": {\"max_nodes\": -3}}",
        "{\"graph\": {\"triplet_reference\": \"best\"}}",
        "{\"graph\": {\"sampling\": \"even\"}}",
        "{\"graph\": {\"radius_scales\": 1}}",
        "{\"substeps\": {\"fixed\": 0}}",
        "{\"substeps\": {\"auto\": {\"safety\": 0.1, \"max\": 10}}}",
        "{\"substeps\": \"many\"}",
        "{\"search\": {\"generations\": 4294967296}}",
        "{\"search\": {\"sigma\": 0}}",
        "{\"refine\": {\"learning_rate\": -1}}",
        "{\"refine\": {\"window\": {\"frames\": 0}}}",
        "{\"refine\": {\"beta1\": 1}}",
        "{\"loss\": {\"track_beta_m\": NaN}}",
        "{\"seed\": 1, \"seed\": 2}",
        "\u{feff}{}",
    ]
    .map(str::to_owned)
    .into();
    settings.push("[".repeat(100_000));
    settings.push("{\"graph\":".repeat(10_000));
    settings.push(format!("{{\"seed\": {}}}", "9".repeat(10_000)));
    settings.push(format!("{}{{}}", " ".repeat(4 << 20)));
    settings
}

/// Invalid page tokens.
pub(super) fn bad_page_tokens() -> Vec<String> {
    ["x", "AAAA", "-1", "0", "%00", "' or 1=1", "eyJpZCI6MX0=", "\u{1f4a5}"]
        .map(str::to_owned)
        .into_iter()
        .chain(["z".repeat(10_000)])
        .collect()
}

/// Request ids and display names that are too long.
pub(super) fn too_long() -> String {
    "n".repeat(100_000)
}

/// Strings that are no BLAKE3 digest in hex.
pub(super) fn bad_digests() -> Vec<String> {
    ["x", "00", "zz", "0x00"].map(str::to_owned).into_iter().chain(["0".repeat(63)]).collect()
}
