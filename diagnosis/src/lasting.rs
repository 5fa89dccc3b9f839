//! Whether what was found is more than noise that lasts: white readings with parts that are forgotten slowly, a reference that
//! wanders, flicker. Such noise makes dependences on whatever changed slowly, and no other recording repeats them.

use crate::base::base_columns;
use crate::dictionary::Kind;
use crate::explain::Explanation;
use crate::judge::least;
use crate::model::Model;

/// Which terms of a model would be found if noise lasted as it suits the recording best. All of them, or what is left when the
/// weakest are taken out, must explain what the search asks of them: what chance explains once in so many recordings of
/// nothing, over all effects and forms. Asked of each beside the others alone, several that noise has made would hold one
/// another up.
pub fn beyond_lasting_noise(explanation: &Explanation, joint: &Model, order: usize) -> Vec<bool> {
    let search = &explanation.search;
    let families = &search.dictionary.families;
    let orders = explanation.terms.iter().filter(|t| matches!(families[t.family].kind, Kind::Order));
    let mut base = base_columns(search.rows, order);
    base.extend(orders.flat_map(|t| t.columns.iter().cloned()));
    let columns = |of: &[usize]| -> Vec<Vec<f64>> {
        of.iter().flat_map(|k| joint.terms[*k].term.columns.iter().cloned()).collect()
    };
    let price = |k: usize| search.price(&joint.terms[k].term);
    let noise = &search.noise;
    let gain = |model: &[Vec<f64>], added: Vec<Vec<f64>>| {
        noise.correlation.gain(&noise.clean, model, &noise.sigma, &added)
    };
    let mut kept: Vec<usize> = (0..joint.terms.len()).collect();
    while !kept.is_empty() {
        let above = |k: &usize| {
            let others: Vec<usize> = kept.iter().copied().filter(|other| other != k).collect();
            gain(&[base.clone(), columns(&others)].concat(), columns(&[*k])) - price(*k)
        };
        let above: Vec<f64> = kept.iter().map(above).collect();
        let together = gain(&base, columns(&kept)) - kept.iter().map(|k| price(*k)).sum::<f64>();
        if together >= 0.0 && above.iter().all(|above| *above >= 0.0) {
            break;
        }
        kept.remove(least(above.len(), |k| above[k]));
    }
    (0..joint.terms.len()).map(|k| kept.contains(&k)).collect()
}
