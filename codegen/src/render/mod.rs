//! From a routine to source text. All target-language text stands in `templates/`; here the program is only
//! laid out as data for them. No arithmetic is decided.

mod steps;

use fitter::{Coefficients, text_safety};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, Value, context};
use serde::Serialize;

use crate::accepted::accepted;
use crate::certificate::{Entry, result_meaning, rust_type};
use crate::generate::TOOL;
use crate::options::{CShift, Options, OutOfRange};
use crate::program::{Op, Program, Type};
use crate::quantity::Quantity;
use crate::routine::Routine;
use crate::text;

use steps::operand;
pub(crate) use steps::{helpers, steps};

/// A template could not be rendered: a defect of the template, never of the user's input.
#[derive(Debug, thiserror::Error)]
#[error("template {template}: {cause:#}")]
pub struct RenderError {
    /// Which one.
    pub template: &'static str,
    /// What minijinja says.
    #[source]
    pub cause: Box<minijinja::Error>,
}

/// The templates, compiled in.
const TEMPLATES: &[(&str, &str)] = &[
    ("provenance.txt", include_str!("../../../templates/provenance.txt.jinja")),
    ("contract.txt", include_str!("../../../templates/contract.txt.jinja")),
    ("rust/Cargo.toml", include_str!("../../../templates/rust/Cargo.toml.jinja")),
    ("rust/lib.rs", include_str!("../../../templates/rust/lib.rs.jinja")),
    ("rust/routine.rs", include_str!("../../../templates/rust/routine.rs.jinja")),
    ("rust/module.rs", include_str!("../../../templates/rust/module.rs.jinja")),
    ("c/header.h", include_str!("../../../templates/c/header.h.jinja")),
    ("c/source.c", include_str!("../../../templates/c/source.c.jinja")),
    ("turn/contract.txt", include_str!("../../../templates/turn/contract.txt.jinja")),
    ("turn/routine.rs", include_str!("../../../templates/turn/routine.rs.jinja")),
    ("turn/header.h", include_str!("../../../templates/turn/header.h.jinja")),
    ("turn/source.c", include_str!("../../../templates/turn/source.c.jinja")),
    ("turn/sweep.rs", include_str!("../../../templates/turn/sweep.rs.jinja")),
    ("turn/sweep.c", include_str!("../../../templates/turn/sweep.c.jinja")),
    ("units/contract.txt", include_str!("../../../templates/units/contract.txt.jinja")),
    ("units/provenance.txt", include_str!("../../../templates/units/provenance.txt.jinja")),
    ("units/lib.rs", include_str!("../../../templates/units/lib.rs.jinja")),
    ("units/header.h", include_str!("../../../templates/units/header.h.jinja")),
    ("units/run.rs", include_str!("../../../templates/units/run.rs.jinja")),
    ("units/run.c", include_str!("../../../templates/units/run.c.jinja")),
    ("gappa/routine.g", include_str!("../../../templates/gappa/routine.g.jinja")),
    ("verify/eva.c", include_str!("../../../templates/verify/eva.c.jinja")),
    ("verify/shift_right.c", include_str!("../../../templates/verify/shift_right.c.jinja")),
    ("verify/symbols.rs", include_str!("../../../templates/verify/symbols.rs.jinja")),
    ("verify/sequence.rs", include_str!("../../../templates/verify/sequence.rs.jinja")),
    ("verify/sequence.c", include_str!("../../../templates/verify/sequence.c.jinja")),
    ("verify/sweep.rs", include_str!("../../../templates/verify/sweep.rs.jinja")),
    ("verify/sweep.c", include_str!("../../../templates/verify/sweep.c.jinja")),
];

