use diagnosis::{effects, explain, observe};
fn main() {
    let catalogue = effects::catalogue();
    let mirror = fitter::Mirror::read(std::path::Path::new(&std::env::args().nth(1).unwrap())).unwrap();
    for f in std::env::args().skip(2) {
        let r = fitter::Recording::read(std::path::Path::new(&f)).unwrap();
        let rows = observe::observe(&r, &mirror, None).unwrap();
        let start = std::time::Instant::now();
        let e =
            explain::explain(&rows, &catalogue, &std::env::var("SKIP").into_iter().collect::<Vec<String>>());
        let took = start.elapsed().as_secs_f64() * 1e3;
        let s = &e.search;
        print!(
            "{} n={} sigma {:.3} phi {:.2} dof {:.0} thr {:.1} {took:.0} ms |",
            r.file,
            rows.len(),
            s.noise.level,
            s.noise.correlation.typical(),
            s.noise.freedom,
            s.calibration.threshold
        );
        if let Some(a) = &e.alarm {
            print!(" alarm fam {} S {:.1} lnp {:.1} |", a.term.family, a.explained, s.family_wise(a));
        }
        for (k, t) in e.terms.iter().enumerate() {
            let name = match &s.dictionary.families[t.family].kind {
                diagnosis::dictionary::Kind::Effect(i) => catalogue[*i].id().to_string(),
                diagnosis::dictionary::Kind::Generic(p) => format!("GENERIC {}x{:?}", p.variable, p.times),
                _ => "ORDER".into(),
            };
            let mut wo = e.terms.clone();
            wo.remove(k);
            print!(
                " {name} {:?} dS {:.1} (price {:.1});",
                t.shape,
                s.explained(&e.terms) - s.explained(&wo),
                s.price(t)
            );
        }
        println!();
        if std::env::var("SURVEY").is_ok() {
            let mut found = s.survey(&[]);
            found.sort_by(|a, b| s.gain(b).total_cmp(&s.gain(a)));
            for f in found.iter().take(16) {
                let name = match &s.dictionary.families[f.term.family].kind {
                    diagnosis::dictionary::Kind::Effect(i) => catalogue[*i].id().to_string(),
                    diagnosis::dictionary::Kind::Generic(p) => {
                        format!("GENERIC {}x{:?}", p.variable, p.times)
                    }
                    _ => "ORDER".into(),
                };
                println!(
                    "      {name} {:?} S {:.1} price {:.1} -ln p {:.1}",
                    f.term.shape,
                    f.explained,
                    s.price(&f.term),
                    s.family_wise(f)
                );
            }
        }
        if std::env::var("TOP").is_ok() {
            let name = |f: usize| match &s.dictionary.families[f].kind {
                diagnosis::dictionary::Kind::Effect(i) => catalogue[*i].id().to_string(),
                diagnosis::dictionary::Kind::Generic(p) => format!("GENERIC {}x{:?}", p.variable, p.times),
                _ => "ORDER".into(),
            };
            for k in 0..e.terms.len() {
                let mut wo = e.terms.clone();
                let t = wo.remove(k);
                println!(
                    "   in place of {} ({:.1}):",
                    name(t.family),
                    s.explained(&e.terms) - s.explained(&wo) - s.price(&t)
                );
                for f in s.contenders(&wo, |_| true).iter().take(7) {
                    println!(
                        "      {} {:?} S {:.1} gain {:.1}",
                        name(f.term.family),
                        f.term.shape,
                        f.explained,
                        s.gain(f)
                    );
                }
            }
            println!("   left:");
            for f in s.contenders(&e.terms, |_| true).iter().take(4) {
                println!(
                    "      {} {:?} S {:.1} gain {:.1}",
                    name(f.term.family),
                    f.term.shape,
                    f.explained,
                    s.gain(f)
                );
            }
        }
    }
}
