//! Every parameter of a break starts at the stage that its declaration names: never before it, and at it in some break.

use greenstick::fracture::recipe::apply_setting;
use greenstick::geometry::Context;
use greenstick::schema::{Kind, ParameterInfo, Parameters, Value};
use greenstick::{Break, BreakRequest, BreakSession, BreakStage, built_in_branch};
use rayon::prelude::*;

/// Breaks that between them use every parameter: with straight grain, which spiral grain follows the broken face of, and
/// with cracks in the broken face, as those at a sawn end belong to the stem.
const BREAKS: [&[&str]; 5] = [
    &["surface=fibrous", "split=0.5"],
    &[
        "surface=fibrous",
        "hang=30",
        "inclination=20",
        "fray=0.4",
        "species=temple juniper",
    ],
    &[
        "surface=smooth",
        "inclination=20",
        "high.height=1",
        "high.angle=90",
        "high.rings=0.6",
        "low.height=-1",
        "low.angle=90",
        "low.rings=0.6",
        "ductile.thorn_length=1",
        "ductile.thorn_probability=0.3",
        "brittle.thorn_length=0.5",
        "brittle.thorn_probability=0.3",
        "fray=0.4",
    ],
    &[
        "surface=smooth",
        "crack_groups.large.count=2",
        "crack_groups.medium.count=2",
        "crack_groups.small.count=2",
        "species=white oak",
    ],
    &[
        "surface=fibrous",
        "heights.values=2 mm, -2 mm",
        "heights.modes=torn, split",
        "heights.splintering=1, 2",
        "heights.between_angles=-1, 2",
    ],
];

fn request(settings: &[&str]) -> BreakRequest {
    let mut one = Break::default();
    for setting in ["rings=10", "sectors=24"].iter().chain(settings) {
        apply_setting(&mut one, setting).unwrap();
    }
    one.check().unwrap();
    BreakRequest {
        texture_width: 8,
        ..BreakRequest::single(one)
    }
}

/// A request, and a session that has cached all of its stages.
struct Prepared {
    request: BreakRequest,
    session: BreakSession,
}

impl Prepared {
    fn new(found: &BreakSession, settings: &[&str]) -> Self {
        let (request, context) = (request(settings), Context::quiet());
        let mut session = found.fork();
        session.stages(&request, &context).unwrap();
        session.pieces(&request, &context).unwrap();
        Prepared { request, session }
    }

    /// The stage that a change of a parameter starts at; `None` where nothing up to the pieces changes.
    fn started(&self, info: &ParameterInfo) -> Option<BreakStage> {
        let mut after = self.request.clone();
        let one = &mut after.breaks[0];
        let own = one.list().into_iter().find(|p| p.key == info.key).unwrap();
        let word = match info.key.as_str() {
            "at" => "0.51",
            key if key.ends_with("_color") => "#c08040",
            _ => "Ash, white",
        };
        let value = match own.kind {
            Kind::Text { .. } => Value::Text(word.into()),
            // Fewer than most of them have.
            _ if info.key == "triangles" => Value::Integer(20_000),
            _ => own.neighbour()?,
        };
        one.set(&info.key, &value).unwrap();
        // Two parameters that must be in order are.
        if one.check().is_err() {
            return None;
        }
        let (mut session, context) = (self.session.fork(), Context::quiet());
        let stages = session.stages(&after, &context);
        // Enough for most of them.
        if info.key == "triangles" && stages.is_err() {
            return None;
        }
        stages.unwrap();
        if session.started_at().is_none() {
            session.pieces(&after, &context).unwrap();
        }
        session.started_at()
    }
}

#[test]
fn every_parameter_starts_at_its_declared_stage() {
    let mut session = BreakSession::new(built_in_branch());
    session.stem(&request(&[]), &Context::quiet()).unwrap();
    let prepared = BREAKS.map(|settings| Prepared::new(&session, settings));
    Break::table().par_iter().for_each(|info| {
        let started = prepared.iter().filter_map(|p| p.started(info));
        let earliest = started.min().map(BreakStage::name);
        assert_eq!(earliest, Some(info.stage), "{}", info.key);
    });
}
