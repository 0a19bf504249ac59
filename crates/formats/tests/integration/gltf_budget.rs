//! glTF files made of references are refused before anything is decoded.

use crate::common::read_alone;
use greenstick_formats::Format;
use serde_json::{Value, json};

/// A document with an accessor of `count` positions that no buffer backs, and meshes of primitives that refer to it.
fn unbacked(count: usize, accessors: usize, meshes: Value) -> Vec<u8> {
    let accessor = json!({"componentType": 5126, "count": count, "type": "VEC3"});
    let placed = meshes.as_array().unwrap().len();
    json!({
        "asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": (0..placed).collect::<Vec<_>>()}],
        "nodes": (0..placed).map(|i| json!({"mesh": i})).collect::<Vec<_>>(),
        "meshes": meshes,
        "accessors": vec![accessor; accessors],
    })
    .to_string()
    .into_bytes()
}

fn refusal(bytes: &[u8]) -> String {
    let started = std::time::Instant::now();
    let error = read_alone(Format::Gltf, bytes).unwrap_err().to_string();
    assert!(started.elapsed().as_secs_f64() < 2.0, "{error}");
    error
}

#[test]
fn accessors_that_nothing_backs_count_in_full() {
    // 19 kB that took 402 MB.
    let meshes: Vec<Value> = (0..16)
        .map(|i| json!({"primitives": [{"attributes": {"POSITION": i}}]}))
        .collect();
    let error = refusal(&unbacked(1 << 20, 16, meshes.into()));
    assert!(
        error.contains("meshes[0]") && error.contains("once decoded") && error.contains("at most"),
        "{error}"
    );
}

#[test]
fn primitives_that_repeat_indices_count_each_time() {
    // 20,000 primitives, each with the same 3,000 corners of its own.
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
    let mut document: Value = serde_json::from_slice(&unbacked(
        3,
        1,
        json!([{"primitives": vec![primitive; 20_000]}]),
    ))
    .unwrap();
    let accessors = document["accessors"].as_array_mut().unwrap();
    accessors.push(json!({"componentType": 5125, "count": 3000, "type": "SCALAR"}));
    let error = refusal(&document.to_string().into_bytes());
    assert!(error.contains("320000"), "{error}");
}

#[test]
fn lists_of_empty_objects_are_refused_unparsed() {
    let nodes = vec!["{}"; 1_000_000].join(",");
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}]}}"#);
    let error = refusal(text.as_bytes());
    assert!(
        error.contains("JSON") && error.contains("objects in"),
        "{error}"
    );
}
