//! Who is evaluated: the controllers, some of them in more than one form.

use clap::ValueEnum;
use controller_core::config::WiringKind;
use controller_core::scalar::Scalar;
use host_sim::config_file;
use host_sim::contender::Contender;
use host_sim::evaluation::Subject;
use host_sim::settings::Settings;
use host_sim::sil::Indirect;
use host_sim::sweep::Maps;
use host_sim::training::TrainingPlan;

use super::super::super::error::CliError;
use super::super::super::learning::{learn_each, seeds};
use super::SceneArgs;

/// A column of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Entrant {
    /// Cooperative EKMs with neural integration (P2)
    Cooperative,
    /// The same with the built-in configuration `literal`: the papers word by word, maps learned so as well
    Literal,
    /// Braitenberg avoidance with command fusion (P1), by default with the papers' symmetric wiring
    Fusion,
    /// The same with the asymmetric wiring, the best one found
    FusionAsymmetric,
    /// Artificial potential field (Khatib 1986)
    Apf,
    /// Vector field histogram, VFH+ (Ulrich and Borenstein 1998)
    Vfh,
    /// Dynamic window approach (Fox, Burgard and Thrun 1997)
    Dwa,
    /// Bug2 (Lumelsky and Stepanov 1987)
    Bug2,
}

impl Entrant {
    /// Each controller once, in the form that its configuration gives it.
    pub const CONTENDERS: [Self; 6] =
        [Self::Cooperative, Self::Fusion, Self::Apf, Self::Vfh, Self::Dwa, Self::Bug2];

    pub fn name(self) -> &'static str {
        match self {
            Self::Literal => "literal",
            Self::FusionAsymmetric => "fusion-asymmetric",
            _ => self.contender().name(),
        }
    }

    pub fn contender(self) -> Contender {
        match self {
            Self::Cooperative | Self::Literal => Contender::Cooperative,
            Self::Fusion | Self::FusionAsymmetric => Contender::Fusion,
            Self::Apf => Contender::PotentialField,
            Self::Vfh => Contender::VfhPlus,
            Self::Dwa => Contender::DynamicWindow,
            Self::Bug2 => Contender::Bug2,
        }
    }

    /// Its numbers, where the others have `base`.
    fn settings(self, base: &Settings) -> Result<Settings, CliError> {
        let mut settings = base.clone();
        match self {
            Self::Literal => settings = config_file::load("literal".as_ref())?,
            Self::FusionAsymmetric => settings.core.fusion.wiring = WiringKind::Asymmetric,
            _ => {}
        }
        Ok(settings)
    }
}

/// What an entrant drives with.
pub struct Equipment<S: Scalar> {
    pub settings: Settings,
    pub maps: Maps<S, Indirect<S>>,
}

impl<S: Scalar> Equipment<S> {
    pub fn subject(&self, entrant: Entrant) -> Subject<'_, S> {
        Subject { settings: &self.settings, contender: entrant.contender(), maps: &self.maps }
    }
}

/// The equipment of each entrant; maps are learned once for all that learn alike.
pub fn equip<S: Scalar>(
    entrants: &[Entrant],
    base: &Settings,
    args: &SceneArgs,
) -> Result<Vec<Equipment<S>>, CliError> {
    let training = TrainingPlan { steps: args.steps, ..TrainingPlan::default() };
    let learn = |settings: &Settings| -> Result<Maps<S, Indirect<S>>, CliError> {
        let learned = learn_each::<S, Indirect<S>>(&settings.core, &training, seeds(args.seed, args.maps)?)?;
        Ok(Maps::PerRun(learned.into_iter().map(|learned| learned.map).collect()))
    };
    let mut usual = None;
    let mut equipment = Vec::new();
    for &entrant in entrants {
        let settings = entrant.settings(base)?;
        let maps = if entrant.contender().is_peer() {
            Maps::PerRun(Vec::new())
        } else if entrant == Entrant::Literal {
            learn(&settings)?
        } else {
            if usual.is_none() {
                usual = Some(learn(base)?);
            }
            usual.clone().unwrap_or(Maps::PerRun(Vec::new()))
        };
        equipment.push(Equipment { settings, maps });
    }
    Ok(equipment)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;
    use host_sim::contender::Contender;

    use super::Entrant;

    #[test]
    fn names_are_those_of_the_command_line_and_every_controller_is_there() {
        for entrant in Entrant::value_variants() {
            assert_eq!(entrant.to_possible_value().unwrap().get_name(), entrant.name());
        }
        assert_eq!(Entrant::CONTENDERS.map(Entrant::contender), Contender::ALL);
    }
}
