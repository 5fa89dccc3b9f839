//! Whether what was found is more than noise that lasts: white readings with parts that are forgotten slowly, a reference that
//! wanders, flicker. Such noise makes dependences on whatever changed slowly, and no other recording repeats them.

use numerics::dot;

use crate::base::base_columns;
use crate::explain::{Explanation, first_order};
use crate::judge::least;
use crate::model::choose_order;
use crate::search::{Search, Term};
use crate::thresholds::lasting::{BY_CHANCE, LIKELIER, TRIED};
use crate::thresholds::search::select::MOST_TERMS;

/// A recording whose noise may last.
pub struct Lasting<'a, 'b> {
    explanation: &'b Explanation<'a>,
    base: Vec<Vec<f64>>,
}

impl<'a, 'b> Lasting<'a, 'b> {
    /// Beside a base of this order, and further ones that were found.
    pub fn new(explanation: &'b Explanation<'a>, order: usize) -> Self {
        let mut base = base_columns(explanation.search.rows, order);
        base.extend(explanation.orders().flat_map(|t| t.columns.iter().cloned()));
        Lasting { explanation, base }
    }

    /// What further terms gain beside others, noise being whatever suits either best, less what the search asks of them: what
    /// chance explains once in so many recordings of nothing, over all effects and forms. Of one alone no more is asked than
    /// chance gains in noise that lasts; of several, of which there are many more, chance makes more.
    fn above(&self, others: &[&Term], added: &[&Term]) -> f64 {
        let search = &self.explanation.search;
        let noise = &search.noise;
        let mut beside = [self.base.clone(), columns(others)].concat();
        let mut own = Vec::new();
        for term in added {
            let count = search.dictionary.families[term.family].own.unwrap_or(term.columns.len());
            own.extend_from_slice(&term.columns[..count]);
            // What is missing of an effect shows nothing.
            beside.extend_from_slice(&term.columns[count..]);
        }
        let gain = noise.correlation.gain(&noise.clean, &beside, &noise.sigma, &own);
        let asked = added.iter().map(|term| search.price(term)).sum::<f64>();
        let alone = others.is_empty() && added.len() == 1;
        gain - if alone { asked.min(BY_CHANCE) } else { asked }
    }

    /// Which terms would be found if noise lasted as it suits the recording best: all of them together, and each beside the
    /// others, must stand above it. What is left when the weakest are taken out; asked of each beside the others alone,
    /// several that noise has made would hold one another up.
    pub fn beyond(&self, terms: &[Term]) -> Vec<bool> {
        let mut kept: Vec<usize> = (0..terms.len()).collect();
        while !kept.is_empty() {
            let all: Vec<&Term> = kept.iter().map(|k| &terms[*k]).collect();
            let above: Vec<f64> = (0..all.len())
                .map(|k| {
                    let mut others = all.clone();
                    let own = others.remove(k);
                    self.above(&others, &[own])
                })
                .collect();
            if self.above(&[], &all) >= 0.0 && above.iter().all(|above| *above >= 0.0) {
                break;
            }
            kept.remove(least(above.len(), |k| above[k]));
        }
        (0..terms.len()).map(|k| kept.contains(&k)).collect()
    }

    /// The effect that stands highest above noise that lasts beside these terms, by a search in such noise; none where none
    /// does. The noise takes its part of what is slow, so that a simpler effect may be enough.
    fn strongest(&self, terms: &[Term]) -> Option<Term> {
        let (search, _) = self.search_in_likeliest_noise(terms);
        let beside: Vec<Term> = self.explanation.orders().chain(terms).cloned().collect();
        let of_device = |f: usize| search.effect(f).is_some_and(|e| !search.catalogue[e].of_one_time);
        let found = search.contenders(&beside, of_device);
        let others: Vec<&Term> = terms.iter().collect();
        let above = found.iter().take(TRIED).map(|found| (self.above(&others, &[&found.term]), &found.term));
        let best = above.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 >= 0.0).then(|| best.1.clone())
    }

    /// The search in the noise that is likeliest beside terms, and by how much that is likelier than the search's own, in −2
    /// log likelihood.
    fn search_in_likeliest_noise(&self, terms: &[Term]) -> (Search<'a>, f64) {
        let whole = &self.explanation.search;
        let mut noise = whole.noise.clone();
        let model = [self.base.clone(), columns(&terms.iter().collect::<Vec<_>>())].concat();
        let (process, likelier) = noise.correlation.likeliest(&noise.clean, &model, &noise.sigma);
        noise.correlation = noise.correlation.with(&process);
        let beside: Vec<Term> = self.explanation.orders().chain(terms).cloned().collect();
        let (basis, left) = Search::with_noise(whole, noise.clone()).fit(&beside);
        // Of variance one beside these terms.
        let freedom = left.len().saturating_sub(basis.rank()).max(1) as f64;
        let scale = (dot(&left, &left) / freedom).sqrt();
        noise.sigma.iter_mut().for_each(|sigma| *sigma *= scale);
        (Search::with_noise(whole, noise), likelier)
    }
}

/// An explanation in the noise that is likeliest beside it, where that is clearly another one than the search took for
/// given, with what stands above that noise in the place of effects of the device that do not. As it is where nothing does.
pub fn in_likeliest_noise(explanation: Explanation) -> Explanation {
    let search = &explanation.search;
    let of_device = |t: &Term| search.effect(t.family).is_some_and(|e| !search.catalogue[e].of_one_time);
    // A step or a drift stays. A form of what happened once, such as a wave, follows noise that lasts, and is asked like the device's.
    let event = |t: &Term| {
        let effect = search.effect(t.family).map(|e| &search.catalogue[e]);
        effect.is_some_and(|effect| effect.of_one_time && !effect.is_form())
    };
    let mut kept: Vec<Term> =
        explanation.terms.iter().filter(|t| !search.is_order(t.family)).cloned().collect();
    if explanation.gross || !kept.iter().any(of_device) {
        return explanation;
    }
    let order = choose_order(&explanation, &kept).max(first_order(search.rows));
    let lasting = Lasting::new(&explanation, order);
    let mut beyond = lasting.beyond(&kept).into_iter();
    let all = kept.len();
    kept.retain(|term| beyond.next() == Some(true) || event(term));
    let some_fell = kept.len() < all;
    while some_fell
        && kept.len() < MOST_TERMS
        && let Some(term) = lasting.strongest(&kept)
    {
        kept.push(term);
    }
    let (search, likelier) = lasting.search_in_likeliest_noise(&kept);
    if likelier < LIKELIER || !kept.iter().any(of_device) {
        return explanation;
    }
    let mut terms: Vec<Term> = explanation.orders().cloned().chain(kept).collect();
    search.backfit(&mut terms);
    Explanation { chosen: terms.len(), search, terms, floor: explanation.floor, gross: explanation.gross }
}

fn columns(terms: &[&Term]) -> Vec<Vec<f64>> {
    terms.iter().flat_map(|term| term.columns.iter().cloned()).collect()
}
