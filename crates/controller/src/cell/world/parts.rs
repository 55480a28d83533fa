//! `[[part]]`, and the solids of whatever is no plane.

use messages::text;
use world::description::{BodyShape, Copies, Mass, PartDescription};

use crate::cell::check::{InvalidValue, TableCheck};
use crate::cell::convert::pose_of;
use crate::cell::meshes::Meshes;
use crate::cell::shape::{MESH_FILE, ShapeKeys};
use crate::cell::world_schema::PartTable;

/// The solid of something that is no plane.
pub(super) fn solid(
    check: &TableCheck,
    keys: &ShapeKeys<'_>,
    meshes: &Meshes,
) -> Result<BodyShape, InvalidValue> {
    keys.check(check, false)?;
    let solid = keys.solid(meshes);
    solid.ok_or_else(|| check.missing("file", MESH_FILE))
}

pub(super) fn part(table: &PartTable, meshes: &Meshes) -> Result<PartDescription, InvalidValue> {
    let check = TableCheck::named("part", &table.name);
    let shape = solid(&check, &table.shape_keys(), meshes)?;
    let mass = match (table.mass, table.density) {
        (Some(mass), None) => Mass::Total(mass),
        (None, Some(density)) => Mass::Density(density),
        (Some(mass), Some(_)) => {
            return Err(check.wrong(
                "mass",
                mass,
                text!(
                    "either mass or density is needed",
                    "需要 mass 或 density 之一"
                ),
            ));
        }
        (None, None) => {
            return Err(check.missing(
                "mass",
                text!(
                    "either mass or density is needed",
                    "需要 mass 或 density 之一"
                ),
            ));
        }
    };
    let copies = match (table.copies, table.pitch) {
        (Some(count), Some(pitch)) => Some(Copies { count, pitch }),
        (None, None) => None,
        (Some(count), None) if count.iter().all(|n| *n <= 1) => Some(Copies {
            count,
            pitch: [0.0; 3],
        }),
        (Some(_), None) => {
            return Err(check.missing(
                "pitch",
                text!("copies need their distances", "copies 需要间距"),
            ));
        }
        (None, Some(pitch)) => {
            return Err(check.wrong(
                "pitch",
                format_args!("{pitch:?}"),
                text!("it goes with copies", "它与 copies 一起使用"),
            ));
        }
    };
    if let Some(color) = &table.color
        && !is_color(color)
    {
        return Err(check.wrong(
            "color",
            format_args!("{color:?}"),
            text!(
                "a text like \"#3a7f00\" is needed",
                "需要如 \"#3a7f00\" 的文本"
            ),
        ));
    }
    Ok(PartDescription {
        name: table.name.clone(),
        shape,
        mass,
        pose: pose_of(&table.pose),
        friction: table.friction.unwrap_or(0.5),
        restitution: table.restitution.unwrap_or(0.0),
        copies,
    })
}

fn is_color(text: &str) -> bool {
    let digits = text.strip_prefix('#').unwrap_or_default();
    digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit())
}
