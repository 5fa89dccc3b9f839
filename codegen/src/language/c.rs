//! C99: one source and header for all routines, without any implementation-defined behaviour unless it is asked for.

use std::path::Path;

use super::{Body, Checker, File, Language, is_high_sum, limit};
use crate::options::CShift;
use crate::program::{Op, Operand, Program, Step, Type};
use crate::text::float_hex;
use crate::verify::VerifyError;
use crate::verify::compile::{How, Place, Tool};
use crate::verify::eva;
use crate::verify::external::{self, Check, Checked, ToolReport};

/// The language.
#[derive(Debug)]
pub(super) struct C;

/// c added to an integer.
fn plus(program: &Program, c: &Operand) -> String {
    match c {
        Operand::Int(0) => String::new(),
        Operand::Int(value) if *value < 0 => format!(" - {}", -value),
        other => format!(" + {}", C.operand(program, other)),
    }
}

/// Behind an unsigned constant that is not zero.
fn plus_constant(value: u32) -> String {
    if value == 0 { String::new() } else { format!(" + {value}u") }
}

/// The constants of high sums and of their limits, each once: what some cores load from one array. Few are cheaper by
/// themselves.
fn gathered(body: &Body<'_>) -> Vec<i64> {
    let mut found = Vec::new();
    let steps = &body.program.steps;
    for step in body.program.written_steps().into_iter().map(|i| &steps[i]) {
        let constants = match &step.op {
            op if is_high_sum(op) || is_split_sum(op) => op.operands(),
            Op::Clamp { a, lo, hi } if body.type_of(a) == Type::I32 && *lo != -hi - 1 => {
                vec![Operand::Int(*lo), Operand::Int(*hi)]
            }
            _ => Vec::new(),
        };
        for constant in constants {
            if let Operand::Int(value) = constant
                && !found.contains(&value)
            {
                found.push(value);
            }
        }
    }
    if found.len() < FEWEST_GATHERED { Vec::new() } else { found }
}

/// Fewer constants than these cost more in an array than by themselves: its address is one more.
const FEWEST_GATHERED: usize = 4;
/// Constants in a line of their array.
const CONSTANTS_IN_A_LINE: usize = 8;

/// Whether a product from halves is added to something.
fn is_split_sum(op: &Op) -> bool {
    matches!(op, Op::MulAddSplit { c, .. } if *c != Operand::Int(0))
}

/// A constant where it stands in the array, or by itself.
fn constant(body: &Body<'_>, value: i64) -> String {
    let place = gathered(body).iter().position(|v| *v == value);
    place.map_or_else(|| C.integer(value), |place| format!("constant[{place}]"))
}

/// The row from which a signed number of a segment is counted, where that is one of the table: part of its address then.
fn from_row(body: &Body<'_>, step: &Step) -> Option<i64> {
    let Op::Index { add, by, .. } = step.op else { return None };
    let row = add >> by;
    let inside = (0..body.program.table.len() as i64).contains(&row);
    (step.ty == Type::I32 && !body.counts && inside).then_some(row)
}

/// The segment of a signed word, counted from that of 0.
fn signed_row(body: &Body<'_>, word: &str, by: u32) -> String {
    match by {
        31 => format!("(({word} < 0) ? -1 : 0)"),
        by if body.shift == CShift::Arithmetic => format!("({word} >> {by})"),
        by => format!("shift_right({word}, {by}u)"),
    }
}

/// An operand of a product or sum whose constants are gathered.
fn summand(body: &Body<'_>, operand: &Operand) -> String {
    match operand {
        Operand::Int(value) => constant(body, *value),
        other => C.operand(body.program, other),
    }
}

/// What is added to a product, behind it.
fn added(summand: String) -> String {
    match summand.strip_prefix('-') {
        _ if summand == "0" => String::new(),
        Some(magnitude) => format!(" - {magnitude}"),
        None => format!(" + {summand}"),
    }
}

