//! `fissure schema`: the JSON Schema (draft 7) of scene files, from the tables that the reader itself uses, so that editors
//! complete keys, show what they mean and underline what is wrong.

use std::process::ExitCode;

use fissure_engine::params::Range;
use fissure_engine::{Kind, Parameter, Registry};
use fissure_io::scene::{FREE, Fallback, Key, KeyKind, RIVALS, keys};
use serde_json::{Map, Value, json};

use crate::Error;
use crate::say::say;

pub(crate) fn command(registry: &Registry) -> Result<ExitCode, Error> {
    say!("{:#}", schema(registry));
    Ok(ExitCode::SUCCESS)
}

/// The schema, with the laws and criteria of `registry`.
pub(crate) fn schema(registry: &Registry) -> Value {
    let mut root = table("a Fissure scene");
    root["$schema"] = json!("http://json-schema.org/draft-07/schema#");
    root["title"] = json!("Fissure scene");
    for key in keys() {
        let (parent, name) = key.path.rsplit_once('.').unwrap_or(("", key.path));
        let place = at(&mut root, parent);
        match name {
            "NAME" => place["additionalProperties"] = of(key),
            _ => {
                place["properties"][name] = of(key);
                if key.default == Fallback::Required {
                    let required = place.as_object_mut().expect("a table").entry("required").or_insert(json!([]));
                    required.as_array_mut().expect("a list").push(json!(name));
                }
            }
        }
    }
    for (path, names) in RIVALS {
        let pairs = names.iter().enumerate().flat_map(|(k, a)| names[k + 1..].iter().map(move |b| [a, b]));
        let never: Vec<Value> = pairs.map(|pair| json!({ "not": { "required": pair } })).collect();
        let place = at(&mut root, path);
        place["allOf"]
            .as_array_mut()
            .map(|all| all.extend(never.clone()))
            .unwrap_or_else(|| place["allOf"] = json!(never));
    }
    for path in FREE {
        let laws: Vec<(&str, &[Parameter])> = if path.ends_with("material") {
            registry.entries().iter().map(|e| (e.name, e.parameters)).collect()
        } else {
            let all = registry.entries().iter().flat_map(|e| &e.criteria);
            let mut known: Vec<(&str, &[Parameter])> = Vec::new();
            all.for_each(|c| {
                if known.iter().all(|(name, _)| *name != c.name) {
                    known.push((c.name, c.parameters));
                }
            });
            known
        };
        choose(at(&mut root, path), if path.ends_with("material") { "law" } else { "criterion" }, &laws);
    }
    root
}

/// The schema of the table at `path`.
fn at<'a>(root: &'a mut Value, path: &str) -> &'a mut Value {
    path.split('.').filter(|part| !part.is_empty()).fold(root, |place, part| match part {
        "NAME" => &mut place["additionalProperties"],
        "N" => &mut place["items"],
        name => &mut place["properties"][name],
    })
}

/// Further keys of `place` belong to the one that `word` chooses.
fn choose(place: &mut Value, word: &str, known: &[(&str, &[Parameter])]) {
    let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
    let own = place["properties"].as_object().cloned().unwrap_or_default();
    if let Some(choice) = place["properties"].get_mut(word) {
        choice["enum"] = json!(names);
    }
    // all keys at once for completion; which of them may be together is for the conditions
    let mut all = own.clone();
    let mut conditions = Vec::new();
    for (name, parameters) in known {
        let mut properties: Map<String, Value> = own.iter().map(|(key, _)| (key.clone(), json!(true))).collect();
        for p in *parameters {
            properties.insert(p.name.into(), parameter(p));
            all.entry(p.name).or_insert_with(|| json!({ "description": p.about }));
        }
        let required: Vec<&str> =
            parameters.iter().filter(|p| matches!(p.kind, Kind::Number(_))).map(|p| p.name).collect();
        conditions.push(json!({
            "if": { "properties": { word: { "const": name } }, "required": [word] },
            "then": { "properties": properties, "required": required, "additionalProperties": false },
        }));
    }
    if let Some(choice) = place["properties"].get(word).cloned() {
        all.insert(word.into(), choice);
    }
    place["properties"] = Value::Object(all);
    place["allOf"] = json!(conditions);
}

fn table(about: &str) -> Value {
    json!({ "type": "object", "description": about, "properties": {}, "additionalProperties": false })
}

fn number(range: Range) -> Value {
    let mut schema = json!({ "type": "number" });
    let ends = [("minimum", "exclusiveMinimum", range.low), ("maximum", "exclusiveMaximum", range.high)];
    for (closed, open, (end, belongs)) in ends {
        if end.is_finite() {
            schema[if belongs { closed } else { open }] = json!(end);
        }
    }
    schema
}

fn list(items: Value, least: usize, most: Option<usize>) -> Value {
    let mut schema = json!({ "type": "array", "items": items, "minItems": least });
    if let Some(most) = most {
        schema["maxItems"] = json!(most);
    }
    schema
}

fn of(key: &Key) -> Value {
    let any = || json!({ "type": "number" });
    let mut schema = match key.kind {
        KeyKind::Text => json!({ "type": "string" }),
        KeyKind::Word(words) => json!({ "enum": words }),
        KeyKind::Words(words) => json!({ "type": "array", "items": { "enum": words }, "uniqueItems": true }),
        KeyKind::Number(range) => number(range),
        KeyKind::NumberOr(range, word) => json!({ "anyOf": [{ "const": word }, number(range)] }),
        KeyKind::Whole(low, high) => json!({ "type": "integer", "minimum": low, "maximum": high }),
        KeyKind::Yes => json!({ "const": true }),
        KeyKind::Three(range) => list(number(range), 3, Some(3)),
        KeyKind::Direction => list(any(), 3, Some(3)),
        KeyKind::Points(n) => list(list(any(), 3, Some(3)), n, Some(n)),
        KeyKind::Profile => list(list(any(), 2, Some(2)), 2, None),
        KeyKind::Table => table(key.about),
        KeyKind::Tables => json!({ "type": "array", "items": table(key.about) }),
    };
    schema["description"] = json!(format!("{}{}", key.about, key.unit_suffix()));
    match key.default {
        Fallback::Required => {}
        Fallback::Toml(text) => schema["description"] = json!(format!("{}; default {text}", described(&schema))),
        Fallback::Said(words) => schema["description"] = json!(format!("{}; left out: {words}", described(&schema))),
    }
    schema
}

fn described(schema: &Value) -> &str {
    schema["description"].as_str().unwrap_or_default()
}

fn parameter(p: &Parameter) -> Value {
    let any = || json!({ "type": "number" });
    let (mut schema, default) = match p.kind {
        Kind::Number(range) | Kind::OptionalNumber(range) => (number(range), None),
        Kind::NumberOr(range, default) => (number(range), Some(json!(default))),
        Kind::Word(words) => (json!({ "enum": words }), words.first().map(|w| json!(w))),
        Kind::Matrix => (json!({ "anyOf": [list(any(), 3, Some(3)), list(any(), 9, Some(9))] }), None),
        Kind::Vector(default) => (list(any(), 3, Some(3)), Some(json!(default))),
    };
    let unit = if p.unit == "1" { String::new() } else { format!(" [{}]", p.unit) };
    schema["description"] = json!(format!("{}{unit}", p.about));
    if let Some(default) = default {
        schema["default"] = default;
    }
    schema
}
