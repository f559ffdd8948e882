//! Templates, styles and scripts of pages.

use std::{io::Read as _, sync::LazyLock};

use brotli_decompressor::Decompressor;
use minijinja::{
    AutoEscape, Environment, context, escape_formatter,
    value::{Serde, Value},
};
use serde::Serialize;

use crate::{
    files::visible::visible,
    input::error::{Error, Result},
    page::packed::data_url,
};

static STYLE: LazyLock<String> = LazyLock::new(|| {
    let font = data_url("font/woff2", include_bytes!("assets/inter/Inter.woff2"));
    let face = format!("@font-face {{ font-family: Inter; font-weight: 400 700; src: url({font}) }}\n");
    face + include_str!("assets/page.css") + include_str!("assets/comparison.css")
});
/// Scripts of all pages, in the order they run.
const SCRIPTS: [&str; 13] = [
    include_str!("assets/theme.js"),
    include_str!("assets/folds.js"),
    include_str!("assets/tables.js"),
    include_str!("assets/data.js"),
    include_str!("assets/colours.js"),
    include_str!("assets/address.js"),
    include_str!("assets/chosen.js"),
    include_str!("assets/slice.js"),
    include_str!("assets/space.js"),
    include_str!("assets/part.js"),
    include_str!("assets/grid.js"),
    include_str!("assets/lines.js"),
    include_str!("assets/start.js"),
];
/// The charting library; see `assets/plotly/README.md`.
static PLOTLY: LazyLock<String> = LazyLock::new(|| {
    let mut text = String::new();
    let compressed: &[u8] = include_bytes!("assets/plotly/plotly-kinetostat.min.js.br");
    let read = Decompressor::new(compressed, BUFFER).read_to_string(&mut text);
    read.expect("what was compressed with the program can be decompressed");
    text
});
/// Bytes decompressed at once.
pub(super) const BUFFER: usize = 1 << 16;

static TEMPLATES: LazyLock<std::result::Result<Environment<'static>, minijinja::Error>> = LazyLock::new(|| {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    // What is marked as safe is this program's own, or JSON that has been made visible.
    environment.set_formatter(|out, state, value| match value.as_str().filter(|_| !value.is_safe()) {
        Some(text) => escape_formatter(out, state, &Value::from(visible(text).into_owned())),
        None => escape_formatter(out, state, value),
    });
    environment.add_template("base.html", include_str!("assets/base.html"))?;
    environment.add_template("parts.html", include_str!("assets/parts.html"))?;
    environment.add_template("single.html", include_str!("assets/single.html"))?;
    environment.add_template("explore_block.html", include_str!("assets/explore_block.html"))?;
    environment.add_template("explore.html", include_str!("assets/explore.html"))?;
    environment.add_template("comparison.html", include_str!("assets/comparison.html"))?;
    Ok(environment)
});

/// Returns the page of template `name` with `content`, whose texts are all escaped; `Err` when the template asks for what is not there.
pub(super) fn render(name: &str, content: &impl Serialize) -> Result<String> {
    let fault = |fault: &minijinja::Error| Error::Page { template: name.into(), problem: fault.to_string() };
    let templates = TEMPLATES.as_ref().map_err(fault)?;
    let page = context! {
        style => Value::from_safe_string(STYLE.clone()),
        script => Value::from_safe_string(SCRIPTS.concat()),
        plotly => Value::from_safe_string(PLOTLY.clone()),
        ..Value::from(Serde(content))
    };
    templates.get_template(name).and_then(|template| template.render(page)).map_err(|e| fault(&e))
}