/// The array of the constants that some lines read, and what they read it by.
fn declared_constants(body: &Body<'_>, lines: &[String]) -> Vec<String> {
    let values = gathered(body);
    if !lines.iter().any(|line| line.contains("constant[")) {
        return Vec::new();
    }
    let numbers: Vec<String> = values.iter().map(|v| C.integer(*v)).collect();
    let mut declared = vec![format!("static const int32_t constants[{}] = {{", values.len())];
    declared.extend(numbers.chunks(CONSTANTS_IN_A_LINE).map(|line| format!("    {},", line.join(", "))));
    if let Some(last) = declared.last_mut() {
        last.pop();
    }
    declared.extend(["};".into(), "const int32_t *const constant = loaded(constants);".into()]);
    declared
}

impl Language for C {
    fn name(&self) -> &'static str {
        "c"
    }

    fn templates(&self) -> &'static [(&'static str, &'static str)] {
        templates![
            "c/signature",
            "c/header.h",
            "c/page.h",
            "c/source.c",
            "c/page.c",
            "c/helpers.c",
            "verify/sweep.c",
            "verify/calls.c",
            "verify/pages.c",
            "verify/eva.c",
            "verify/shift_right.c",
        ]
    }

    fn files(&self, base: &str, _routines: &[&str]) -> Vec<File> {
        let file =
            |ending: &str, template| File { path: format!("c/{base}.{ending}"), template, routine: None };
        vec![file("h", "c/header.h"), file("c", "c/source.c")]
    }

    fn file_of(&self, base: &str, _routine: &str) -> String {
        format!("c/{base}.c")
    }

    fn type_name(&self, ty: Type) -> &'static str {
        match ty {
            Type::U16 => "uint16_t",
            Type::U32 => "uint32_t",
            Type::I32 => "int32_t",
            Type::I64 => "int64_t",
            Type::F32 => "float",
        }
    }

    fn parameter(&self, name: &str, ty: Type, _read: bool) -> String {
        format!("{} {name}", self.type_name(ty))
    }

    /// −2³¹ has no literal of type `int`.
    fn integer(&self, value: i64) -> String {
        if value == i64::from(i32::MIN) { "INT32_MIN".into() } else { value.to_string() }
    }

    fn float(&self, value: f32) -> String {
        format!("{}f", float_hex(value.into()))
    }

    fn expression(&self, body: &Body<'_>, step: &Step) -> String {
        if let Some(text) = of_counts(body, step) {
            return text;
        }
        let program = body.program;
        let text = |operand: &Operand| self.operand(program, operand);
        let plus = |c: &Operand| plus(program, c);
        let differs = |a: &Operand| body.type_of(a) != step.ty;
        let ty = self.type_name(step.ty);
        match &step.op {
            Op::Input { index } => program.arguments[*index].name.clone(),
            Op::State { index } => format!("state->{}", program.state[*index].name),
            Op::Word { index } => format!("coefficients->c[{index}]"),
            Op::Add { a, b } => text(a) + &plus(b),
            Op::Sub { a, b: b @ Operand::Int(_) } if differs(a) => {
                format!("(int32_t){} - {}", text(a), text(b))
            }
            Op::Sub { a, b: b @ Operand::Step(_) } if differs(a) => {
                format!("({ty}){} - ({ty}){}", text(a), text(b))
            }
            Op::Sub { a, b } => format!("{} - {}", text(a), text(b)),
            Op::Clamp { a, lo, hi } => {
                let from = body.type_of(a);
                let end = |value| if from == Type::I32 { constant(body, value) } else { self.integer(value) };
                let ends = format!("{}, {}", end(*lo), end(*hi));
                match (limit(from), from) {
                    (limit @ "limit_i64", _) => format!("(int32_t){limit}((int64_t){}, {ends})", text(a)),
                    (limit, Type::I32) => format!("{limit}({}, {ends})", text(a)),
                    (limit, _) => format!("{limit}((int32_t){}, {ends})", text(a)),
                }
            }
            Op::ClampF32 { a, lo, hi } => {
                format!("limit_f32({}, {}, {})", text(a), self.float(*lo), self.float(*hi))
            }
            Op::ShiftLeft { a, by } => format!("{} * {}", text(a), 1u64 << by),
            Op::ShiftRight { a, add, by } => match body.shift {
                CShift::Arithmetic => format!("({} + {add}) >> {by}", text(a)),
                CShift::Strict => format!("shift_right({} + {add}, {by}u)", text(a)),
            },
            Op::Index { a, add, by } if step.ty == Type::I32 => {
                let row = signed_row(body, &text(a), *by);
                if from_row(body, step).is_some() { row } else { row + &plus(&Operand::Int(add >> by)) }
            }
            Op::Index { a, add, by } => format!("((uint32_t){} + {}u) >> {by}", text(a), *add as u32),
            Op::Wrap { a, add, by } => match (*add as u32) << by {
                0 => format!("to_signed((uint32_t){} << {by})", text(a)),
                add => format!("to_signed(((uint32_t){} << {by}) + {add}u)", text(a)),
            },
            Op::Entry { index, column } => format!("{}[{column}]", body.row_name(index)),
            Op::MulAddWide { a, b, c } => format!("((int64_t){} * {}){}", text(a), text(b), plus(c)),
            Op::High { a, by } => format!("high_word({}, {by}u)", text(a)),
            Op::Phase { a, factor, by } => format!("phase_of({}, {factor}, {by}u)", text(a)),
            Op::Truncate { a } => format!("(int32_t){}", text(a)),
            Op::ToF32 { a } => format!("(float){}", text(a)),
            Op::MulF32 { a, b } => format!("{} * {}", text(a), text(b)),
            op @ Op::MulAddHigh { a, b, c, .. } if is_high_sum(op) => {
                let [a, b, c] = [a, b, c].map(|operand| summand(body, operand));
                format!("mul_add_high({a}, {b}, {c})")
            }
            Op::MulAddHigh { a, b, shift, c } => product("mul_high", &text(a), &text(b), *shift) + &plus(c),
            Op::MulAddSplit { a, b, shift, c } => {
                let [a, b] = [a, b].map(|operand| summand(body, operand));
                product("mul_split", &a, &b, *shift) + &added(summand(body, c))
            }
            Op::MulAddShort { a, b, by, c } => {
                let product = format!("{} * {}", text(a), text(b));
                match body.shift {
                    CShift::Arithmetic => format!("(({product}) >> {by}){}", plus(c)),
                    CShift::Strict => format!("shift_right({product}, {by}u){}", plus(c)),
                }
            }
            Op::MulAddF32 { a, b, c, fused: true } => format!("fused({}, {}, {})", text(a), text(b), text(c)),
            Op::MulAddF32 { a, b, c, .. } => {
                format!("({} * {}){}", text(a), text(b), self.plus_float(program, c))
            }
            Op::Bits { .. } | Op::Shifted { .. } | Op::Around { .. } => unreachable!("of counts"),
        }
    }

    fn statements(&self, body: &Body<'_>, which: &[usize], _ends: bool) -> Vec<String> {
        let program = body.program;
        let assigned = |name: &str, before: usize| {
            which.iter().filter(|&&i| i < before && program.steps[i].name == name).count()
        };
        let mut lines = Vec::new();
        for (index, step) in body.written(which) {
            if let Some((row, name)) = body.row_before(index, which) {
                let found = match row {
                    Operand::Step(i) => from_row(body, &program.steps[*i]),
                    _ => None,
                };
                let table = found.map_or("table".into(), |first| format!("(&table[{first}])"));
                lines.push(format!("const int32_t *const {name} = {table}[{}];", self.operand(program, row)));
            }
            let note = body.note(step, ("/*", " */"));
            let declared = match (assigned(&step.name, index), assigned(&step.name, program.steps.len())) {
                (0, 1) => format!("const {} ", self.type_name(step.ty)),
                (0, _) => format!("{} ", self.type_name(step.ty)),
                _ => String::new(),
            };
            lines.push(format!("{declared}{} = {};{note}", step.name, self.expression(body, step)));
        }
        [declared_constants(body, &lines), lines].concat()
    }

    /// Unsigned words are compared with signed ones after a conversion: the limits are not negative.
    fn inside(&self, raw: &Step, limited: &Step) -> String {
        let cast = if raw.ty == Type::U32 { "(uint32_t)" } else { "" };
        format!("({} == {cast}{})", raw.name, limited.name)
    }

    fn row(&self, numbers: &str) -> String {
        format!("{{ {numbers} }}")
    }

    fn helpers(&self, body: &Body<'_>, which: &[usize]) -> Vec<&'static str> {
        let mut helpers = body.helpers(which);
        let shifts = |step: &Step| match step.op {
            Op::MulAddSplit { .. } | Op::MulAddShort { .. } | Op::ShiftRight { .. } => true,
            // Of a table of two segments the sign says which it is.
            Op::Index { by, .. } => by < 31 && step.ty == Type::I32,
            _ => false,
        };
        if body.shift == CShift::Strict && which.iter().any(|i| shifts(&body.program.steps[*i])) {
            helpers.insert(0, "shift_right");
        }
        // A sum has a function of its own: the product alone is left where something else reads it.
        let ops = || which.iter().map(|i| &body.program.steps[*i].op);
        if ops().any(is_high_sum) {
            helpers.push("mul_add_high");
            let alone = |op: &Op| matches!(op, Op::MulAddHigh { .. }) && !is_high_sum(op);
            helpers.retain(|helper| *helper != "mul_high" || ops().any(alone));
        }
        if !gathered(body).is_empty() {
            helpers.push("loaded");
        }
        // A loader reads words of its page.
        if !body.program.page.is_empty() {
            helpers.push("to_signed");
        }
        helpers
    }

    fn keywords(&self) -> &'static str {
        "auto break case char const continue default do double else enum extern float for goto if inline int long \
         register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while"
    }

    fn reserved(&self) -> &'static [(&'static str, &'static str)] {
        &[
            (HEADERS, "a header of C or POSIX, which the generated one would hide"),
            (FUNCTIONS, "a function or macro of the C library"),
        ]
    }

    fn checker(&self) -> Option<&dyn Checker> {
        Some(self)
    }
}

