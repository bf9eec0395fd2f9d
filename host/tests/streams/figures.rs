//! The figures of docs/results/live.json.

use serde_json::{Value, json};
use std::path::Path;

/// A figure to a tenth; a whole one without a point.
pub fn tenths(value: f64) -> Value {
    let tenths = (10.0 * value).round();
    if tenths % 10.0 == 0.0 {
        json!((tenths / 10.0) as i64)
    } else {
        json!(tenths / 10.0)
    }
}

/// A table of figures.
pub struct Table {
    columns: Vec<&'static str>,
    pub rows: Vec<Value>,
}

impl Table {
    pub fn new(columns: &[&'static str]) -> Self {
        Self {
            columns: columns.to_vec(),
            rows: Vec::new(),
        }
    }

    /// With `RIDGETONE_WRITE=1`, replaces the table of this name.
    pub fn write(self, name: &str) {
        if std::env::var_os("RIDGETONE_WRITE").is_none() {
            return;
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/live.json");
        let text = std::fs::read_to_string(&path).unwrap_or_else(|_| r#"{"tables":{}}"#.into());
        let mut all: Value = serde_json::from_str(&text).expect("JSON");
        all["tables"][name] = json!({ "columns": self.columns, "rows": self.rows });
        let text = all.to_string().replace("],[", "],\n[") + "\n";
        std::fs::write(path, text).expect("written");
    }
}
