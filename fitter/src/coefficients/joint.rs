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
