//! Names in generated source: which words may become one, and which already mean something there.

use crate::generate::GenerateError;
use crate::options::Options;

/// Most characters of a name, those that C99 tells apart inside a file.
const LONGEST: usize = 63;

/// The base name of crate, files and functions: the one that was asked for, or the usual.
///
/// # Errors
/// [`GenerateError::Name`] of a word that no source can carry, [`GenerateError::ReservedName`] of one with a meaning of
/// its own.
pub fn base(options: &Options, usual: &str) -> Result<String, GenerateError> {
    let name = options.name.as_deref().unwrap_or(usual).to_string();
    if !is_identifier(&name) {
        return Err(GenerateError::Name { what: "the name", name });
    }
    match options.name.as_ref().and_then(|asked| reserved(asked)) {
        Some(why) => Err(GenerateError::ReservedName { name, why }),
        None => Ok(name),
    }
}

/// Whether a name can stand in generated source: a letter, then letters, digits and underscores, not too many, no keyword.
pub fn is_identifier(name: &str) -> bool {
    let mut characters = name.chars();
    name.len() <= LONGEST
        && characters.next().is_some_and(|c| c.is_ascii_alphabetic())
        && characters.all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !KEYWORDS.contains(&name)
}

/// Words of C99 and Rust that no name may take.
const KEYWORDS: &[&str] = &[
    "abstract", "as", "async", "auto", "await", "become", "box", "break", "case", "char", "const",
    "continue", "crate", "default", "do", "double", "dyn", "else", "enum", "extern", "false", "final",
    "float", "fn", "for", "gen", "goto", "if", "impl", "in", "inline", "int", "let", "long", "loop", "macro",
    "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "register", "restrict", "return",
    "self", "Self", "short", "signed", "sizeof", "static", "struct", "super", "switch", "trait", "true",
    "try", "type", "typedef", "typeof", "union", "unsafe", "unsigned", "unsized", "use", "virtual", "void",
    "volatile", "where", "while", "yield",
];

/// What a name already means; none where it may be taken. File systems may not tell capitals from small letters.
fn reserved(name: &str) -> Option<&'static str> {
    let small = name.to_ascii_lowercase();
    let among = |words: &str| words.split_ascii_whitespace().any(|word| word == small);
    let meanings = [
        (HEADERS, "a header of C or POSIX, which the generated one would hide"),
        (FUNCTIONS, "a function or macro of the C library"),
        (CRATES, "a crate, file or function that Rust and C treat as their own"),
        (OWN, "a name inside the generated files"),
        (DEVICES, "a device on Windows, where no file can have its name"),
    ];
    if name.contains("__") || name.ends_with("_t") {
        return Some("reserved: C++ has the names with two underscores, POSIX those that end in _t");
    }
    meanings.into_iter().find(|(words, _)| among(words)).map(|(_, why)| why)
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

/// Crates of Rust's distribution, and files and functions where programs begin.
const CRATES: &str = "alloc core std proc_macro test main lib build deps examples incremental";

/// Parameters, variables and helper functions of the templates.
const OWN: &str = "limit limit_f32 limit_i32 limit_i64 high_word mul_high mul_short mul_split phase_of shift_right to_signed \
    around table row state result count coefficients page bytes s x1 x2 measured";

/// Names that Windows gives to devices.
const DEVICES: &str = "aux con nul prn com1 com2 com3 com4 com5 com6 com7 com8 com9 lpt1 lpt2 lpt3 lpt4 lpt5 lpt6 lpt7 lpt8 \
    lpt9";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers() {
        assert!(is_identifier("corrected_angle") && is_identifier("mm"));
        assert!(!is_identifier("µm") && !is_identifier("9mm") && !is_identifier("fn") && !is_identifier(""));
        assert!(!is_identifier("_a") && !is_identifier("a b") && !is_identifier(&"a".repeat(64)));
    }

    #[test]
    fn a_name_that_means_something_is_not_taken_but_the_usual_ones_are() {
        for name in
            ["stdint", "StdInt", "math", "pthread", "abs", "core", "limit", "nul", "a__b", "angle_t", "lib"]
        {
            let options = Options { name: Some(name.into()), ..Options::default() };
            assert!(matches!(base(&options, "usual"), Err(GenerateError::ReservedName { .. })), "{name}");
        }
        for name in ["torque", "isolated", "string_angle", "axis_1", "corrected_angle"] {
            assert_eq!(reserved(name), None, "{name}");
        }
        // A direct sensor's unit may be anything that can be part of a name.
        assert_eq!(base(&Options::default(), "corrected_t").unwrap(), "corrected_t");
    }
}
