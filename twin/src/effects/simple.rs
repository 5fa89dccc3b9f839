//! Mechanisms of one hook that remember nothing: what they do is a function of the pose.

use std::sync::Arc;

use super::{Made, Mechanism, Pose};

type Value = dyn Fn(&Pose) -> f64 + Send + Sync;
type Change = dyn Fn(&Pose, &mut [f64; 2]) + Send + Sync;

#[derive(Clone)]
enum Simple {
    Seen(Arc<Value>),
    Read(Arc<Value>),
    Reported(Arc<Change>),
}

/// One by [`Mechanism::seen_rotation_rad`].
pub(super) fn seen(rotation_rad: impl Fn(&Pose) -> f64 + Send + Sync + 'static) -> Made {
    Ok(Box::new(Simple::Seen(Arc::new(rotation_rad))))
}

/// One by [`Mechanism::reference_arcsec`].
pub(super) fn read(reference_arcsec: impl Fn(&Pose) -> f64 + Send + Sync + 'static) -> Made {
    Ok(Box::new(Simple::Read(Arc::new(reference_arcsec))))
}

/// One by [`Mechanism::report`].
pub(super) fn reported(change: impl Fn(&Pose, &mut [f64; 2]) + Send + Sync + 'static) -> Made {
    Ok(Box::new(Simple::Reported(Arc::new(change))))
}

impl Mechanism for Simple {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        if let Simple::Seen(rotation_rad) = self { rotation_rad(pose) } else { 0.0 }
    }

    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        if let Simple::Read(reference_arcsec) = self { reference_arcsec(pose) } else { 0.0 }
    }

    fn report(&self, pose: &Pose, reports_mm: &mut [f64; 2]) {
        if let Simple::Reported(change) = self {
            change(pose, reports_mm);
        }
    }
}
