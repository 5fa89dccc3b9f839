//! Templates: the frames of generated files and of the programs that check them, compiled in.

use fitter::text_safety;
use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, UndefinedBehavior, Value};

use crate::language::{self, Language};
use crate::text;

/// A template could not be rendered: a defect of the template, never of the user's input.
#[derive(Debug, thiserror::Error)]
#[error("template {template}: {cause:#}")]
pub struct RenderError {
    /// Which one.
    pub template: String,
    /// What minijinja says.
    #[source]
    pub cause: Box<minijinja::Error>,
}

fitter::errors!(plain RenderError);

/// The templates of no language.
const COMMON: &[(&str, &str)] = &[
    ("provenance.txt", include_str!("../../templates/provenance.txt.jinja")),
    ("contract.txt", include_str!("../../templates/contract.txt.jinja")),
    ("gappa/routine.g", include_str!("../../templates/gappa/routine.g.jinja")),
];

/// Columns of the sentences in a file's head.
pub const HEAD_COLUMNS: usize = 100;

/// Renders templates with the project's filters.
pub struct Renderer {
    environment: Environment<'static>,
}

impl Renderer {
    /// Compiles the templates of all languages.
    ///
    /// # Errors
    /// [`RenderError`] where one of them is not well-formed.
    pub fn new() -> Result<Self, RenderError> {
        Renderer::of(&language::ALL)
    }

    /// Compiles the templates of some languages.
    ///
    /// # Errors
    /// [`RenderError`] where one of them is not well-formed.
    pub fn of(languages: &[&dyn Language]) -> Result<Self, RenderError> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        if let Ok(syntax) = SyntaxConfig::builder().keep_trailing_newline(true).build() {
            environment.set_syntax(syntax);
        }
        environment.set_auto_escape_callback(|_| minijinja::AutoEscape::None);
        // Whatever a value was made of: no value ends the comment, the line or the string that it stands in. Statements,
        // which a language made, are `safe`.
        environment.set_formatter(|out, _, value| {
            let text = value.to_string();
            if value.is_safe() {
                return Ok(out.write_str(&text)?);
            }
            let safe: Vec<String> = text.split('\n').map(text_safety::shown).collect();
            Ok(out.write_str(&safe.join("\n"))?)
        });
        environment.add_filter("comment", |text: &str, mark: &str| text::comment(text, mark));
        environment.add_filter("grouped", |value: i64| text::grouped(value));
        environment.add_filter("lines", |lines: Vec<String>, indent: usize, after: Option<String>| {
            let lines: Vec<String> = lines.iter().map(|line| " ".repeat(indent) + line).collect();
            lines.join(&(after.unwrap_or_default() + "\n"))
        });
        let all = languages.iter().flat_map(|language| language.templates());
        for &(name, source) in COMMON.iter().chain(all) {
            environment
                .add_template(name, source)
                .map_err(|cause| RenderError { template: name.into(), cause: Box::new(cause) })?;
        }
        Ok(Renderer { environment })
    }

    /// Renders one template.
    ///
    /// # Errors
    /// [`RenderError`] where the template asks for what is not there.
    pub fn render(&self, template: &str, context: Value) -> Result<String, RenderError> {
        let failed = |cause| RenderError { template: template.into(), cause: Box::new(cause) };
        self.environment.get_template(template).map_err(failed)?.render(context).map_err(failed)
    }
}
