//! Where rings come from, as files and options say it.

use super::RingMethod;
use crate::rings::{Erosion, ErosionSchedule, KernelSchedule, RingSeriesParameters};
use greenstick_schema::{
    ParameterError, Unit, choice, choices, number, parameters, text, text_field,
};

choices! {
    /// Methods that make rings.
    pub enum RingMethodChoice {
        /// A continuous field, round at the pith and like the outline outside.
        Field = "field",
        /// Erosion of the section's pixels, as published.
        Erosion = "erosion",
    }
    /// Published schedules of an erosion.
    pub enum ScheduleChoice {
        /// Every pass takes a pixel, as in the publication's Fig. 5 and Table 1.
        Alternating = "alternating",
        /// Rings of different widths, as in its Fig. 6.
        Figure6 = "figure-6",
        /// Twice as wide along one direction, as in its Fig. 8.
        Eccentric = "eccentric",
    }
}

text_field! {
    KernelSchedule, "RINGS", |schedule| schedule.to_string();
    /// A list of kernels.
    pub const KERNELS
}

parameters! {
    /// Where rings come from.
    pub struct RingParameters {
        "Where rings come from", "rings" {
            /// Where rings come from.
            rings_by: RingMethodChoice = RingMethodChoice::Field, choice(RingMethodChoice::CHOICES);
            /// Kernels of the erosion; "auto" is alternating.
            schedule: Option<ScheduleChoice> = None, choice(ScheduleChoice::CHOICES).auto();
            /// Custom kernels, from the bark inwards: rings with commas between them, in each latewood and earlywood with a
            /// slash between them, such as 4*3/5,3/7; a kernel is K or WxH pixels, then optionally its offset +X+Y and tM,
            /// the threshold. The last ring repeats.
            kernels: Option<KernelSchedule> = None, text(KERNELS).auto();
            /// Also erode from a circle about the pith outwards, until both fronts meet: its radius as a share of the
            /// section's mean one, as in the publication's Fig. 7. With any kernels, eccentric ones included.
            inner_circle: Option<f64> = None, number(Unit::Fraction, 0.0, 1.0).above().auto();
        }
    }
    check |p| {
        let of_erosion = [
            ("schedule", p.schedule.is_some()),
            ("kernels", p.kernels.is_some()),
            ("inner_circle", p.inner_circle.is_some()),
        ];
        if p.rings_by == RingMethodChoice::Field
            && let Some((key, _)) = of_erosion.into_iter().find(|given| given.1)
        {
            return Err(ParameterError::Conflict(format!(
                "{key} belongs to an erosion, but rings_by is \"field\"; expected rings_by \"erosion\" with it"
            )));
        }
        if p.schedule.is_some() && p.kernels.is_some() {
            return Err(ParameterError::Conflict(
                "schedule and kernels are both given; expected one of them".to_owned(),
            ));
        }
        Ok(())
    };
}

impl RingParameters {
    /// Checks that rings are asked for in one way: an erosion makes its own, a series stands beside no `number`, which is
    /// given by the name of its parameter.
    ///
    /// # Errors
    /// [`ParameterError::Conflict`].
    pub fn check_alone(
        &self,
        number: Option<&str>,
        series: &RingSeriesParameters,
    ) -> Result<(), ParameterError> {
        if let (Some(number), Some(_)) = (number, series.series()) {
            return Err(ParameterError::Conflict(format!(
                "{number}: a list of rings says how many there are; expected only one of the two"
            )));
        }
        let given = number.or_else(|| series.series().map(|_| "a list of rings"));
        match (self.rings_by, given) {
            (RingMethodChoice::Erosion, Some(given)) => Err(ParameterError::Conflict(format!(
                "{given}: an erosion makes its own number of rings, by its kernels and the resolution; expected only one of the two"
            ))),
            _ => Ok(()),
        }
    }

    /// The method that they describe.
    pub fn method(&self) -> RingMethod {
        let schedule = match (&self.kernels, self.schedule) {
            (Some(kernels), _) => ErosionSchedule::Kernels(kernels.clone()),
            (None, Some(ScheduleChoice::Figure6)) => ErosionSchedule::Figure6,
            (None, Some(ScheduleChoice::Eccentric)) => ErosionSchedule::Eccentric,
            (None, Some(ScheduleChoice::Alternating) | None) => ErosionSchedule::Alternating,
        };
        match self.rings_by {
            RingMethodChoice::Field => RingMethod::Field,
            RingMethodChoice::Erosion => RingMethod::Erosion(Erosion {
                schedule,
                inner_circle: self.inner_circle,
            }),
        }
    }
}
