//! The numbers of a column, which may lie in the memory of another program.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// The numbers of a column: its own, or lent by a table in memory, which stays there as long as they are used. They are
/// read as a slice; lent ones are copied when they are first written to.
#[derive(Clone)]
pub struct Values(Kept);

#[derive(Clone)]
enum Kept {
    Own(Vec<f64>),
    Lent(Arc<dyn AsRef<[f64]> + Send + Sync>),
}

impl Values {
    /// Numbers that are lent: none of them is copied.
    ///
    /// ```
    /// let lent = std::sync::Arc::new(vec![1.0, 2.0]);
    /// let values = fitter::table::Values::lent(lent.clone());
    /// assert_eq!(values.as_ptr(), lent.as_ptr());
    /// ```
    pub fn lent(values: Arc<dyn AsRef<[f64]> + Send + Sync>) -> Values {
        Values(Kept::Lent(values))
    }

    /// The numbers as a vector; lent ones are copied.
    pub fn into_vec(self) -> Vec<f64> {
        match self.0 {
            Kept::Own(values) => values,
            Kept::Lent(values) => (*values).as_ref().to_vec(),
        }
    }
}

impl Deref for Values {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match &self.0 {
            Kept::Own(values) => values,
            Kept::Lent(values) => (**values).as_ref(),
        }
    }
}

impl DerefMut for Values {
    fn deref_mut(&mut self) -> &mut [f64] {
        if let Kept::Lent(values) = &self.0 {
            self.0 = Kept::Own((**values).as_ref().to_vec());
        }
        match &mut self.0 {
            Kept::Own(values) => values,
            Kept::Lent(_) => &mut [],
        }
    }
}

impl Default for Values {
    fn default() -> Values {
        Vec::new().into()
    }
}

impl From<Vec<f64>> for Values {
    fn from(values: Vec<f64>) -> Values {
        Values(Kept::Own(values))
    }
}

impl FromIterator<f64> for Values {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Values {
        values.into_iter().collect::<Vec<f64>>().into()
    }
}

impl<'a> IntoIterator for &'a Values {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Values {
    type Item = &'a mut f64;
    type IntoIter = std::slice::IterMut<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl PartialEq for Values {
    fn eq(&self, other: &Values) -> bool {
        **self == **other
    }
}

impl std::fmt::Debug for Values {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(f)
    }
}
