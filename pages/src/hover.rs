//! Values of marks, which a browser shows where the pointer rests on them.

/// Gives the marks of an SVG their titles, in the order in which they are drawn; `mark` is their element. `label` says
/// what is drawn to those who do not see it.
pub(super) fn titled(
    svg: &str,
    label: &str,
    mark: &str,
    mut titles: impl Iterator<Item = Option<String>>,
) -> String {
    let svg = svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escaped(label)), 1);
    let begin = format!("<{mark} ");
    let mut parts = svg.split(&begin);
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        text += &begin;
        text += &match titles.next().flatten() {
            Some(title) => part.replacen("/>", &format!("><title>{}</title></{mark}>", escaped(&title)), 1),
            None => part.to_string(),
        };
    }
    text
}

/// As text within SVG.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
