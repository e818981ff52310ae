//! Drawing as SVG text: the few elements that plots are made of.

use std::fmt::Write;

/// A picture under construction. Looks come from classes: see [`super::style`].
#[derive(Debug)]
pub(super) struct Svg {
    width: f64,
    height: f64,
    body: String,
}

/// Where a text's anchor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// How points are told apart without colour.
const SHAPES: [&str; 7] = [
    "M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0z",
    "M-4.5,-4.5h9v9h-9z",
    "M0,-5.8l5.4,9.6h-10.8z",
    "M0,-6.2l6.2,6.2l-6.2,6.2l-6.2,-6.2z",
    "M0,5.8l5.4,-9.6h-10.8z",
    "M-2,-6h4v4h4v4h-4v4h-4v-4h-4v-4h4z",
    "M0,-6.5l1.7,4.6l4.8,0.2l-3.8,3l1.3,4.7l-4,-2.7l-4,2.7l1.3,-4.7l-3.8,-3l4.8,-0.2z",
];

impl Svg {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    pub(super) fn line(&mut self, class: &str, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) {
        self.put(format_args!(
            "<line class=\"{class}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>",
            short(x1),
            short(y1),
            short(x2),
            short(y2)
        ));
    }

    pub(super) fn path(&mut self, class: &str, points: &[[f64; 2]]) {
        let steps = points
            .iter()
            .enumerate()
            .map(|(i, [x, y])| format!("{}{},{}", if i == 0 { "M" } else { "L" }, short(*x), short(*y)));
        let steps: String = steps.collect();
        self.put(format_args!("<path class=\"{class}\" d=\"{steps}\"/>"));
    }

    pub(super) fn rect(&mut self, class: &str, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        self.put(format_args!(
            "<rect class=\"{class}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
            short(x),
            short(y),
            short(width),
            short(height)
        ));
    }

    pub(super) fn text(&mut self, class: &str, [x, y]: [f64; 2], anchor: Anchor, text: &str) {
        self.put(format_args!(
            "<text class=\"{class}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>",
            short(x),
            short(y),
            anchor.name(),
            escaped(text)
        ));
    }

    /// A text that reads upwards, its middle at the point.
    pub(super) fn text_up(&mut self, class: &str, [x, y]: [f64; 2], text: &str) {
        let (x, y) = (short(x), short(y));
        self.put(format_args!(
            "<text class=\"{class}\" transform=\"translate({x},{y}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escaped(text)
        ));
    }

    /// The mark of a series, with what it says when pointed at.
    pub(super) fn mark(&mut self, class: &str, shape: usize, [x, y]: [f64; 2], title: &str) {
        let shape = SHAPES[shape % SHAPES.len()];
        self.put(format_args!(
            "<path class=\"{class}\" transform=\"translate({},{})\" d=\"{shape}\"><title>{}</title></path>",
            short(x),
            short(y),
            escaped(title)
        ));
    }

    fn put(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{element}");
    }

    /// For a page that has the styles.
    pub(super) fn inline(&self, title: &str) -> String {
        format!(
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n{}</svg>\n",
            short(self.width),
            short(self.height),
            escaped(title),
            self.body
        )
    }

    /// For a file of its own.
    pub(super) fn standalone(&self, title: &str, style: &str) -> String {
        let (width, height) = (short(self.width), short(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
             {height}\">\n<title>{}</title>\n<style>{style}</style>\n<rect class=\"paper\" width=\"100%\" \
             height=\"100%\"/>\n{}</svg>\n",
            escaped(title),
            self.body
        )
    }
}

/// As few digits as a picture needs.
fn short(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or(text.clone(), String::from)
}

/// Text as content or attribute of SVG. Control characters, which neither may hold, become visible.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\n' | '\t' => escaped.push(c),
            c if c.is_control() => escaped.push(char::REPLACEMENT_CHARACTER),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(escaped("<a href='x'>&\u{1b}"), "&lt;a href=&#39;x&#39;&gt;&amp;\u{fffd}");
        assert_eq!((short(1.0), short(-2.345)), ("1".into(), "-2.3".into()));
    }
}
