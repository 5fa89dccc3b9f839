//! The chain from the driven frame to the reports of the probes and to the mirror, with whatever effects
//! act in it, at one moment of a recording.

use crate::device::Device;
use crate::effects::{Mechanism, Pose};
use crate::environment::Surroundings;
use crate::protocol::Stop;

/// A device in the middle of a recording.
pub(crate) struct Chain<'a> {
    device: &'a Device,
    mechanisms: Vec<Box<dyn Mechanism>>,
    /// Where everything stood when the mirror last settled; then with the time and the surroundings of now.
    pose: Pose,
    around: Surroundings,
    /// Deviates of the second axis and of the coil current in this position.
    settled: [f64; 2],
}

impl<'a> Chain<'a> {
    /// The device at rest, before the recording.
    pub(crate) fn start(device: &'a Device) -> Self {
        let around = Surroundings::default();
        let pose = Pose {
            t_s: 0.0,
            pass: 1,
            direction: 0.0,
            temperature_c: around.temperature_c,
            translation_mm: 0.0,
            frame_rad: 0.0,
            mirror_rad: 0.0,
            coil_a: device.drive.offset_a,
            cross_arcsec: 0.0,
        };
        Self { device, mechanisms: device.mechanisms(), pose, around, settled: [0.0; 2] }
    }

    /// Time goes on to the next stop.
    pub(crate) fn advance(&mut self, stop: &Stop, around: Surroundings, settled: [f64; 2]) {
        (self.around, self.settled) = (around, settled);
        self.pose = Pose {
            t_s: stop.t_s,
            pass: stop.pass,
            direction: f64::from(stop.direction),
            temperature_c: around.temperature_c,
            translation_mm: around.translation_mm,
            ..self.pose
        };
        for mechanism in &mut self.mechanisms {
            mechanism.advance(&self.pose);
        }
    }

    /// Everything as it would stand with the frame at an angle in radians.
    pub(crate) fn pose_at(&self, frame_rad: f64) -> Pose {
        let (device, around, [cross, coil]) = (self.device, &self.around, self.settled);
        let lost_rad: f64 = self.mechanisms.iter().map(|m| m.lost_motion_rad(frame_rad)).sum();
        let mirror_rad = frame_rad - lost_rad;
        let (drive, axis) = (&device.drive, &device.second_axis);
        Pose {
            frame_rad,
            mirror_rad,
            coil_a: drive.stiffness_a_per_rad * frame_rad
                + drive.offset_a
                + drive.creep_a * around.creep
                + drive.settling_a * coil,
            cross_arcsec: axis.at(mirror_rad) + around.cross_arcsec + axis.settling_arcsec * cross,
            ..self.pose
        }
    }

    /// What the two probes report in a pose, in millimetres, without their noise.
    pub(crate) fn reports_mm(&self, pose: &Pose) -> [f64; 2] {
        let turned_rad: f64 = self.mechanisms.iter().map(|m| m.seen_rotation_rad(pose)).sum();
        let wider: f64 = self.mechanisms.iter().map(|m| m.probe_distance(pose)).product();
        let mut geometry = self.device.geometry;
        geometry.probe_distance_mm *= wider;
        let distances = geometry.pad_distances_mm(pose.frame_rad + turned_rad, pose.translation_mm);
        let mut reports = self.device.probes.report_mm(distances, &geometry);
        for mechanism in &self.mechanisms {
            mechanism.report(pose, &mut reports);
        }
        reports
    }

    /// What the autocollimator reads beyond the mirror's angle, in arcseconds.
    pub(crate) fn reference_arcsec(&self, pose: &Pose) -> f64 {
        self.mechanisms.iter().map(|m| m.reference_arcsec(pose)).sum()
    }

    /// How long after the probes the autocollimator looks back, in seconds.
    pub(crate) fn reference_delay_s(&self) -> f64 {
        self.mechanisms.iter().map(|m| m.reference_delay_s()).sum()
    }

    /// The mirror has settled with the frame at this angle.
    pub(crate) fn settle(&mut self, frame_rad: f64) -> Pose {
        self.pose = self.pose_at(frame_rad);
        for mechanism in &mut self.mechanisms {
            mechanism.settled(&self.pose);
        }
        self.pose
    }
}
