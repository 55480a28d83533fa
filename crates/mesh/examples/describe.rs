//! A mesh in numbers, as JSON: `describe FILE [SCALE [PIECES]]`.

use std::path::Path;
use std::sync::Arc;

use mesh::{Folder, MeshError, Solid, convex_pieces};
use serde_json::{Value, json};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(file) = arguments.first() else {
        eprintln!("describe: a file is needed; allowed is describe FILE [SCALE [PIECES]]");
        std::process::exit(2);
    };
    let number = |at: usize, default: &str| {
        arguments
            .get(at)
            .map_or(default, |text| text)
            .parse::<f64>()
    };
    let (Ok(scale), Ok(pieces)) = (number(1, "1"), number(2, "16")) else {
        eprintln!("describe: SCALE and PIECES are numbers");
        std::process::exit(2);
    };
    match describe(file, scale, pieces) {
        Ok(text) => println!("{text}"),
        Err(error) => {
            eprintln!("describe: {error}");
            std::process::exit(2);
        }
    }
}

fn describe(file: &str, scale: f64, pieces: f64) -> Result<Value, MeshError> {
    let path = Path::new(file);
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy())
        .unwrap_or_default();
    let mut folder = Folder::new(path.parent().unwrap_or(Path::new(".")));
    let clock = std::time::Instant::now();
    let solid = Solid::new(Arc::new(mesh::read(&name, scale, &mut folder)?))?;
    let read = clock.elapsed();
    let clock = std::time::Instant::now();
    let found = convex_pieces(&solid, pieces as usize);
    let cut = clock.elapsed();
    let bodies: Vec<Value> = found
        .pieces()
        .iter()
        .map(|piece| {
            let points = piece
                .body
                .points()
                .iter()
                .map(|point| json!((point + piece.middle).as_slice()));
            json!({ "points": points.collect::<Vec<_>>() })
        })
        .collect();
    Ok(json!({
        "triangles": solid.mesh().triangles().len(),
        "volume": solid.volume(),
        "centre": solid.centre().as_slice(),
        "inertia": solid.inertia().as_slice(),
        "pieces": bodies,
        "deviation": found.deviation(),
        "seconds": { "read": read.as_secs_f64(), "pieces": cut.as_secs_f64() },
    }))
}