impl Checker for C {
    fn extension(&self) -> &'static str {
        "c"
    }

    fn double(&self, value: f64) -> String {
        float_hex(value)
    }

    fn argument(&self, ty: Type) -> String {
        if ty == Type::F32 { "float_of(key)".into() } else { format!("({})key", self.type_name(ty)) }
    }

    fn watches(&self) -> bool {
        true
    }

    fn compiler(&self, place: &Place<'_>, how: How, source: &Path, executable: &Path) -> (Tool, Vec<String>) {
        let mut arguments = vec!["-std=c99", "-O3", "-march=native", "-ffp-contract=off"];
        if how.sanitized {
            // Undefined behaviour ends the run; unsigned arithmetic may wrap, that is defined.
            arguments.extend(["-fsanitize=undefined,float-cast-overflow", "-fno-sanitize-recover=all"]);
        }
        if how.strict {
            arguments.extend(["-Wall", "-Wextra", "-Werror"]);
        }
        let mut arguments: Vec<String> = arguments.into_iter().map(String::from).collect();
        arguments.extend([format!("-I{}", place.generated.join("c").display()), "-o".into()]);
        arguments.extend([executable.display().to_string(), source.display().to_string()]);
        // Where a compiler calls the library's fmaf.
        arguments.push("-lm".into());
        (Tool::cc(), arguments)
    }

    fn check(&self, check: Check, of: &Checked<'_>) -> Result<Vec<ToolReport>, VerifyError> {
        match check {
            Check::Analysis => eva::frama_c(self, of).map(|report| vec![report]),
            Check::Rules => {
                let mut reports = vec![external::misra(&of.place)?];
                reports.extend(external::warnings(&of.place)?);
                Ok(reports)
            }
            Check::Objects => Ok(Vec::new()),
        }
    }

    /// In strict C a shift is an exact division, or its distance an argument.
    fn shifts(&self, by: u32) -> Vec<String> {
        vec![format!(") >> {by}"), format!("/ {})", 1u64 << by), format!(", {by}u)")]
    }
}