/// Templates of routines for many units: expressions and helper functions are those of every other routine, so that
/// their text stands in one place. (A template cannot import macros from one that prints as well.)
fn with_the_routines_own_parts() -> [(&'static str, String); 2] {
    let c = include_str!("../../../templates/c/source.c.jinja");
    let head = c.split("{% for routine in routines %}").next().unwrap_or_default();
    let rust = include_str!("../../../templates/rust/routine.rs.jinja");
    let last = "{%- endmacro -%}\n";
    let macros = rust.rfind(last).map_or("", |at| &rust[..at + last.len()]);
    let functions = rust.find("{%- for helper in routine.helpers").map_or("", |at| &rust[at..]);
    let units_c = include_str!("../../../templates/units/source.c.jinja");
    let units_rust = include_str!("../../../templates/units/routine.rs.jinja");
    [
        ("units/source.c", format!("{head}{units_c}")),
        ("units/routine.rs", format!("{macros}{units_rust}{functions}")),
    ]
}

/// Columns of the sentences in a file's head.
pub const HEAD_COLUMNS: usize = 100;

/// A routine as the templates see it.
#[derive(Debug, Clone, Serialize)]
pub struct View {
    name: String,
    degree: usize,
    variable: &'static str,
    quantity: Quantity,
    formula: String,
    symbol: String,
    arguments: Vec<Value>,
    result_meaning: String,
    result_name: String,
    output_type: &'static str,
    c_output_type: &'static str,
    range_text: String,
    extrapolated: Option<String>,
    flag: bool,
    continues: bool,
    line: bool,
    fixed: bool,
    float_input: bool,
    bound_text: String,
    parts: Vec<Value>,
    resolution_text: Option<String>,
    claim_text: Option<String>,
    claim_parts: Vec<String>,
    steps: Vec<Value>,
    /// What is kept from call to call, and the steps that it starts from.
    state: Vec<Value>,
    state_bytes: usize,
    start_steps: Vec<Value>,
    /// Names of the arguments that the start reads.
    start_arguments: Vec<String>,
    /// Names of the arguments that a call reads: of a term that is too small to matter it need not be.
    update_arguments: Vec<String>,
    type_name: String,
    /// What is added to the function of the reading, and what is not, in sentences.
    terms: Vec<String>,
    left_out: Vec<String>,
    helpers: Vec<&'static str>,
    in_range: Value,
    table: Vec<Vec<i64>>,
    segments: usize,
    table_bytes: usize,
    arithmetic_shift: bool,
    /// The contract as rendered text, for files that hold several routines.
    contract: String,
}

/// Renders templates with the project's filters.
pub struct Renderer {
    environment: Environment<'static>,
}

impl Renderer {
    /// Compiles the templates.
    ///
    /// # Errors
    /// [`RenderError`] where one of them is not well-formed.
    pub fn new() -> Result<Self, RenderError> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        if let Ok(syntax) = SyntaxConfig::builder().keep_trailing_newline(true).build() {
            environment.set_syntax(syntax);
        }
        environment.set_auto_escape_callback(|_| minijinja::AutoEscape::None);
        // Whatever a value was made of: no value ends the comment, the line or the string that it stands in.
        environment.set_formatter(|out, _, value| {
            let text = value.to_string();
            let safe: Vec<String> = text.split('\n').map(text_safety::shown).collect();
            Ok(out.write_str(&safe.join("\n"))?)
        });
        environment.add_filter("comment", |text: &str, mark: &str| text::comment(text, mark));
        environment.add_filter("grouped", |value: i64| text::grouped(value));
        environment.add_filter("c_int", c_int);
        for &(name, source) in TEMPLATES {
            environment
                .add_template(name, source)
                .map_err(|cause| RenderError { template: name, cause: Box::new(cause) })?;
        }
        for (name, source) in with_the_routines_own_parts() {
            environment
                .add_template_owned(name, source)
                .map_err(|cause| RenderError { template: name, cause: Box::new(cause) })?;
        }
        Ok(Renderer { environment })
    }

    /// Renders one template.
    ///
    /// # Errors
    /// [`RenderError`] where the template asks for what is not there.
    pub fn render(&self, template: &'static str, context: Value) -> Result<String, RenderError> {
        let failed = |cause| RenderError { template, cause: Box::new(cause) };
        self.environment.get_template(template).map_err(failed)?.render(context).map_err(failed)
    }

    /// What a generated file says of where it comes from.
    ///
    /// # Errors
    /// [`RenderError`] of the template.
    pub fn provenance(
        &self,
        coefficients: &Coefficients,
        sha256: &str,
        options: &Options,
    ) -> Result<String, RenderError> {
        let recording = Value::from(Serde(&coefficients.recording));
        let open = accepted(coefficients, options).ok().flatten();
        let open = open.map(|open| text::wrapped(&format!("UNEXPLAINED: {open}."), HEAD_COLUMNS, ""));
        self.render(
            "provenance.txt",
            context! {
                tool => TOOL, command => &*options.command, coefficients => context! { sha256, recording }, open,
            },
        )
    }

    /// Lays a routine out for the templates.
    ///
    /// # Errors
    /// [`RenderError`] of the contract's template.
    pub fn view(
        &self,
        routine: &Routine,
        entry: &Entry,
        quantity: &Quantity,
        options: &Options,
    ) -> Result<View, RenderError> {
        let program = &routine.design.program;
        let output = &program.steps[program.output()];
        let unit = &quantity.bound_unit;
        let parts = entry.parts.iter().filter(|p| p.value > 0.0);
        let claim = entry.estimate.as_ref().map(|claim| claim.in_words(unit));
        let mut view = View {
            name: entry.routine.clone(),
            degree: entry.degree,
            variable: match routine.options.format.bits() {
                31 => "x/2³²",
                15 => "x/2¹⁶",
                _ => "x",
            },
            quantity: quantity.clone(),
            formula: quantity.formula.clone(),
            symbol: quantity.symbol.clone(),
            arguments: program
                .arguments
                .iter()
                .map(|a| context! { name => &*a.name, meaning => &*a.meaning, type => rust_type(a.ty), c_type => c_type(a.ty) })
                .collect(),
            result_meaning: result_meaning(entry, routine.options.output),
            result_name: output.name.clone(),
            output_type: rust_type(output.ty),
            c_output_type: c_type(output.ty),
            range_text: range_text(routine, quantity),
            extrapolated: entry.range.recorded.map(|(a, b)| format!("{a:?}…{b:?} {}", quantity.reading_unit)),
            flag: options.out_of_range == OutOfRange::Flag,
            line: routine.line,
            continues: options.out_of_range == OutOfRange::Continue,
            float_input: program.arguments.iter().any(|a| a.ty == Type::F32),
            fixed: program.steps.iter().any(|s| s.ty == Type::I32),
            bound_text: format!("{} {unit}", text::rounded_up(entry.bound)),
            parts: parts
                .map(|p| {
                    let lsb = format!("({:.2} LSB)", p.lsb);
                    let value_text = format!("{} {unit} {lsb:>13}", text::rounded_up(p.value));
                    context! { what => &*p.what, value_text }
                })
                .collect(),
            resolution_text: (entry.input_resolution > 0.0)
                .then(|| format!("{} {unit}", text::rounded_up(entry.input_resolution))),
            claim_text: claim.as_ref().map(|(figure, _)| figure.clone()),
            claim_parts: claim.map(|(_, parts)| parts).unwrap_or_default(),
            steps: steps(program, &program.update_steps()),
            state_bytes: program.state.iter().map(|w| if w.ty == Type::I64 { 8 } else { 4 }).sum(),
            start_steps: steps(program, &program.start_steps()),
            state: program
                .state
                .iter()
                .map(|w| {
                    let (start, next) = (operand(program, &w.start), operand(program, &w.next));
                    context! { name => &*w.name, type => rust_type(w.ty), c_type => c_type(w.ty), meaning => &*w.meaning, start, next }
                })
                .collect(),
            start_arguments: arguments_among(program, &program.start_steps()),
            update_arguments: arguments_among(program, &program.update_steps()),
            type_name: text::camel_case(&entry.routine),
            terms: routine.physics.terms_in_words(),
            left_out: entry.left_out.clone(),
            helpers: helpers(program, &program.written_steps(), options.c_shift),
            in_range: in_range(program),
            table: program.table.clone(),
            segments: routine.design.segments,
            table_bytes: program.table_bytes(),
            arithmetic_shift: options.c_shift == CShift::Arithmetic,
            contract: String::new(),
        };
        view.contract = self.render("contract.txt", context! { routine => Value::from(Serde(&view)) })?;
        Ok(view)
    }
}

