//! What is known of polynomial and terms together: they are fitted jointly, and what one leaves open the other takes.

use super::Coefficients;

impl Coefficients {
    /// How many coefficients there are: the polynomial's and those of all terms.
    pub fn count_of_all(&self) -> usize {
        self.base.coefficients.len() + self.terms.iter().map(|t| t.coefficients.len()).sum::<usize>()
    }

    /// Covariance of the polynomial's coefficients and after them of all terms', each in its own unit. Where the file
    /// does not state it jointly, each part's own, as if they were independent; none where one of these is missing.
    pub fn covariance_of_all(&self) -> Option<Vec<Vec<f64>>> {
        let n = self.count_of_all();
        if self.joint_covariance.len() == n {
            return Some(self.joint_covariance.clone());
        }
        let of_base = &self.identification.as_ref()?.covariance;
        let mut all = vec![vec![0.0; n]; n];
        let mut first = 0;
        let parts = self.terms.iter().map(|t| (&t.covariance, t.coefficients.len()));
        for (block, size) in std::iter::once((of_base, self.base.coefficients.len())).chain(parts) {
            if block.len() != size {
                return None;
            }
            for (i, row) in block.iter().enumerate() {
                all[first + i][first..first + size].copy_from_slice(row.get(..size)?);
            }
            first += size;
        }
        Some(all)
    }

    /// Takes coefficients out of the joint covariance: what is left are those for which `keep` holds, by their number
    /// in it.
    pub fn keep_in_covariance(&mut self, keep: impl Fn(usize) -> bool) {
        let kept = |row: &Vec<f64>| -> Vec<f64> {
            row.iter().enumerate().filter(|(k, _)| keep(*k)).map(|(_, c)| *c).collect()
        };
        let rows = self.joint_covariance.iter().enumerate().filter(|(k, _)| keep(*k));
        self.joint_covariance = rows.map(|(_, row)| kept(row)).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coefficients::parse;
    use crate::error_model::{ErrorModel, Sensor};
    use crate::terms::{Operator, Product, Scope, Term};

    /// A polynomial of two coefficients and a drift, with a joint covariance.
    fn file() -> Coefficients {
        let sensor = Sensor::Direct { unit: "mm".into(), revolution: None };
        let model = ErrorModel { sensor, centre: 0.0, coefficients: vec![0.1, 0.2] };
        let mut file = Coefficients::of_model(&model, -1.0, 1.0, "by hand");
        file.terms.push(Term {
            effect: "thermal_zero_drift".into(),
            scope: Scope::Device,
            operator: Operator::Product(Product::of("temperature_c", 22.0)),
            coefficients: vec![0.3],
            covariance: vec![vec![5.0]],
        });
        file.joint_covariance = vec![vec![1.0, 0.5, -0.2], vec![0.5, 2.0, 0.1], vec![-0.2, 0.1, 5.0]];
        file
    }

    #[test]
    fn what_is_stated_jointly_comes_before_the_parts() {
        let mut file = file();
        let read = parse("a.json", &file.to_sealed_json()).unwrap();
        assert_eq!(read.covariance_of_all(), Some(file.joint_covariance.clone()));
        file.keep_in_covariance(|k| k != 1);
        assert_eq!(file.joint_covariance, vec![vec![1.0, -0.2], vec![-0.2, 5.0]]);
        // Of a polynomial without a covariance of its own nothing is known.
        file.joint_covariance.clear();
        assert_eq!(file.covariance_of_all(), None);
    }

    #[test]
    fn another_size_is_refused() {
        let mut file = file();
        file.joint_covariance.pop();
        let error = parse("a.json", &file.to_json()).unwrap_err().to_string();
        assert!(error.contains("`joint_covariance` is not 3 by 3"), "{error}");
        file.joint_covariance.push(vec![0.0, 0.0]);
        assert!(parse("a.json", &file.to_json()).is_err());
    }
}
