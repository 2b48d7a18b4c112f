#pragma once
#include <nlohmann/json.hpp>

#include "grouser/terrain/csv.h"

namespace grouser::report {

/// @throws ConfigError with every error of the file.
CsvRecords read_table(const std::filesystem::path& file);
/// {columns: [...], rows: [[...]], notes: [...]}; a cell that is a finite number becomes one, an empty cell or nan
/// null.
nlohmann::json to_json(const CsvRecords& t);

}  // namespace grouser::report
