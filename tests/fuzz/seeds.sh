# Undamaged inputs: recordings of forty to a hundred rows (of moving mechanisms the 200 that a diagnosis needs), and
# what comes of them. `arcsmith` is the program under test.
thin() { awk 'NR == 1 || NR % 3 == 2' "$1" >thinned && mv thinned "$1"; }
unsealed() { perl -0pe 's/,\s*"sha256": "\w+"\s*\}\s*\z/\n}\n/' "$1"; }

arcsmith init --out mirror.toml
arcsmith init --kind direct --out direct.toml
arcsmith init --kind encoder --out encoder.toml
cat >plant.toml <<'END'
[plant]
kind = "second-order"
position_unit = "arcsec"
drive_unit = "A"
damping = 34.5
stiffness = 54735.7
gain = 742151165.8
hold = "band-limited"
END
{ cat plant.toml; printf '\n[[effects]]\nid = "coulomb_friction"\nforce_per_inertia = 601721.4\n'; } >friction.plant.toml

arcsmith record --protocol calibration --seed 7 --out cal.csv
arcsmith record --protocol calibration --seed 7 --temperature levels \
    --effect thermal_zero_drift:coefficient_arcsec_per_k=2 --out warm.csv
arcsmith encode --seed 7 --passes 2 --readings 40 --out enc.csv
# An axis of 10 mm between two ends, up and down twice.
awk 'BEGIN {
    print "t_s,pass,direction,measured,reference"
    for (pass = 1; pass <= 4; pass++) for (i = 0; i <= 20; i++) {
        x = (pass % 2 ? i : 20 - i) / 2
        noise = 0.0003 * ((7 * i + 3 * pass) % 5)
        printf "%d,%d,%d,%.5f,%.5f\n", 21 * pass + i, pass, pass % 2 ? 1 : -1, x + 0.0002 * x * x + noise, x
    }
}' >axis.csv
arcsmith excite --seed 7 --samples 220 --out mot.csv
arcsmith excite --seed 7 --samples 110 --periods 2 --out per.csv
arcsmith diagnose warm.csv --mirror mirror.toml --order 3 --no-report --jobs 1 --out .
mv warm.coefficients.json warm.json
unsealed warm.json >open.json
cat >mine.toml <<'END'
[[effect]]
id = "slow_heat"
title = "heat that arrives late"
adds = "k * lowpass(temperature_c - 20, tau) + 0 * k * hinge(angle, 1 [deg]) / 1 [arcsec] * 1 [K]"
k = { unit = "arcsec/K" }
tau = { unit = "min", from = 0.001, to = 5 }
END
arcsmith diagnose warm.csv --mirror mirror.toml --order 3 --effects mine.toml --no-report --jobs 1 --out own \
    --without thermal_zero_drift,thermal_lag,thermal_gain_drift,time_drift,warmup_drift,mount_step
unsealed own/warm.coefficients.json >own.json
rm -r own
thin cal.csv
thin warm.csv
gzip -n <cal.csv >cal.csv.gz

arcsmith fit cal.csv --mirror mirror.toml --order 3 --out coef.json
unsealed coef.json >bare.json
arcsmith fit warm.csv --mirror mirror.toml --order 3 --out two.json
arcsmith fit enc.csv --mirror encoder.toml --splits 5 --out enc.json
arcsmith fit axis.csv --mirror direct.toml --order 2 --splits 5 --out axis.json
arcsmith apply cal.csv --coefficients coef.json --out applied.csv
sed 1s/angle_arcsec/reference_arcsec/ applied.csv >sim.csv
arcsmith generate --coefficients coef.json --format f32 --degree 3 --bound 100arcsec --out firmware
arcsmith generate --devices coef.json two.json --format q31 --degree 3 --bound 100arcsec --out units

# Last: beside it every command above would be that of a project.
cat >arcsmith.toml <<'END'
recordings = ["cal.csv"]
verifications = ["warm.csv"]
mirror = "mirror.toml"
out = "results"

[columns]
x1_mm = { column = "x1_mm", unit = "mm" }

[fit]
order = 3

[diagnose]
order = 3
jobs = 1

[[generate]]
out = "angle"
format = ["f32"]
degree = 3
bound = "100arcsec"

[[generate]]
out = "pages"
devices = ["cal.csv", "warm.csv"]
page_address = "0x0801f800"
format = "q31"
degree = 3
bound = "100arcsec"
END
