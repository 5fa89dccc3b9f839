//! What is run: commands on undamaged seeds, the cheap ones more often.

/// Weight and command line; words that name a seed, or a folder of seeds, stand for its files.
///
/// Left out are `verify` and `trials`, which take minutes by design and read nothing that the others do not.
pub const COMMANDS: [(usize, &str); 44] = [
    (24, "fit cal.csv --mirror mirror.toml --splits 5 --out new.json"),
    (8, "fit warm.csv --mirror mirror.toml --order 4 --average --json --out new.json"),
    (8, "fit cal.csv --mirror mirror.toml --map x1_mm=x1_mm:um --order 3 --out new.json"),
    (12, "fit enc.csv --mirror encoder.toml --splits 5 --out new.json"),
    (6, "fit enc.csv --mirror direct.toml --order 2 --map measured=measured:um --map reference=reference:um --out new.json"),
    (8, "fit cal.csv.gz --mirror mirror.toml --order 3 --out new.json"),
    (10, "fit cal.parquet --mirror mirror.toml --order 3 --out new.json"),
    (10, "apply cal.csv --coefficients coef.json --out new.csv"),
    (12, "apply warm.csv --coefficients warm.json --out new.csv --strict"),
    (8, "apply enc.csv --coefficients enc.json --map measured=measured:deg --out new.csv"),
    (6, "apply cal.parquet --coefficients coef.json --out new.csv"),
    (8, "report cal.csv --mirror mirror.toml --order 3 --overview over.svg --out new.html"),
    (4, "report cal.csv warm.csv --mirror mirror.toml --order 3 --no-svg --out new.html"),
    (4, "report enc.csv --mirror encoder.toml --splits 3 --out new.html"),
    (20, "diagnose cal.csv --mirror mirror.toml --order 3 --jobs 1 --out new"),
    (10, "diagnose warm.csv --mirror mirror.toml --jobs 1 --out new --held-out cal.csv"),
    (4, "diagnose cal.csv warm.csv --mirror mirror.toml --order 3 --jobs 1 --out new --json"),
    (8, "diagnose cal.csv --mirror mirror.toml --simulated sim.csv --order 3 --jobs 1 --out new"),
    (8, "diagnose enc.csv --mirror encoder.toml --jobs 1 --out new"),
    (4, "diagnose cal.csv.gz --mirror mirror.toml --order 3 --jobs 1 --out new --no-report"),
    (16, "diagnose mot.csv --plant plant.toml --jobs 1 --out new"),
    (4, "diagnose per.csv --plant plant.toml --jobs 1 --out new --json"),
    (10, "generate --coefficients coef.json --format f32 --degree 3 --bound 100arcsec --out new"),
    (10, "generate --coefficients coef.json --format q31 --degree 3 --bound 100arcsec --out new"),
    (
        6,
        "generate --coefficients warm.json --further temperature_c=15..35 --format q31-split --degree 3 --bound 100arcsec --out new",
    ),
    (
        12,
        "generate --coefficients warm.json --further temperature_c=15..35 --format q31 --degree 3 --bound 100arcsec --period-s 0.001 --out new",
    ),
    (4, "generate --coefficients coef.json --format q31 --table 1x8 --bound 100arcsec --out new"),
    (
        4,
        "generate --coefficients coef.json --format q15 --degree 3 --bound 100arcsec --input x1x2-counts --gain 2e-5 --out new",
    ),
    (4, "generate --coefficients enc.json --bits 12 --out new"),
    (
        4,
        "generate --recording cal.csv --mirror mirror.toml --format f32 --degree 3 --bound 100arcsec --out new",
    ),
    (4, "generate --units coef.json two.json --format q31 --degree 3 --bound 100arcsec --out new"),
    (
        2,
        "generate --coefficients coef.json --format q31 --degree 3 --bound 100arcsec --pages-for units/units.json --out new",
    ),
    (10, "check --coefficients coef.json --format f32 --degree 3 --bound 100arcsec --out firmware"),
    (1, "explore --coefficients coef.json --format f32 --bound 100arcsec --svg new.svg"),
    (8, "simulate --plant plant.toml --drive mot.csv --out new.csv"),
    (8, "simulate --plant friction.plant.toml --drive mot.csv --out new.csv"),
    (
        4,
        "record --protocol calibration --seed 7 --effect thermal_lag:coefficient_arcsec_per_k=1,time_constant_s=100 --out new.csv",
    ),
    (4, "encode --seed 7 --passes 2 --readings 40 --out new.csv.gz"),
    (4, "excite --seed 7 --samples 64 --effect coulomb_friction:force_per_inertia=1e5 --out new.csv"),
    (4, "init --kind encoder --out new.toml"),
    (1, "schema"),
    (1, "effects --json"),
    (2, "man --out firmware"),
    (1, "completions bash"),
];