impl View {
    /// Helpers that the routine's source needs.
    pub fn helpers(&self) -> &[&'static str] {
        &self.helpers
    }

    /// The rendered contract.
    pub fn contract(&self) -> &str {
        &self.contract
    }

    /// Name of the routine and of the module that holds it.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// Names of the arguments that some steps read.
fn arguments_among(program: &Program, steps: &[usize]) -> Vec<String> {
    let arguments = steps.iter().map(|i| &program.steps[*i]).filter(|s| matches!(s.op, Op::Input { .. }));
    arguments.map(|step| step.name.clone()).collect()
}

/// A type in C's words.
pub fn c_type(ty: Type) -> &'static str {
    match ty {
        Type::U16 => "uint16_t",
        Type::U32 => "uint32_t",
        Type::I32 => "int32_t",
        Type::I64 => "int64_t",
        Type::F32 => "float",
    }
}

/// A C constant; −2³¹ has no literal of type `int`.
fn c_int(value: i64) -> String {
    if value == i64::from(i32::MIN) { "INT32_MIN".into() } else { value.to_string() }
}

/// How the routine tells that a reading was inside the range.
fn in_range(program: &Program) -> Value {
    let (raw, limited) = (&program.steps[program.reading], &program.steps[program.clamped]);
    let wide = (raw.ty != limited.ty).then_some(rust_type(raw.ty));
    // C compares a `uint32_t` with a signed word only after a conversion; the limits are not negative.
    let unsigned = raw.ty == Type::U32;
    let always = program.reading == program.clamped;
    context! { raw => &*raw.name, limited => &*limited.name, wide, unsigned, always }
}

fn range_text(routine: &Routine, quantity: &Quantity) -> String {
    let (from, to) = routine.range;
    let (unit, reading) = (&quantity.reading_unit, &quantity.reading);
    let program = &routine.design.program;
    let words = match program.steps[program.reading].ty {
        Type::F32 => String::new(),
        _ => {
            let [lo, hi] = [program.valid.0, program.valid.1].map(|word| text::grouped(word as i64));
            format!(", that is {lo} … {hi} in words of the input")
        }
    };
    format!("{from:?} {unit} ≤ {reading} ≤ {to:?} {unit}{words}")
}
