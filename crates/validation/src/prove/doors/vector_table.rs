//! The readings of a session with one displacement gauge, value for value, as readings of forces and displacements as vectors.

use std::collections::HashMap;

use crate::prove::error::ProveError;

/// Columns that both tables have.
const SHARED_BEFORE: &str =
    "session,seq,utc,t_s,pose,direction,branch,step,target_N,repeat,attempt,run,zero_id";
const SHARED_AFTER: &str = "hold_s,temp_degC,status,flag,note";

/// What is written of a gauge: value, text as received, zero.
const FORCE: [&str; 2] = ["force_raw", "force_zero_N"];
const DISPLACEMENT: [&str; 3] = ["um", "raw", "zero_um"];

/// The table of vectors with the same readings as a session.
///
/// Runs and zeros without a name are those of a pose, direction and repeat.
///
/// # Arguments
/// - `readings`: `readings.csv` of a session with loads along x, y and z.
///
/// # Errors
/// [`ProveError::Form`] for what is no such table.
pub fn vector_table(readings: &str) -> Result<String, ProveError> {
    let form = |problem: String| ProveError::Form {
        file: "readings.csv".to_owned(),
        problem,
    };
    let wrong = |error: csv::Error| form(error.to_string());
    let mut reader = csv::Reader::from_reader(readings.as_bytes());
    let heads = reader.headers().map_err(wrong)?.clone();
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns()).map_err(wrong)?;
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        let cells: HashMap<&str, &str> = heads.iter().zip(record.iter()).collect();
        let cell = |name: &str| cells.get(name).copied().unwrap_or_default();
        let (direction, repeat) = (cell("direction"), cell("repeat"));
        let run = format!("{}.{direction}.{repeat}", cell("pose"));
        let shared = |name: &str| match (name, cell(name)) {
            ("run" | "zero_id", "") => run.clone(),
            ("attempt", "") => "1".to_owned(),
            (_, value) => value.to_owned(),
        };
        let mut row: Vec<String> = SHARED_BEFORE.split(',').map(shared).collect();
        row.push("base".to_owned());
        let force = |axis: &str| {
            if axis == direction {
                cell("force_N")
            } else {
                "0"
            }
        };
        row.extend(["x", "y", "z"].map(|axis| force(axis).to_owned()));
        row.extend(FORCE.map(|name| cell(name).to_owned()));
        for axis in ["x", "y", "z"] {
            let along = axis == direction;
            row.extend(DISPLACEMENT.map(|name| {
                let value = if along {
                    cell(&format!("displacement_{name}"))
                } else {
                    ""
                };
                value.to_owned()
            }));
        }
        row.extend(SHARED_AFTER.split(',').map(shared));
        writer.write_record(row).map_err(wrong)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| form(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| form(error.to_string()))
}

fn columns() -> Vec<String> {
    let names = |list: &str| list.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut columns = names(SHARED_BEFORE);
    columns.extend(names("axes,force_x_N,force_y_N,force_z_N"));
    columns.extend(FORCE.map(str::to_owned));
    for axis in ["x", "y", "z"] {
        columns.extend(DISPLACEMENT.map(|name| format!("displacement_{axis}_{name}")));
    }
    columns.extend(names(SHARED_AFTER));
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_keeps_every_value() {
        let session = "session,seq,t_s,pose,direction,branch,step,target_N,repeat,run,force_N,force_raw,force_zero_N,displacement_um,\
             displacement_raw,displacement_zero_um,hold_s,status,origin\n\
             s,1,62.4,P1,y,loading,1,-10,2,,-9.5,-9.6,0.1,-1272,-1271,1,5.6,accepted,\"a, b\"\n";
        let table = vector_table(session).unwrap();
        let [heads, row] = [0, 1].map(|line| {
            let line = table.lines().nth(line).unwrap();
            line.split(',').map(str::to_owned).collect::<Vec<_>>()
        });
        assert_eq!(heads.len(), row.len());
        let cells: Vec<String> = (heads.iter().zip(&row))
            .filter(|(_, cell)| !cell.is_empty())
            .map(|(head, cell)| format!("{head}={cell}"))
            .collect();
        assert_eq!(
            cells.join(" "),
            "session=s seq=1 t_s=62.4 pose=P1 direction=y branch=loading step=1 target_N=-10 repeat=2 attempt=1 run=P1.y.2 zero_id=P1.y.2 \
             axes=base force_x_N=0 force_y_N=-9.5 force_z_N=0 force_raw=-9.6 force_zero_N=0.1 displacement_y_um=-1272 displacement_y_raw=-1271 \
             displacement_y_zero_um=1 hold_s=5.6 status=accepted"
        );
    }
}
