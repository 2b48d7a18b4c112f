#pragma once
// A file that says which columns of which CSV files are drawn: `grouser plot FIGURES.yaml`.
#include <filesystem>

#include "figure_page.h"

namespace grouser::report {

/// title: ..., summary: ..., items: a list of
///   plot: {title, x_label, y_label, caption, log_x, log_y, series: [...]}
///     a series: {file: results.csv, x: column, y: column, error: column, name, style: line|dashed|points, colour: 0..7,
///                x_scale, y_scale (error too) [1], where: {column: value}, each: column}
///     `where` keeps the rows whose cells equal the values (as numbers where both are numbers); `each` draws one series
///     per value of that column, in the file's order, and `{}` in the name becomes that value.
///   table: {title, file, columns: [...], heads: [...], where: {...}, digits: 1..15}   default: every column, as typed
///   text: ...
/// File names are relative to the YAML file. An empty cell or nan is a gap.
/// @throws ConfigError with every error of the file at line and column: unknown keys and columns (with the nearest name),
/// missing or malformed CSV files, cells that are not numbers, `where` that no row meets
FigurePage read_figures(const std::filesystem::path& yaml);

}  // namespace grouser::report
