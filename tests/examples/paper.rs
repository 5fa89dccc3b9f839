//! Prints the paper's table over many simulated devices: `cargo run --release -p arcsmith-tests --example paper`.

use arcsmith_tests::paper::{Outcome, campaign, curve, quantile, share};

fn main() {
    let count = std::env::args().nth(1).map_or(Ok(200), |text| text.parse());
    let Ok(count @ 1..) = count else {
        eprintln!("expected the number of devices, 1 or more");
        std::process::exit(2);
    };
    let outcomes = campaign(count);
    println!("{count} devices, with the generated q31 routine in the loop\n");
    println!("order      devices   training   testing error (arcsec, all devices)");
    for order in 1..=15 {
        let devices = outcomes.iter().filter(|o| o.order == order).count();
        if let Some((training, testing)) = curve(&outcomes, order) {
            println!("{order:>5} {devices:>12} {training:>10.3} {testing:>9.3}");
        }
    }
    println!("\n{:<44} {:>8} {:>8} {:>8} {:>8} {:>8}", "", "10 %", "median", "90 %", "worst", "share");
    let row = |name: &str, value: &dyn Fn(&Outcome) -> f64, limit: f64| {
        let at = |part| quantile(&outcomes, part, value);
        let share = 100.0 * share(&outcomes, |o| value(o) < limit);
        println!(
            "{name:<44} {:>8.3} {:>8.3} {:>8.3} {:>8.3} {share:>6.1} %",
            at(0.1),
            at(0.5),
            at(0.9),
            at(1.0)
        );
    };
    row("before, largest error, deg (< 0.29)", &|o| o.before_deg, 0.29);
    row("largest fit error of a mean, arcsec (< 0.5)", &|o| o.fit_error, 0.5);
    row("largest mean error in ±1.3°, arcsec (< 1.1)", &|o| o.mean_error, 1.1);
    row("largest mean error in ±1.4°, arcsec (< 1.1)", &|o| o.mean_error_all, 1.1);
    row("rms of the mean errors, arcsec", &|o| o.mean_error_rms, f64::INFINITY);
    row("largest standard deviation, arcsec (< 1.2)", &|o| o.deviation, 1.2);
    row("bound of the routine, 10⁻³ arcsec (≤ 10)", &|o| 1e3 * o.bound, 10.0);
    println!(
        "\norders 7 to 11: {:.1} % of the devices",
        100.0 * share(&outcomes, |o| (7..=11).contains(&o.order))
    );
}
