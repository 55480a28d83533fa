//! Parts that are in the same place at the start.

use crate::engine::Engine;
use crate::error::WorldError;
use crate::parts::PartTable;
use rapier3d_f64::parry::query;

/// Parts may be in one another this deep, m: people write the sizes of things that touch.
const ALLOWED: f64 = 1e-4;

pub(crate) fn refuse_overlaps(engine: &Engine, parts: &PartTable) -> Result<(), WorldError> {
    let bodies: Vec<_> = parts.bodies.values().collect();
    for (i, a) in bodies.iter().enumerate() {
        for b in &bodies[i + 1..] {
            let colliders = &engine.physics.colliders;
            let (Some(ca), Some(cb)) = (colliders.get(a.collider), colliders.get(b.collider))
            else {
                continue;
            };
            let contact = query::contact(ca.position(), ca.shape(), cb.position(), cb.shape(), 0.0);
            let depth_m = contact.ok().flatten().map_or(0.0, |contact| -contact.dist);
            if depth_m > ALLOWED {
                return Err(WorldError::Overlap {
                    a: a.name.to_string(),
                    b: b.name.to_string(),
                    depth_m,
                });
            }
        }
    }
    Ok(())
}