/// The operations on counts, which are unsigned words; none of others.
fn of_counts(body: &Body<'_>, step: &Step) -> Option<String> {
    let program = body.program;
    let text = |operand: &Operand| C.operand(program, operand);
    let ty = C.type_name(step.ty);
    Some(match &step.op {
        Op::Clamp { a, hi, .. } if step.ty == Type::U32 => {
            format!("({0} < {hi}u) ? (uint32_t){0} : {hi}u", text(a))
        }
        Op::Bits { a, from, bits } => {
            let mask = (1u64 << bits) - 1;
            let field = match from {
                0 => format!("(uint32_t){} & {mask}u", text(a)),
                from => format!("((uint32_t){} >> {from}) & {mask}u", text(a)),
            };
            if step.ty == Type::U32 { field } else { format!("({ty})({field})") }
        }
        Op::Shifted { a, by, b, add } => {
            let a = match by {
                0 => format!("(uint32_t){}", text(a)),
                by => format!("((uint32_t){} << {by})", text(a)),
            };
            format!("{a} + (uint32_t){}{}", text(b), plus_constant(*add as u32))
        }
        Op::Around { a, turn } => format!("around({}, {turn}u)", text(a)),
        Op::Entry { index, column } if body.counts => {
            let column = if program.table[0].len() > 1 { format!("[{column}]") } else { String::new() };
            format!("table[{}]{column}", text(index))
        }
        _ => return None,
    })
}

