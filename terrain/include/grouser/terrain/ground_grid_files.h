#pragma once
// Readers of height maps. The first row of a file is the one with the largest y, as on a map.
#include <filesystem>
#include <optional>

#include "grouser/terrain/ground_grid.h"

namespace grouser {

/// 16-bit greyscale PNG: 0 -> lowest, 65535 -> highest [m]; pixel centres are nodes `spacing` [m] apart; lower left
/// node at (0, 0).
/// @throws ConfigError naming the file: not a PNG, not 16-bit grey, damaged, smaller than 2 x 2.
HeightGrid read_height_png(const std::filesystem::path& file, double spacing, double lowest, double highest);

/// ESRI ASCII grid: ncols, nrows, xllcorner | xllcenter, yllcorner | yllcenter, cellsize, optional NODATA_value;
/// lengths in m; heights times `height_unit` [m].
/// @throws ConfigError with line and column: wrong header, wrong number of cells, a cell that is no number or no data.
HeightGrid read_height_esri(const std::filesystem::path& file, double height_unit = 1.0);

/// Comma-separated heights times `height_unit` [m], no header ('#' starts a comment line); nodes `spacing` [m] apart;
/// lower left node at (0, 0).
/// @throws ConfigError with line and column: ragged rows, a cell that is empty or no finite number.
HeightGrid read_height_csv(const std::filesystem::path& file, double spacing, double height_unit);

}  // namespace grouser
