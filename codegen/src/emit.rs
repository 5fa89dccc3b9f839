//! From designed routines to files and a certificate: for a polynomial, a table, the counts of a turn and a page for each
//! unit alike, in every language.

use std::collections::BTreeMap;
use std::path::PathBuf;

use fitter::budget::Budget;
use minijinja::value::Serde;
use minijinja::{Value, context};

use crate::budget;
use crate::certificate::{Certificate, Entry, OfRoutine};
use crate::generate::{TOOL, sha256};
use crate::language::{self, Body, Language};
use crate::options::{CShift, Options};
use crate::program::{Program, Type};
use crate::render::{RenderError, Renderer};
use crate::text;

/// What the rows of most tables are.
pub const OF_SEGMENTS: &str = "Coefficients of the polynomials, constant first, one row for each segment";

/// A designed routine with what is said of it.
#[derive(Debug, Clone)]
pub struct Described<'a> {
    /// What the certificate says, but for language and file.
    pub entry: Entry,
    /// Its uncertainty budget; none where nothing is known of the recording.
    pub budget: Option<Budget>,
    /// The routine.
    pub program: &'a Program,
    /// Whether it corrects the counts of a turn.
    pub counts: bool,
    /// What contract and frames say of it beside `entry`, all of which they can read: see `templates/contract.txt.jinja`.
    pub words: Value,
}

/// Prints routines in some languages.
pub struct Printer<'a> {
    /// The templates.
    pub renderer: Renderer,
    languages: &'a [&'a dyn Language],
    options: &'a Options,
}

impl<'a> Printer<'a> {
    /// Of these languages.
    pub fn new(languages: &'a [&'a dyn Language], options: &'a Options) -> Result<Self, RenderError> {
        Ok(Printer { renderer: Renderer::of(languages)?, languages, options })
    }

    /// What every file says at its top of where it comes from.
    pub fn provenance(&self, of: Value) -> Result<String, RenderError> {
        let command = &*self.options.command;
        let context = context! { ..of, ..context! { tool => TOOL, command, units => (), open => () } };
        self.renderer.render("provenance.txt", context)
    }

    /// The sources in every language, of a crate and of files called `name`.
    pub fn sources(
        &self,
        (name, description): (&str, &str),
        provenance: &str,
        routines: &[Described<'_>],
    ) -> Result<BTreeMap<PathBuf, String>, RenderError> {
        let mut files = BTreeMap::new();
        let common: Vec<Value> = routines.iter().map(|r| self.said(r)).collect::<Result<_, _>>()?;
        let names: Vec<&str> = routines.iter().map(|r| r.entry.routine.as_str()).collect();
        for language in self.languages {
            let laid_out: Vec<Value> = (routines.iter().zip(&common))
                .map(|(routine, said)| {
                    let body = Body::new(routine.program, routine.counts, self.options);
                    let ends = routine.program.state.is_empty() && routine.program.page.is_empty();
                    let ends = ends && routine.entry.out_of_range != "flag";
                    context! { ..said.clone(), ..language::laid_out(*language, &body, ends) }
                })
                .collect();
            let shared = context! {
                tool => TOOL, name, description, provenance,
                header => format!("{name}.h"),
                guard => format!("{}_H", name.to_uppercase()),
                helpers => self.helpers(*language, routines),
                arithmetic_shift => self.options.c_shift == CShift::Arithmetic,
                counts => routines.iter().any(|r| r.counts),
                routines => laid_out.clone(),
            };
            for file in language.files(name, &names) {
                let routine = file.routine.map(|index| laid_out[index].clone()).unwrap_or_default();
                let text = self.renderer.render(file.template, context! { routine, ..shared.clone() })?;
                files.insert(PathBuf::from(file.path), text);
            }
        }
        Ok(files)
    }

    /// The helper functions of a file that holds all routines. What others rest on comes first.
    fn helpers(&self, language: &dyn Language, routines: &[Described<'_>]) -> Vec<&'static str> {
        let mut helpers: Vec<&str> = Vec::new();
        for routine in routines {
            let body = Body::new(routine.program, routine.counts, self.options);
            for helper in language.helpers(&body, &routine.program.written_steps()) {
                if !helpers.contains(&helper) {
                    helpers.push(helper);
                }
            }
        }
        helpers.sort_by_key(|helper| !matches!(*helper, "float_guard" | "shift_right"));
        helpers
    }

    /// What is said of a routine in every language, its contract among it.
    fn said(&self, routine: &Described<'_>) -> Result<Value, RenderError> {
        let Described { entry, program, words, .. } = routine;
        let budget = routine.budget.as_ref().map(budget::in_words);
        let name = &*entry.routine;
        let each = |name: &str, meaning: &str| format!("`{name}`: {meaning}");
        let inputs: Vec<String> = program.arguments.iter().map(|a| each(&a.name, &a.meaning)).collect();
        let state: Vec<String> = program.state.iter().map(|w| each(&w.name, &w.meaning)).collect();
        let said = context! {
            name,
            entry => Value::from(Serde(entry)),
            type_name => text::camel_case(name),
            upper => name.to_uppercase(),
            names => program.arguments.iter().map(|a| &*a.name).collect::<String>(),
            unit => &*entry.unit,
            flag => entry.out_of_range == "flag",
            continues => entry.out_of_range == "continue",
            float_input => program.arguments.iter().any(|a| a.ty == Type::F32),
            bound_text => format!("{} {}", text::rounded_up(entry.bound), entry.unit),
            left_out => entry.left_out.clone(),
            budget_text => budget.as_ref().map(|(expanded, _)| expanded.clone()),
            budget_lines => budget.map(|(_, lines)| lines).unwrap_or_default(),
            table_comment => OF_SEGMENTS,
        };
        // What only some routines have.
        let nothing = context! {
            turn => (), page => (), formula => "", symbol => "", terms => (), extrapolated => (), line => false, fixed => false,
            parts => (), resolution_text => (), best_text => (),
        };
        let said = context! { ..words.clone(), ..said, ..nothing };
        let listed = context! { inputs, state };
        let contract = self.renderer.render("contract.txt", context! { ..said.clone(), ..listed })?;
        Ok(context! { contract, ..said })
    }

    /// The certificate: every routine in every language, with the hash of its file; `origin` says where they come from.
    pub fn certificate<T: AsRef<[u8]>>(
        &self,
        name: &str,
        origin: Certificate,
        routines: &[Described<'_>],
        files: &BTreeMap<PathBuf, T>,
    ) -> Certificate {
        let entries = routines.iter().flat_map(|routine| {
            self.languages.iter().map(|language| {
                let file = language.file_of(name, &routine.entry.routine);
                let file_sha256 = files.get(&PathBuf::from(&file)).map(sha256).unwrap_or_default();
                Entry { language: language.name().into(), file, file_sha256, ..routine.entry.clone() }
            })
        });
        let budgets = routines.iter().filter_map(|routine| {
            let (routine, budget) = (routine.entry.routine.clone(), routine.budget.clone()?);
            Some(OfRoutine { routine, device: None, budget })
        });
        Certificate {
            schema: "arcsmith-certificate".into(),
            version: 1,
            tool: TOOL.into(),
            command: self.options.command.clone(),
            routines: entries.collect(),
            budgets: budgets.chain(origin.budgets).collect(),
            ..origin
        }
    }
}