/// The high part of a product, shifted left.
fn product(function: &str, a: &str, b: &str, shift: u32) -> String {
    let high = format!("{function}({a}, {b})");
    if shift > 0 { format!("({high} * {})", 1u64 << shift) } else { high }
}

/// Headers of C23, of POSIX.1-2024, and those that most systems have beside them.
const HEADERS: &str = "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign \
    stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar \
    wctype aio cpio dirent dlfcn endian fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen libintl monetary mqueue ndbm \
    netdb nl_types poll pthread pwd regex sched search semaphore spawn strings stropts syslog tar termios trace ulimit \
    unistd utime utmpx wordexp alloca byteswap features malloc memory values";

/// What `stdlib.h`, `math.h`, `string.h` and their like declare, without the letters that math puts after its names.
const FUNCTIONS: &str = "abort abs acos acosh alloca asctime asin asinh atan atan2 atanh atexit atof atoi atol atoll bsearch \
    btowc cabs cacos cacosh calloc carg casin casinh catan catanh cbrt ccos ccosh ceil cexp cimag clearerr clock clog conj \
    copysign cos cosh cpow cproj creal csin csinh csqrt ctan ctanh ctime difftime div erf erfc exit exp exp2 expm1 fabs \
    fclose fdim feof ferror fflush fgetc fgetpos fgets floor fma fmax fmin fmod fopen fprintf fputc fputs fread free freopen \
    frexp fscanf fseek fsetpos ftell fwrite getc getchar getenv gets gmtime hypot ilogb imaxabs imaxdiv isalnum isalpha \
    isblank iscntrl isdigit isfinite isgraph isinf islower isnan isnormal isprint ispunct isspace isupper isxdigit labs \
    ldexp ldiv lgamma llabs lldiv llrint llround localeconv localtime log log10 log1p log2 logb longjmp lrint lround mblen \
    mbtowc memchr memcmp memcpy memmove memset mktime modf nan nearbyint nextafter nexttoward offsetof perror pow printf putc \
    putchar puts qsort raise rand realloc remainder remove remquo rename rewind rint round scalbln scalbn scanf setbuf \
    setlocale setvbuf signbit sin sinh snprintf sprintf sqrt srand sscanf strcat strchr strcmp strcoll strcpy strcspn strerror \
    strftime strlen strncat strncmp strncpy strpbrk strrchr strspn strstr strtod strtof strtok strtol strtold strtoll strtoul \
    strtoull strxfrm system tan tanh tgamma tmpfile tmpnam tolower toupper trunc ungetc va_arg va_copy va_end va_list va_start \
    vfprintf vprintf vsnprintf vsprintf wcscat wcscmp wcscpy wcslen wmemcpy read write open close stdin stdout stderr null \
    eof bool";
