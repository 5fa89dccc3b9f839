//! Of many further columns only the strongest take part in the search: products of all of them would need memory that
//! grows with their square. Each is judged by what it explains alone, of what angle, time, direction and temperature
//! leave; what only shows in a product of two columns is lost where neither of them shows. A column that is kept
//! stands for as many as it was chosen from, and must be that much less likely by chance.

use numerics::{Basis, Columns, dot, parallel};

use super::{Scaled, Setting, saturated, varying};
use crate::base::base_columns;
use crate::calibrate::log_tail;
use crate::explain::first_order;
use crate::rows::Rows;
use crate::thresholds::generic::screen::MOST_COLUMNS;

/// Keeps the strongest further columns in their order, and says how many there were.
pub fn keep_strongest_columns(rows: &mut Rows) {
    let count = rows.extra.len();
    if count <= MOST_COLUMNS {
        return;
    }
    let columns = std::mem::take(&mut rows.extra);
    let mut basis = Basis::new(rows.len());
    for column in saturated(rows, &base_columns(rows, first_order(rows))) {
        basis.add(&column);
    }
    let mut left = rows.error.clone();
    basis.project_off(&mut left);
    let free = (rows.len() as f64 - basis.rank() as f64).max(1.0);
    let level = (dot(&left, &left) / free).max(f64::MIN_POSITIVE);
    let setting = Setting::of(rows);
    let strength = |observable: Scaled| -> f64 {
        let families = setting.about(&observable);
        let groups = families.iter().flat_map(|(_, groups)| groups);
        groups.map(|group| explained(group, &basis, &left, level)).fold(0.0, f64::max)
    };
    let strengths: Vec<f64> = parallel::map(&columns, |c| varying(&c.name, &c.values).map_or(0.0, strength));
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| strengths[*b].total_cmp(&strengths[*a]));
    order.truncate(MOST_COLUMNS);
    rows.extra = columns
        .into_iter()
        .enumerate()
        .filter(|(k, _)| order.contains(k))
        .map(|(_, column)| column)
        .collect();
    rows.not_testable.push(format!(
        "{count} further columns are more than are searched: the {MOST_COLUMNS} strongest took part; drop columns \
         that cannot matter to have all others tried"
    ));
    rows.further_columns = count;
}

/// −ln of the probability that columns of noise explain as much of what is left beside `basis`, of that level.
fn explained(group: &[Vec<f64>], basis: &Basis, left: &[f64], level: f64) -> f64 {
    let mut columns = Columns::new(left.len());
    group.iter().for_each(|column| columns.push(column));
    columns.project_off(&basis.columns);
    let mut own = Basis::new(left.len());
    (0..columns.count()).for_each(|k| {
        own.add(columns.get(k));
    });
    let explained: f64 = (0..own.rank()).map(|k| dot(own.columns.get(k), left).powi(2)).sum();
    log_tail(explained / level, own.rank())
}
